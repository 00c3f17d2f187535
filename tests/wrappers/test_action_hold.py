"""Holding an action in a single environment."""

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import data_equivalence

from ftac_gym.envs import SpacecraftFTCEnv, SpacecraftFTCVectorEnv
from ftac_gym.wrappers import ActionHold, FaultEstimateObservation, GainScheduling, ObservationHistory, ResidualPolicy

SETTINGS = {"duration": 1.1, "tumble_rate": 0.016}  # s, rad/s


@pytest.mark.parametrize("steps", [1, 4])
def test_a_held_action_is_the_same_action_several_times(steps):
    held = ActionHold(ResidualPolicy(gym.make("SpacecraftFTC-v0", **SETTINGS)), steps)
    plain = ResidualPolicy(gym.make("SpacecraftFTC-v0", **SETTINGS))
    random, cut = np.random.default_rng(0), 0
    for seed in (5, None, None, None):
        np.testing.assert_array_equal(held.reset(seed=seed)[0], plain.reset(seed=seed)[0])
        done = False
        while not done:
            action = random.uniform(-1.0, 1.0, 4).astype(np.float32)
            observation, reward, terminated, truncated, info = held.step(action)
            total, taken, expected = 0.0, 0, None
            while taken < steps and not done:
                expected, fine, *ended, fine_info = plain.step(action)
                total, taken, done = total + fine, taken + 1, any(ended)
            np.testing.assert_array_equal(observation, expected)
            assert reward == pytest.approx(total) and type(reward) is float
            assert [terminated, truncated] == ended and data_equivalence(info, fine_info)
            cut += taken < steps
    assert cut >= 2 or steps == 1


def test_vectors_are_held_by_the_adapter():
    with pytest.raises(ValueError, match=r"env must be a single environment: for a vector, SB3VecEnv\(env, hold=...\)"):
        ActionHold(SpacecraftFTCVectorEnv(2), 4)


@pytest.mark.parametrize("steps", [0, -2, 1.5, "4", None, True])
def test_bad_steps(steps):
    with pytest.raises(ValueError, match="steps must be a whole number, 1 or more"):
        ActionHold(SpacecraftFTCEnv(), steps)


@pytest.mark.parametrize("wrapper", [FaultEstimateObservation, GainScheduling, ObservationHistory, ResidualPolicy])
def test_it_goes_outside(wrapper):
    """A wrapper outside of the hold would miss control periods."""
    with pytest.raises(ValueError, match="env must not hold its actions yet: ActionHold goes outside"):
        wrapper(gym.wrappers.ClipAction(ActionHold(SpacecraftFTCEnv(), 4)))
    assert ActionHold(wrapper(SpacecraftFTCEnv()), 4).reset(seed=0)[0].ndim == 1
