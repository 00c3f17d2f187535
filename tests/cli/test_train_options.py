"""Options of training: algorithms, curriculum, seeds, and refusals."""

import json

import numpy as np
import pytest
from helpers.scripts import RARELY, TINY, module_of, run

from ftac_gym import scenarios
from ftac_gym.agents.agent import Agent
from ftac_gym.evaluation import rollout

SHORT = scenarios.get("flagship").replace(duration=3.0)


@pytest.mark.parametrize("algorithm", ["recurrent_ppo", "sac", "tqc"])
def test_every_algorithm_trains_resumes_and_flies(algorithm, tmp_path):
    on_policy = algorithm == "recurrent_ppo"
    settings = (
        ("n_steps=16", "batch_size=64") if on_policy else ("buffer_size=2000", "learning_starts=64", "batch_size=64")
    )
    options = ("--algo", algorithm, "--num-envs", 8, "--hyperparameters", *settings, *RARELY)
    arguments = ("--run-folder", "run", *options, "--evaluation-episodes", 2)
    first = run("train.py", *arguments, "--total-steps", 256, folder=tmp_path)
    assert first.returncode == 0, first.stderr
    again = run("train.py", *arguments, "--total-steps", 512, "--resume", folder=tmp_path)
    assert again.returncode == 0, again.stderr
    agent = Agent.load(tmp_path / "run" / "agent")
    policies = {"recurrent_ppo": "RecurrentActorCriticPolicy", "sac": "SACPolicy", "tqc": "TQCPolicy"}
    assert type(agent.policy).__name__ == policies[algorithm]
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


def test_several_seeds(tmp_path):
    arguments = ("--run-folder", "runs", "--seeds", 2, "--seed", 3, "--total-steps", 256, *TINY)
    result = run("train.py", *arguments, "--evaluation-episodes", 2, folder=tmp_path)
    assert result.returncode == 0, result.stderr
    agents = [tmp_path / "runs" / f"seed_{seed}" / "agent" for seed in (3, 4)]
    assert [json.loads((path / "card.json").read_text())["seed"] for path in agents] == [3, 4]
    assert "--seed 4" in json.loads((agents[1] / "card.json").read_text())["command"]
    weights = [Agent.load(path).policy.state_dict()["mlp_extractor.value_net.0.weight"] for path in agents]
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
        ({"seeds": 0}, r"--seeds must be a whole number within 1 and 1000000, got 0"),
        ({"torch_threads": 0}, r"--torch_threads must be a whole number within 1 and 1024, got 0"),
        ({"seed": -1}, r"--seed must be a whole number within 0 and"),
        ({"hold": 0}, r"--hold must be a positive integer, got 0"),
        ({"training_scenario": "cao_2022"}, r"--training-scenario must have the observation space"),
        ({"evaluation_episodes": 501}, r"--evaluation-episodes: feasible must be within \[1, 500\], got 501"),
        ({"seeds": 2, "resume": True}, r"--resume: no checkpoint under"),
    ],
)  # fmt: skip
def test_train_refuses(arguments, message, tmp_path):
    train = module_of("train")
    with pytest.raises(SystemExit, match=message):
        train.main(train.Config(run_folder=tmp_path / "run", num_envs=2, **arguments))
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize(
    "changed",
    [
        {"hyperparameters": [1, 2]}, {"wrappers": [5]}, {"algo": "dqn"}, {"algo": None}, {"critic_warmup": "a"},
        {"severity_steps": "x", "severity_start": 0.5}, {"evaluation_episodes": "a"}, {"num_envs": "8"},
        {"torch_threads": "1"}, {"torch_threads": 0}, {"evaluate_every": True}, {"seed": "0"}, {"total_steps": "x"},
        {"total_steps": 0}, {"seed": 10**30}, {"env_id": None}, {"gone": 1},
    ],
    ids=str,
)  # fmt: skip
def test_settings_of_a_run_have_their_types(changed, tmp_path):
    train = module_of("train")
    (tmp_path / "checkpoints" / "0000000512").mkdir(parents=True)
    (tmp_path / "config.json").write_text(json.dumps(changed))
    with pytest.raises(SystemExit, match=r"^--resume: .*config\.json cannot be read: .*; restore it") as caught:
        train.main(train.Config(run_folder=tmp_path, resume=True))
    first = next(iter(changed))
    assert f": {'settings' if first == 'gone' else first} must be" in str(caught.value)


def test_a_resumed_run_has_its_threads(tmp_path, monkeypatch):
    train, run_module = module_of("train"), module_of("training_run")
    (tmp_path / "checkpoints" / "0000000512").mkdir(parents=True)
    (tmp_path / "config.json").write_text(json.dumps({"torch_threads": 7, "num_envs": 2}))
    threads = []
    monkeypatch.setattr(run_module.torch, "set_num_threads", threads.append)

    def stop(_):
        raise KeyboardInterrupt

    monkeypatch.setattr(run_module, "hyperparameters_of", stop)
    with pytest.raises(KeyboardInterrupt):
        train.main(train.Config(run_folder=tmp_path, resume=True))
    assert threads == [7]
