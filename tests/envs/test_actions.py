"""Types of actions: real numbers of any size, and nothing that NumPy would convert to them in silence."""

import gymnasium as gym
import numpy as np
import pytest

import ftac_gym  # noqa: F401  registers the environments
from ftac_gym.wrappers import GainScheduling, ResidualPolicy

TEXT, FLAGS, COMPLEX = ["0.1"] * 4, np.zeros(4, dtype=bool), np.zeros(4, dtype=complex)
OBJECTS = np.array([0.1, 0.2, 0.3, 0.4], dtype=object)


def scheduled(env):
    return GainScheduling(env, ranges={"braking_share": (0.4, 0.9)})


@pytest.mark.parametrize("action", [TEXT, FLAGS, COMPLEX, OBJECTS], ids=["text", "flags", "complex", "objects"])
@pytest.mark.parametrize("wrap", [lambda env: env, ResidualPolicy, scheduled], ids=["plain", "residual", "scheduled"])
def test_actions_that_are_no_real_numbers(wrap, action):
    single, vector = wrap(gym.make("SpacecraftFTC-v0").unwrapped), wrap(gym.make_vec("SpacecraftFTC-v0", num_envs=2))
    for env, given in ((single, np.array(action)), (vector, np.array([action, action]))):
        env.reset(seed=0)
        with pytest.raises(ValueError, match=r"actions? must consist of real numbers, got dtype"):
            env.step(given[..., : env.action_space.shape[-1]])
        for kind in (int, np.float16, np.float64):
            env.step(np.zeros(env.action_space.shape, dtype=kind))


def test_messages_about_arrays_are_one_line():
    env = gym.make_vec("SpacecraftFTC-v0", num_envs=40)
    env.reset(seed=0)
    with pytest.raises(ValueError, match=r"^actions? must be finite, got ") as caught:
        env.step(np.full((40, 4), np.nan))
    assert "\n" not in str(caught.value) and len(str(caught.value)) <= 500


@pytest.mark.parametrize("options", [[1], "x", 5, [{}]])
def test_options_of_another_kind_are_refused_by_name(options):
    for env in (gym.make("SpacecraftFTC-v0").unwrapped, gym.make_vec("SpacecraftFTC-v0", num_envs=2)):
        with pytest.raises(ValueError, match=r"^reset options must be a dict or None, got "):
            env.reset(seed=0, options=options)


@pytest.mark.parametrize("seed", [True, False])
def test_truth_values_are_no_seeds(seed):
    for env in (gym.make("SpacecraftFTC-v0").unwrapped, gym.make_vec("SpacecraftFTC-v0", num_envs=2)):
        with pytest.raises(ValueError, match=r"^seed must be an integer or .*, got (True|False)"):
            env.reset(seed=seed)
