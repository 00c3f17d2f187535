"""Training from the command line: a run, a killed run that resumes, and their agents."""

import csv
import json
import os
import signal
import subprocess
import time
from pathlib import Path

import gymnasium as gym
import numpy as np
import pytest
from helpers.scripts import TINY, command, module_of, run

from ftac_gym import baselines, scenarios
from ftac_gym.agents.agent import Agent
from ftac_gym.evaluation import evaluate, rollout
from ftac_gym.evaluation.metrics import UNITS
from ftac_gym.scenarios import frozen
from ftac_gym.task.objective import RewardWeights
from ftac_gym.training.checkpoints import checkpoints
from ftac_gym.utils.files import locked

SHORT = scenarios.get("flagship").replace(duration=3.0)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Return the folder of a run without interruption."""
    folder = tmp_path_factory.mktemp("whole")
    arguments = ("--run-folder", "run", "--total-steps", 2048, *TINY, "--evaluate-every", 1024)
    reward = "--reward", "on_target=2.0"
    result = run("train.py", *arguments, *reward, "--evaluation-episodes", 2, folder=folder)
    assert result.returncode == 0, result.stderr
    assert "is in run/agent" in result.stdout
    assert [line.split(":")[0] for line in result.stdout.splitlines() if "mean return" in line] == [
        "after 1,024 decisions", "after 2,048 decisions",
    ]  # fmt: skip
    return folder / "run"


@pytest.fixture(scope="module")
def resumed(tmp_path_factory):
    """Return the folder and the last steps of a run that is killed after its first checkpoint, then resumed for 512."""
    folder = tmp_path_factory.mktemp("resumed")
    arguments = ("--run-folder", "run", "--wrappers", "--observation", "telemetry", *TINY)
    process = subprocess.Popen(
        command("train.py", *arguments, "--total-steps", 100_000_000), cwd=folder,
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    try:
        deadline = time.monotonic() + 90.0
        while not [path for path in checkpoints(folder / "run") if int(path.name)]:
            assert process.poll() is None and time.monotonic() < deadline
            time.sleep(0.05)
    finally:
        os.kill(process.pid, signal.SIGKILL)
        process.wait()
    last = int(checkpoints(folder / "run")[-1].name)
    # The remains of a kill while writing are no checkpoint.
    (folder / "run" / "checkpoints" / f"{last + 512:010d}.partial").mkdir(exist_ok=True)
    result = run("train.py", *arguments, "--total-steps", last + 512, "--resume", folder=folder)
    assert result.returncode == 0, result.stderr
    return folder / "run", last


def files_of(folder):
    return sorted(path.name for path in folder.iterdir())


def test_a_run_writes_checkpoints_and_an_agent(whole):
    weights = json.loads((whole / "agent" / "card.json").read_text())["weights"]["file"]
    assert files_of(whole / "agent") == ["card.json", weights]
    assert files_of(whole / "checkpoints") == [f"{steps:010d}" for steps in (0, 512, 1024, 1536, 2048)]
    for path in checkpoints(whole):
        assert {Path(name).suffix for name in files_of(path)} == {".json", ".safetensors"}  # no code
    config = json.loads((whole / "config.json").read_text())
    assert config["num_envs"] == 8 and config["hyperparameters"] == ["n_steps=32", "batch_size=128"]
    assert list((whole / "tensorboard").rglob("events.out.tfevents.*"))


def test_evaluations_along_the_way(whole):
    with (whole / "evaluations.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [int(row["steps"]) for row in rows] == [1024, 2048]
    counts = {"episodes", "peak_after_fault_defined"}
    assert set(rows[0]) == {"steps", "mean_return", *UNITS, *counts}
    assert float(rows[0]["episodes"]) <= 2 and float(rows[0]["peak_after_fault_defined"]) <= 2
    kept = json.loads((whole / "agent" / "card.json").read_text())
    assert kept["evaluation"].keys() >= counts
    # The weights of the reward are those of the training.
    task = scenarios.get("flagship").replace(reward=RewardWeights(on_target=2.0))
    episodes = frozen.load("flagship", 2, kind="validation")
    metrics = rollout(task, str(whole / "checkpoints" / "0000001024"), episodes).feasible_metrics()
    assert float(rows[0]["return"]) == pytest.approx(np.median(metrics["return"]), rel=1e-4)


def test_the_card_says_how_the_agent_was_made(whole):
    card = json.loads((whole / "agent" / "card.json").read_text())
    # The best of both evaluations; the first of them if they tie.
    assert card["steps"] in (1024, 2048) and card["environment"] == "SpacecraftFTC-v0" and card["seed"] == 0
    _, (name, arguments) = card["interface"]["wrappers"]
    assert name == "ResidualPolicy" and arguments["base"] == "pd_dob" and card["interface"]["observation"] == "attitude"
    # All gains of the base are written down.
    assert arguments.items() >= baselines.defaults("pd_dob").items()
    assert card["normalizer"]["count"] > 0 and card["algorithm"] == "ppo" and card["training_seconds"] >= 0
    for words in ("--num-envs 8", "--total-steps 2048", "--hyperparameters n_steps=32 batch_size=128"):
        assert words in card["command"]
    assert json.loads((whole / "checkpoints" / "0000000512" / "card.json").read_text())["steps"] == 512


def test_a_killed_run_goes_on_from_its_last_checkpoint(resumed):
    folder, last = resumed
    card = json.loads((folder / "agent" / "card.json").read_text())
    assert card["steps"] == last + 512
    assert card["interface"]["wrappers"] == [] and card["interface"]["observation"] == "telemetry"
    before, after = Agent.load(folder / "checkpoints" / f"{last:010d}"), Agent.load(folder / "agent")
    # The statistics of the normaliser continue, and the network learns.
    gained = after.normalizer.count - before.normalizer.count
    assert 512 <= gained <= 512 + 3 * 8
    weights = [agent.policy.state_dict()["action_net.weight"].numpy() for agent in (before, after)]
    assert (weights[0] != weights[1]).any()


def test_a_run_is_not_overwritten(whole):
    train = module_of("train")
    before = (whole / "agent" / "card.json").read_bytes()
    with pytest.raises(SystemExit, match=r"holds a run already; choose another --run-folder, or --resume it"):
        train.main(train.Config(run_folder=whole))
    assert (whole / "agent" / "card.json").read_bytes() == before


def test_two_trainings_do_not_share_a_folder(whole):
    train = module_of("train")
    small = {"num_envs": 2, "hyperparameters": ("n_steps=32", "batch_size=64")}
    for arguments in ({"resume": True}, small):
        with locked(whole), pytest.raises(SystemExit) as caught:
            train.main(train.Config(run_folder=whole, **arguments))
        message = f"--run-folder must be used by one process at a time; process {os.getpid()} uses it"
        assert str(caught.value).startswith(message)


def test_damaged_settings_of_a_run_are_refused_in_a_line(whole, tmp_path):
    train = module_of("train")
    (tmp_path / "checkpoints" / "0000000512").mkdir(parents=True)
    text = (whole / "config.json").read_text()
    for damaged in (text[:100], text.replace("num_envs", "number"), "[]", ""):
        (tmp_path / "config.json").write_text(damaged)
        with pytest.raises(SystemExit, match=r"^--resume: .*config\.json cannot be read: .*; restore it"):
            train.main(train.Config(run_folder=tmp_path, resume=True))


def test_nothing_to_resume(tmp_path):
    train = module_of("train")
    missing = tmp_path / "missing"
    with pytest.raises(SystemExit, match="--resume: no checkpoint under"):
        train.main(train.Config(run_folder=missing, resume=True))
    assert not missing.exists()


def test_a_resumed_run_keeps_its_settings(resumed):
    train = module_of("training_run")
    folder, _ = resumed
    kept = train.resumed(train.Config(run_folder=folder, resume=True))
    assert kept.wrappers == () and kept.observation == "telemetry" and "n_steps=32" in kept.hyperparameters
    longer = train.resumed(train.Config(run_folder=folder, resume=True, total_steps=123))
    assert longer.total_steps == 123
    with pytest.raises(SystemExit, match="--resume: the run was started with --num-envs 8, got 9"):
        train.resumed(train.Config(run_folder=folder, resume=True, num_envs=9))


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


def test_fingerprints_tell_agents_apart(whole, resumed):
    prints = [Agent.load(path).fingerprint for path in (whole / "agent", whole / "checkpoints" / "0000000512")]
    assert len({*prints, Agent.load(resumed[0] / "agent").fingerprint}) == 3


def test_what_is_no_agent(tmp_path, whole):
    with pytest.raises(ValueError, match=r"agent must be a folder with card\.json"):
        Agent.load(tmp_path)
    with pytest.raises(ValueError, match=r"policy must be .* or the path of an agent"):
        rollout(SHORT, str(tmp_path / "missing"))
    env = gym.make_vec("SpacecraftFTC-v0", num_envs=2, observation="oracle")
    with pytest.raises(
        ValueError, match=r"agent must have been trained on observations of \d+ entries, as flagship gives"
    ):
        Agent.load(whole / "agent").attach(env)
