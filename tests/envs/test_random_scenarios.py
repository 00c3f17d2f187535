"""Random scenarios: those that are accepted fly, and give finite numbers within the spaces."""

import gymnasium as gym
import numpy as np
from helpers.random_scenarios import random_keywords
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from ftac_gym.envs.observation import TIERS

STEPS = 50
FLOWN = []


def check_refusal(error):
    message = str(error)
    assert len(message) <= 500 and "\n" not in message, message
    field, _, rule = message.partition(" ")
    assert field[0].islower() and ("must " in rule or "needs " in rule), message


def check_numbers(observation, space, reward, info):
    assert space.contains(observation), observation
    assert np.isfinite(reward).all(), reward
    for name, value in info.items():
        if isinstance(value, dict):
            check_numbers(observation, space, 0.0, value)
        else:
            assert np.isfinite(np.asarray(value, dtype=float)).all(), (name, value)


def fly(env, vector, seed):
    """Fly random actions, then full torque to and fro."""
    rng = np.random.default_rng(seed)
    bang = np.ones(env.action_space.shape)
    observation, info = env.reset(seed=seed)
    check_numbers(observation, env.observation_space, 0.0, info)
    for index in range(STEPS):
        action = rng.uniform(-1.0, 1.0, env.action_space.shape)
        if seed % 2:
            bang = np.sign(action) if index % 10 == 0 else bang
            action = bang
        observation, reward, terminated, truncated, info = env.step(action)
        check_numbers(observation, env.observation_space, reward, info)
        if not vector and (terminated or truncated):
            env.reset()


@settings(max_examples=150, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(random_keywords(), st.sampled_from(TIERS), st.booleans(), st.integers(0, 1000))
def accepted_scenarios_fly(keywords, tier, vector, seed):
    if isinstance(keywords, ValueError):
        check_refusal(keywords)
        return
    try:
        if vector:
            env = gym.make_vec("SpacecraftFTC-v0", num_envs=3, observation=tier, **keywords)
        else:
            env = gym.make("SpacecraftFTC-v0", observation=tier, disable_env_checker=True, **keywords)
        env.reset(seed=seed)
    except ValueError as error:
        check_refusal(error)
        return
    FLOWN.append(keywords)
    fly(env, vector, seed)


def test_no_accepted_scenario_gives_a_number_that_is_not_finite():
    FLOWN.clear()
    accepted_scenarios_fly()
    assert len(FLOWN) > 50  # A test in which everything is refused would not be one.
