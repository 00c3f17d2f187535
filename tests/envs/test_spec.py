"""The specification of an environment, and typed access to it."""

import csv
import math
import typing
from pathlib import Path

import gymnasium as gym
import pytest
from gymnasium.envs.registration import EnvSpec

import ftac_gym
from ftac_gym.envs import SpacecraftFTCEnv, SpacecraftFTCVectorEnv

RETURNS = Path(__file__).parents[2] / "docs" / "environments" / "returns.csv"
IDS = tuple(name for name in gym.registry if name.startswith("SpacecraftFTC"))


@pytest.mark.parametrize("environment_id", IDS)
def test_a_spec_has_the_length_of_an_episode(environment_id):
    env, envs = gym.make(environment_id), gym.make_vec(environment_id, num_envs=2)
    horizon = env.unwrapped.scenario.horizon
    assert env.spec.max_episode_steps == envs.spec.max_episode_steps == horizon
    assert gym.spec(environment_id).max_episode_steps is None, "it would end longer episodes"
    assert gym.make(EnvSpec.from_json(env.spec.to_json())).spec.max_episode_steps == horizon


@pytest.mark.parametrize("environment_id", IDS)
def test_the_reward_threshold_is_that_of_the_table_of_returns(environment_id):
    """The best baseline's mean return, less 5 %, rounded down to two digits."""
    with RETURNS.open(encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["id"] == environment_id]
    (best,) = [0.95 * float(row["mean"]) for row in rows if row["role"] == "best baseline"]
    digit = 10.0 ** (math.floor(math.log10(best)) - 1)
    assert gym.spec(environment_id).reward_threshold == pytest.approx(math.floor(best / digit) * digit)
    assert gym.make(environment_id).spec.reward_threshold == gym.spec(environment_id).reward_threshold
    assert {row["role"] for row in rows} >= {"zero", "random", "pd"}


def test_the_length_follows_the_duration():
    for duration, steps in ((5.0, 50), (300.0, 3000)):
        assert gym.make(IDS[1], duration=duration).spec.max_episode_steps == steps
        assert gym.make_vec(IDS[1], duration=duration).spec.max_episode_steps == steps
    assert gym.make(IDS[1], max_episode_steps=7).spec.max_episode_steps == 7
    assert gym.make_vec(IDS[1], max_episode_steps=7).spec.max_episode_steps == 7
    env = ftac_gym.make("SpacecraftFTC-v0", duration=5.0)
    env.set_severity(0.5)
    assert env.spec.max_episode_steps == 50


def test_a_spec_that_is_set_stays_as_it_is():
    spec = gym.spec("SpacecraftFTC-v0")
    env = SpacecraftFTCEnv()
    env.spec = spec
    assert spec.max_episode_steps is None and env.spec.max_episode_steps == 1200


def test_an_episode_that_is_made_longer_is_not_cut():
    env = gym.make("SpacecraftFTCEasy-v0", duration=61.0)
    env.reset(seed=0)
    steps, ended = 0, False
    while not ended:
        *_, terminated, truncated, _ = env.step([0.0] * 4)
        ended, steps = terminated or truncated, steps + 1
    assert steps == 610


def test_typed_environments():
    single = ftac_gym.make("ftac_gym:SpacecraftFTC-v0", duration=5.0, render_mode="rgb_array")
    vector = ftac_gym.make_vec("SpacecraftFTC-v0", num_envs=3, autoreset_mode="SameStep", duration=5.0)
    assert type(single) is SpacecraftFTCEnv and type(vector) is SpacecraftFTCVectorEnv
    assert single.spec.id == vector.spec.id == "SpacecraftFTC-v0" and single.render_mode == "rgb_array"
    assert single.scenario == vector.scenario == gym.make(single.spec).unwrapped.scenario and vector.num_envs == 3
    assert typing.get_type_hints(ftac_gym.make)["return"] is SpacecraftFTCEnv
    assert typing.get_type_hints(ftac_gym.make_vec)["return"] is SpacecraftFTCVectorEnv


@pytest.mark.parametrize("make", [ftac_gym.make, ftac_gym.make_vec])
def test_what_typed_access_refuses(make):
    with pytest.raises(TypeError, match="beauty"):
        make("SpacecraftFTC-v0", beauty=1)
    with pytest.raises(ValueError, match="environment_id must be one of this package, got 'CartPole-v1'"):
        make("CartPole-v1")
    if make is ftac_gym.make:
        with pytest.raises(TypeError, match=r"'max_episode_steps': gymnasium\.make has it"):
            make("SpacecraftFTC-v0", max_episode_steps=7)


def test_a_specification_makes_longer_episodes_without_the_limit_of_its_own():
    spec = gym.make("SpacecraftFTC-v0", duration=1.0).spec
    env = gym.make(spec, duration=2.0, max_episode_steps=-1)
    env.reset(seed=0)
    ends = [env.step(env.action_space.sample())[3] for _ in range(20)]
    assert ends == [False] * 19 + [True]
