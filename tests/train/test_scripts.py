"""The scripts, end to end and tiny: train, kill, resume, load, fly, evaluate."""

import csv
import importlib.util
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import gymnasium as gym
import numpy as np
import pytest

from ftac_gym import baselines, scenarios
from ftac_gym.agents.agent import Agent
from ftac_gym.agents.shipped import SHIPPED
from ftac_gym.evaluation import evaluate, rollout
from ftac_gym.evaluation.compare import TABLE_METRICS
from ftac_gym.evaluation.metrics import UNITS
from ftac_gym.scenarios import frozen
from ftac_gym.task.objective import RewardWeights

SCRIPTS = Path(__file__).parents[2] / "train"
SHORT = scenarios.get("flagship").replace(duration=3.0)
# 8 craft and rollouts of 32 steps: 256 steps to a rollout.
END = (
    "--checkpoint-every",
    "512",
    "--evaluate-every",
    "100000000",
    "--evaluation-episodes",
    "2",
    "--torch-threads",
    "1",
)
TINY = ("--critic-warmup", "0",
    "--num-envs", "8", "--hyperparameters", "n_steps=32", "batch_size=128", "--checkpoint-every", "512",
    "--evaluate-every", "100000000", "--torch-threads", "1",
)  # fmt: skip


def command(script, *arguments):
    return [sys.executable, str(SCRIPTS / script), *map(str, arguments)]


def run(script, *arguments, folder):
    """Run a script to its end, in a folder of its own."""
    return subprocess.run(command(script, *arguments), cwd=folder, capture_output=True, text=True, timeout=120)


def module_of(script):
    """Import a script without running it."""
    spec = importlib.util.spec_from_file_location(f"script_{script}", SCRIPTS / f"{script}.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A run that was left alone."""
    folder = tmp_path_factory.mktemp("whole")
    arguments = ("--run-folder", "run", "--total-steps", 2048, *TINY, "--evaluate-every", 1024)
    result = run("train.py", *arguments, "--evaluation-episodes", 2, folder=folder)
    assert result.returncode == 0, result.stderr
    assert "is in run/agent" in result.stdout
    return folder / "run"


@pytest.fixture(scope="module")
def resumed(tmp_path_factory):
    """A run that was killed after its first checkpoint, and resumed for 512 steps; its folder, and where it stood."""
    folder = tmp_path_factory.mktemp("resumed")
    arguments = ("--run-folder", "run", "--wrappers", "--observation", "telemetry", *TINY)
    process = subprocess.Popen(
        command("train.py", *arguments, "--total-steps", 100_000_000), cwd=folder,
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    try:
        deadline = time.monotonic() + 90.0
        while not list((folder / "run" / "checkpoints").glob("[0-9]" * 10)):
            assert process.poll() is None and time.monotonic() < deadline
            time.sleep(0.05)
    finally:
        os.kill(process.pid, signal.SIGKILL)
        process.wait()
    last = max(int(path.name) for path in (folder / "run" / "checkpoints").glob("[0-9]" * 10))
    # What a kill in the middle of writing leaves behind must not be mistaken for a checkpoint.
    (folder / "run" / "checkpoints" / f"{last + 512:010d}.partial").mkdir(exist_ok=True)
    result = run("train.py", *arguments, "--total-steps", last + 512, "--resume", folder=folder)
    assert result.returncode == 0, result.stderr
    return folder / "run", last


def files_of(folder):
    return sorted(path.name for path in folder.iterdir())


# --------------------------------------------------------------------------------------------------------------- train


def test_a_run_writes_checkpoints_and_an_agent(whole):
    parts = ["card.json", "model.zip", "normalizer.pkl"]
    assert files_of(whole / "agent") == parts
    checkpoints = whole / "checkpoints"
    assert files_of(checkpoints) == [f"{steps:010d}" for steps in (512, 1024, 1536, 2048)]
    assert all(files_of(path) == parts for path in checkpoints.iterdir())
    config = json.loads((whole / "config.json").read_text())
    assert config["num_envs"] == 8 and config["hyperparameters"] == ["n_steps=32", "batch_size=128"]
    assert list((whole / "tensorboard").rglob("events.out.tfevents.*"))


def test_evaluations_along_the_way(whole):
    with (whole / "evaluations.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [int(row["steps"]) for row in rows] == [1024, 2048]
    assert set(rows[0]) >= {"steps", *UNITS}
    # The weights of the reward are those of the training.
    task = scenarios.get("flagship").replace(reward=RewardWeights(on_target=1.0))
    metrics = rollout(task, str(whole / "checkpoints" / "0000001024"), seed=900_000, count=2).metrics()
    assert float(rows[0]["return"]) == pytest.approx(np.median(metrics["return"]), rel=1e-4)


def test_the_card_says_how_the_agent_was_made(whole):
    card = json.loads((whole / "agent" / "card.json").read_text())
    assert card["steps"] == 2048 and card["environment"] == "SpacecraftFTC-v0" and card["seed"] == 0
    _, (name, arguments) = card["interface"]["wrappers"]
    assert name == "ResidualPolicy" and arguments["base"] == "pd_dob" and card["interface"]["observation"] == "attitude"
    # All gains of the base are written down.
    assert arguments.items() >= baselines.defaults("pd_dob").items()
    assert card["normalized"] and card["algorithm"] == "ppo" and card["training_seconds"] >= 0
    for words in ("--num-envs 8", "--total-steps 2048", "--hyperparameters n_steps=32 batch_size=128"):
        assert words in card["command"]
    assert json.loads((whole / "checkpoints" / "0000000512" / "card.json").read_text())["steps"] == 512


def test_a_killed_run_goes_on_from_its_last_checkpoint(resumed):
    folder, last = resumed
    card = json.loads((folder / "agent" / "card.json").read_text())
    assert card["steps"] == last + 512
    assert card["interface"]["wrappers"] == [] and card["interface"]["observation"] == "telemetry"
    before, after = Agent.load(folder / "checkpoints" / f"{last:010d}"), Agent.load(folder / "agent")
    assert (before.model.num_timesteps, after.model.num_timesteps) == (last, last + 512)
    # The statistics of the normaliser went on too, and the network learned.
    gained = after.normalizer.obs_rms.count - before.normalizer.obs_rms.count
    assert 512 <= gained <= 512 + 3 * 8
    weights = [agent.model.policy.state_dict()["action_net.weight"].numpy() for agent in (before, after)]
    assert (weights[0] != weights[1]).any()


def test_a_run_is_not_overwritten(whole):
    train = module_of("train")
    before = (whole / "agent" / "model.zip").read_bytes()
    with pytest.raises(SystemExit, match=r"holds a run already; choose another --run-folder, or --resume it"):
        train.main(train.Config(run_folder=whole))
    assert (whole / "agent" / "model.zip").read_bytes() == before


def test_nothing_to_resume(tmp_path):
    train = module_of("train")
    with pytest.raises(SystemExit, match="--resume: no checkpoint under"):
        train.main(train.Config(run_folder=tmp_path, resume=True))


def test_a_resumed_run_keeps_its_settings(resumed):
    train = module_of("train")
    folder, _ = resumed
    kept = train.resumed(train.Config(run_folder=folder, resume=True))
    assert kept.wrappers == () and kept.observation == "telemetry" and "n_steps=32" in kept.hyperparameters
    longer = train.resumed(train.Config(run_folder=folder, resume=True, total_steps=123))
    assert longer.total_steps == 123
    with pytest.raises(SystemExit, match="--resume: the run was started with --num-envs 8, got 9"):
        train.resumed(train.Config(run_folder=folder, resume=True, num_envs=9))


@pytest.mark.parametrize("algorithm", ["recurrent_ppo", "sac", "tqc"])
def test_every_algorithm_trains_resumes_and_flies(algorithm, tmp_path):
    on_policy = algorithm == "recurrent_ppo"
    settings = (
        ("n_steps=16", "batch_size=64") if on_policy else ("buffer_size=2000", "learning_starts=64", "batch_size=64")
    )
    arguments = ("--run-folder", "run", "--algo", algorithm, "--num-envs", 8, "--hyperparameters", *settings, *END)
    first = run("train.py", *arguments, "--total-steps", 256, folder=tmp_path)
    assert first.returncode == 0, first.stderr
    again = run("train.py", *arguments, "--total-steps", 512, "--resume", folder=tmp_path)
    assert again.returncode == 0, again.stderr
    agent = Agent.load(tmp_path / "run" / "agent")
    assert type(agent.model).__name__.lower() == algorithm.replace("_", "")
    episodes = SHORT.draw(1, 3)
    history = rollout(SHORT, agent, episodes)
    assert np.isfinite(history.command).all()
    np.testing.assert_allclose(rollout(SHORT, agent, episodes[1]).command[:, 0], history.command[:, 1], atol=1e-5)


def test_the_curriculum_holds_from_the_first_episode_on(tmp_path, monkeypatch):
    """Stable-Baselines3 draws the first episodes before it calls any callback."""
    train, seen = module_of("train"), []
    small = {"num_envs": 2, "hyperparameters": ("n_steps=32", "batch_size=64"), "severity_start": 0.25}

    def learn(model, *_, **__):
        seen.append(model.get_env().get_attr("scenario")[0].faults.severity)
        raise KeyboardInterrupt

    monkeypatch.setattr("stable_baselines3.PPO.learn", learn)
    with pytest.raises(KeyboardInterrupt):
        train.main(train.Config(run_folder=tmp_path / "run", **small))
    assert seen == [0.25]
    fixed = train.Config(
        run_folder=tmp_path / "fixed", env_id="SpacecraftFTCMa2023-v0", scenario="ma_2023_faulty", wrappers=(), **small
    )
    with pytest.raises(SystemExit, match=r"--faults must be a FaultDistribution to have a severity"):
        train.main(fixed)
    assert not (tmp_path / "fixed").exists()


def test_the_study_tabulates_agents_that_are_trained(tmp_path):
    """With the shipped agents as two seeds of a combination, a third of which is not asked for."""
    study = module_of("study")
    for seed in range(3):
        home = tmp_path / "runs" / "residual_none" / f"seed_{seed}"
        shutil.copytree(SHIPPED / "flagship_residual" / f"seed_{seed}", home / "agent")
        (home / "checkpoints" / "0001000000").mkdir(parents=True)
    study.main(
        study.Config(
            seeds=2,
            workers=1,
            episodes=4,
            actions=("residual",),
            memories=("none",),
            folder=tmp_path / "runs",
            output=tmp_path / "study",
        )
    )
    report = (tmp_path / "study" / "report.md").read_text()
    episodes = frozen.load("flagship", 4)
    chatter = [
        rollout("flagship", str(SHIPPED / "flagship_residual" / f"seed_{seed}"), episodes).metrics()["chatter"]
        for seed in range(2)
    ]
    base = rollout("flagship", "pd_dob", episodes).metrics()["chatter"]
    feasible = episodes.feasible
    (row,) = [
        line for line in report.split("Mean paired")[1].splitlines() if line.startswith("| residual | none | 2 |")
    ]
    expected = np.mean([item[feasible].mean() for item in chatter]) - base[feasible].mean()
    assert float(row.split("|")[7].split()[0]) == pytest.approx(expected, rel=5e-3)


def test_several_seeds(tmp_path):
    arguments = (
        "--run-folder",
        "runs",
        "--seeds",
        2,
        "--seed",
        3,
        "--total-steps",
        256,
        *TINY,
        "--evaluation-episodes",
        2,
    )
    result = run("train.py", *arguments, folder=tmp_path)
    assert result.returncode == 0, result.stderr
    agents = [tmp_path / "runs" / f"seed_{seed}" / "agent" for seed in (3, 4)]
    assert [json.loads((path / "card.json").read_text())["seed"] for path in agents] == [3, 4]
    assert "--seed 4" in json.loads((agents[1] / "card.json").read_text())["command"]
    weights = [Agent.load(path).model.policy.state_dict()["mlp_extractor.value_net.0.weight"] for path in agents]
    assert (weights[0] != weights[1]).any()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"wrappers": ("Residual",)}, r"--wrappers must be among .*'ResidualPolicy'.*got 'Residual'"),
        ({"wrappers": ("ResidualPolicy base",)}, r"--wrappers must be words NAME=VALUE, got 'base'"),
        ({"env_id": "CartPole-v1"}, r"--env_id must be an environment of ftac_gym, got 'CartPole-v1'"),
        ({"algo": "sac", "critic_sees_faults": True}, r"--critic_sees_faults must go with ppo, got 'sac'"),
        ({"hyperparameters": ("n_steps",)}, r"--hyperparameters must be words NAME=VALUE, got 'n_steps'"),
        ({"hyperparameters": ("learning_rate=fast",)}, r"--learning_rate must be a number or lin_NUMBER, got 'fast'"),
        ({"hyperparameters": ("n_step=32",)}, r"--wrappers or --hyperparameters: .*n_step"),
        ({"seeds": 0}, r"--seeds must be positive, got 0"),
        ({"hold": 0}, r"--hold must be a positive integer, got 0"),
        ({"scenario": "cao_2022"}, r"--scenario must have the observation space"),
        ({"evaluation_seed": 12_000}, r"--evaluation_seed must not be of the frozen test episodes"),
        ({"seeds": 2, "resume": True}, r"--resume: no checkpoint under"),
    ],
)  # fmt: skip
def test_train_refuses(arguments, message, tmp_path):
    train = module_of("train")
    with pytest.raises(SystemExit, match=message):
        train.main(train.Config(run_folder=tmp_path / "run", num_envs=2, **arguments))
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize("script", ["train", "evaluate", "tune", "study"])
def test_help(script, tmp_path):
    result = run(f"{script}.py", "--help", folder=tmp_path)
    assert result.returncode == 0 and "usage" in result.stdout.lower()
    assert not list(tmp_path.iterdir())


# --------------------------------------------------------------------------------------------------------------- agent


@pytest.mark.parametrize("kind", ["residual", "direct"])
def test_an_agent_loads_and_flies(kind, whole, resumed):
    folder = (whole if kind == "residual" else resumed[0]) / "agent"
    episodes = SHORT.draw(1, 3)
    history = rollout(SHORT, Agent.load(folder), episodes)
    assert np.isfinite(history.attitude_error).all() and (np.abs(history.command) > 0.0).any()
    again = rollout(SHORT, str(folder), episodes)
    np.testing.assert_array_equal(again.command, history.command)
    alone = rollout(SHORT, str(folder), episodes[1])
    np.testing.assert_allclose(alone.command[:, 0], history.command[:, 1], atol=1e-5)
    assert evaluate(SHORT, str(folder), episodes, name="agent").policy == "agent"


def test_a_barely_trained_residual_stays_close_to_its_base(whole):
    episodes = SHORT.draw(1, 4)
    agent, base = (rollout(SHORT, policy, episodes).command for policy in (str(whole / "agent"), "pd_dob"))
    assert (agent != base).any()
    assert np.abs(agent - base).mean() < 0.1 * SHORT.spacecraft.wheels.torque_limits.max()


def test_the_normaliser_of_a_loaded_agent_stands_still(whole):
    agent = Agent.load(whole / "agent")
    count = agent.normalizer.obs_rms.count
    rollout(SHORT, agent, seed=0, count=2)
    assert agent.normalizer.obs_rms.count == count


def test_fingerprints_tell_agents_apart(whole, resumed):
    prints = [Agent.load(path).fingerprint for path in (whole / "agent", whole / "checkpoints" / "0000000512")]
    assert len({*prints, Agent.load(resumed[0] / "agent").fingerprint}) == 3
    assert Agent.load(whole / "agent" / "model.zip").fingerprint == prints[0]


def test_what_is_no_agent(tmp_path, whole):
    with pytest.raises(ValueError, match=r"agent must be a folder with model\.zip, or a zip file"):
        Agent.load(tmp_path)
    with pytest.raises(ValueError, match=r"policy must be one of .* or the path of an agent"):
        rollout(SHORT, str(tmp_path / "missing"))
    env = gym.make_vec("SpacecraftFTC-v0", num_envs=2, observation="oracle")
    with pytest.raises(
        ValueError, match=r"agent must have been trained on observations of \d+ entries, as flagship gives"
    ):
        Agent.load(whole / "agent").attach(env)
    # A normaliser that the card speaks of must be there: without it the agent would fly, and badly.
    bare = tmp_path / "bare"
    shutil.copytree(whole / "agent", bare)
    (bare / "normalizer.pkl").unlink()
    with pytest.raises(ValueError, match=r"agent must have normalizer\.pkl beside it"):
        Agent.load(bare)
    card = json.loads((bare / "card.json").read_text())
    (bare / "card.json").write_text(json.dumps({**card, "interface": {"base": "pd_dob"}}))
    with pytest.raises(ValueError, match=r"card\.json must be of this version.*train the agent again"):
        Agent.load(bare)


# ------------------------------------------------------------------------------------------------------------ evaluate


def test_evaluate(tmp_path):
    arguments = ("--policies", "pd", "pd_dob", "--reference", "pd", "--episodes", 6, "--output", tmp_path / "results")
    result = run("evaluate.py", *arguments, "--splits", "flagship_unseen", folder=tmp_path)
    assert result.returncode == 0, result.stderr
    assert "by split" in result.stdout and "flagship_unseen" in result.stdout
    folder = tmp_path / "results" / "flagship"
    for name in ("error_bands.png", "episode.png", "fault_kinds.png"):
        assert (folder / name).read_bytes().startswith(b"\x89PNG") and (folder / name).stat().st_size > 10_000
    report = (folder / "report.md").read_text()
    assert report.startswith("# flagship: pd, pd_dob")
    assert "![episode](episode.png)" in report and "![error bands](error_bands.png)" in report
    assert "![fault kinds](fault_kinds.png)" in report and "| flagship_unseen | 6 |" in report
    with (folder / "episodes.csv").open() as file:
        rows = list(csv.DictReader(file))
    episodes = frozen.load("flagship", 6)
    assert [(row["policy"], int(row["episode"])) for row in rows] == [
        (p, k) for p in ("pd", "pd_dob") for k in range(len(episodes))
    ]
    metrics = rollout("flagship", "pd", episodes).metrics()
    for metric in UNITS:
        written = [float(row[metric]) for row in rows[: len(episodes)]]
        np.testing.assert_allclose(written, metrics[metric], rtol=1e-4, atol=1e-9, err_msg=metric)
    with (folder / "summary.csv").open() as file:
        summary = {(row["policy"], row["metric"], row["kind"]): float(row["value"]) for row in csv.DictReader(file)}
    absent = ("bound_kept", "bound_margin", "jitter", "modal_energy", "residual_energy", "vibration_torque")
    shown = [metric for metric in TABLE_METRICS if metric not in absent]
    assert {metric for _, metric, _ in summary} == set(shown) and len(summary) == 3 * len(shown)
    assert summary["pd", "success", "estimate"] == pytest.approx(metrics["success"][episodes.feasible].mean())
    with (tmp_path / "results" / "flagship_unseen" / "episodes.csv").open() as file:
        assert {row["policy"] for row in csv.DictReader(file)} == {"pd", "pd_dob"}
    # A second call finds the finished batches and comes to the same.
    batches = {path: path.stat().st_mtime_ns for path in (folder / "batches").iterdir()}
    evaluation = module_of("evaluate")
    evaluation.main(
        evaluation.Config(
            policies=("pd", "pd_dob"),
            reference="pd",
            splits=("flagship_unseen",),
            episodes=6,
            output=tmp_path / "results",
        )
    )
    assert {path: path.stat().st_mtime_ns for path in (folder / "batches").iterdir()} == batches and len(batches) == 2
    assert (folder / "report.md").read_text() == report


def test_evaluate_with_a_seed_draws_other_episodes(tmp_path):
    evaluation = module_of("evaluate")
    drawn = evaluation.draw(evaluation.Config(seed=3, episodes=5), "flagship")
    assert drawn.feasible.sum() == 5
    np.testing.assert_array_equal(drawn.faults, scenarios.get("flagship").draw(3, len(drawn)).faults)
    with pytest.raises(SystemExit, match=r"--episodes: feasible must be within \[1, 500\], got 501"):
        evaluation.draw(evaluation.Config(episodes=501), "flagship")


@pytest.mark.parametrize(
    ("policies", "reference", "message"),
    [
        (("pd", "nobody"), "pd", r"--policies: policy must be 'agent', .* baseline \(.*pd, .*\), .*, got 'nobody'"),
        (("pd", "pd_dob"), "agent", r"--reference: 'agent' is not among the policies \['pd', 'pd_dob'\]"),
    ],
)
def test_evaluate_refuses_before_any_work(policies, reference, message, tmp_path):
    evaluation = module_of("evaluate")
    with pytest.raises(SystemExit, match=message):
        evaluation.main(evaluation.Config(policies=policies, reference=reference, output=tmp_path))
    assert not list(tmp_path.iterdir())


def test_evaluate_counts_what_is_not_surely_feasible_if_told_to():
    """The label is cautious: the example of Chen et al. does not get it."""
    evaluation = module_of("evaluate")
    config = evaluation.Config(scenario="chen_2018", episodes=2, seed=0)
    with pytest.raises(SystemExit, match=r"--episodes: scenario must have more feasible.*--count-infeasible"):
        evaluation.draw(config, "chen_2018")
    told = replace(config, count_infeasible=True)
    episodes = evaluation.draw(told, "chen_2018")
    assert episodes.digest() == scenarios.get("chen_2018").draw(0, 2).digest() and not episodes.feasible.any()
    assert evaluation.counted(told, episodes).feasible.all()
    assert evaluation.counted(config, episodes) is episodes
    with pytest.raises(SystemExit, match=r"--episodes: count must be a positive integer, got 0$"):
        evaluation.draw(replace(told, episodes=0), "chen_2018")


def test_evaluate_refuses_an_unknown_scenario(tmp_path):
    evaluation = module_of("evaluate")
    with pytest.raises(SystemExit, match=r"--scenario: 'nowhere' is none of .*'flagship'"):
        evaluation.main(evaluation.Config(policies=("pd",), reference="pd", scenario="nowhere", output=tmp_path))
