"""Folders as RL Baselines3 Zoo writes them; tests/libraries trains with the Zoo itself."""

from collections import OrderedDict

import numpy as np
import pytest
import yaml
from helpers.parity import EPISODES, SHORT, assert_scored_alike, flown_by_sb3, make
from stable_baselines3 import PPO
from stable_baselines3.common.vec_env import DummyVecEnv, VecNormalize

from ftac_gym.evaluation import compare, rollout
from ftac_gym.policies import load_zoo

ARGUMENTS = {"algo": "ppo", "env": "ftac_gym:SpacecraftFTC-v0", "env_kwargs": {"duration": 3.0}}
HYPERPARAMETERS = {"normalize": True, "n_steps": 32, "env_wrapper": [{"ftac_gym.wrappers.ActionHold": {"steps": 3}}]}


def write(folder, arguments=(), hyperparameters=()):
    """Write the tables of a folder."""
    settings = folder / "SpacecraftFTC-v0"
    settings.mkdir(parents=True, exist_ok=True)
    for name, table, changes in (("args", ARGUMENTS, arguments), ("config", HYPERPARAMETERS, hyperparameters)):
        (settings / f"{name}.yml").write_text(yaml.dump(OrderedDict({**table, **dict(changes)})))


@pytest.fixture(scope="module")
def trained(tmp_path_factory):
    """Return a folder with two models, and the environment and last model of its training."""
    folder = tmp_path_factory.mktemp("zoo") / "SpacecraftFTC-v0_1"
    write(folder)
    env = VecNormalize(DummyVecEnv([lambda: make(hold=3)]))
    model = PPO("MlpPolicy", env, n_steps=32, batch_size=32, n_epochs=1, seed=1, device="cpu").learn(32)
    model.save(folder / "best_model.zip")
    model.learn(32).save(folder / "SpacecraftFTC-v0.zip")
    env.save(str(folder / "SpacecraftFTC-v0" / "vecnormalize.pkl"))
    (folder / "SpacecraftFTC-v0" / "command.txt").write_text("python -m rl_zoo3.train\n")
    np.savez(
        folder / "evaluations.npz", timesteps=[32, 64], results=[[1.0, 2.0], [3.0, 5.0]], ep_lengths=[[9, 9], [9, 9]]
    )
    return folder


@pytest.fixture
def zoo(trained):
    """Return the folder with its own tables."""
    write(trained)
    return trained


def test_the_models_fly_as_those_of_the_zoo_do(zoo):
    returns = []
    for model, file in (("last", "SpacecraftFTC-v0.zip"), ("best", "best_model.zip")):
        env = DummyVecEnv([lambda: make(hold=3)] * len(EPISODES))
        env = VecNormalize.load(str(zoo / "SpacecraftFTC-v0" / "vecnormalize.pkl"), env)
        env.training = env.norm_reward = False
        expected = flown_by_sb3(PPO.load(zoo / file, device="cpu"), env, hold=3)
        assert_scored_alike(f"zoo:{zoo} model={model}", *expected)
        returns.append(expected[0])
    assert not np.allclose(*returns)
    agent = load_zoo(zoo)
    assert agent.curve == ({"steps": 32.0, "mean_return": 1.5}, {"steps": 64.0, "mean_return": 4.0})
    assert agent.command == "python -m rl_zoo3.train" and agent.scenario == SHORT


def test_a_training_with_another_task_is_judged_on_that_task(zoo):
    agent = load_zoo(zoo)
    message = r"scenario must be that of the agent's env_kwargs .*: it differs in duration, got 'flagship'$"
    with pytest.raises(ValueError, match=message):
        rollout("flagship", agent)
    with pytest.raises(ValueError, match=f"^zoo: {message}"):
        compare({"pd": "pd", "zoo": agent}, "flagship", episodes=EPISODES)
    rollout(agent.scenario.replace(tumble_rate=None), agent)
    rollout(SHORT.replace(duration=1.0), load_zoo(zoo, transfer=True))
    write(zoo, {"env_kwargs": {"render_mode": None}})
    rollout(SHORT.replace(duration=1.0), load_zoo(zoo))
    write(zoo, {"env_kwargs": None}, {"env_kwargs": {"duration": 3.0}})
    with pytest.raises(ValueError, match=message):
        rollout("flagship", load_zoo(zoo))


@pytest.mark.parametrize(
    ("arguments", "hyperparameters", "message"),
    [
        ({}, {"frame_stack": 4}, r"zoo: frame_stack must be absent, got 4"),
        ({}, {"vec_env_wrapper": "my.Wrapper"}, "zoo: vec_env_wrapper must be absent, got 'my.Wrapper'"),
        ({}, {"env_wrapper": "rl_zoo3.wrappers.TimeFeatureWrapper"}, r"env_wrapper must be among .*TimeFeatureWrapper"),
        (
            {},
            {"env_wrapper": [{"ftac_gym.wrappers.ActionHold": {"steps": 3}}, "ftac_gym.wrappers.ObservationHistory"]},
            "env_wrapper must have ActionHold last",
        ),
        ({"env": "Pendulum-v1", "env_kwargs": None}, {}, "env must be of this package, got 'Pendulum-v1'"),
        ({"env": "Unknown-v0"}, {}, "zoo: Unknown-v0: Environment `Unknown` doesn't exist"),
        ({"env": "no_such_module:Unknown-v0"}, {}, "zoo: no_such_module:Unknown-v0: No module named"),
        ({"env_kwargs": {"speed": 3}}, {}, "unexpected keyword argument 'speed'"),
        ({"env_kwargs": ["duration"]}, {}, "zoo: env_kwargs must be a table"),
        ({}, {"env_wrapper": 3}, "env_wrapper must be a name, or a list of names .*got 3"),
        ({}, {"env_wrapper": [{}]}, "env_wrapper must be a name, or a list of names .*got {}"),
        ({}, {"env_wrapper": [{"ftac_gym.wrappers.ResidualPolicy": None}]}, "env_wrapper must be a name, or a list"),
        ({}, {"env_wrapper": "ftac_gym.wrappers.ActionHold"}, "steps of ActionHold must be a whole number, 1 or more"),
        ({"env_kwargs": {"observation": "everything"}}, {}, "observation must be one of"),
        ({"env_kwargs": {"sensors": slice(3)}}, {}, r"args\.yml cannot be read: .*; repair it"),
    ],
)  # fmt: skip
def test_what_is_refused(zoo, arguments, hyperparameters, message):
    write(zoo, arguments, hyperparameters)
    with pytest.raises(ValueError, match=message):
        load_zoo(zoo)


def test_incomplete_folders(tmp_path):
    write(tmp_path)
    with pytest.raises(ValueError, match="last model must be in the folder: the training was interrupted"):
        load_zoo(tmp_path)
    (tmp_path / "SpacecraftFTC-v0.zip").write_bytes(b"torn")
    with pytest.raises(ValueError, match=r"zoo must have vecnormalize\.pkl: its training normalised"):
        load_zoo(tmp_path)
