"""The history of observations, against a list that is kept by hand."""

import numpy as np
import pytest
from gymnasium.vector import AutoresetMode

from ftac_gym.envs import SpacecraftFTCEnv, SpacecraftFTCVectorEnv
from ftac_gym.wrappers import ObservationHistory

COUNT, WHEELS = 4, 4
SETTINGS = {"duration": 2.0, "tumble_rate": 0.016}  # s, rad/s
MODES = [mode.value for mode in AutoresetMode]
SHAPES = [(1, 1), (1, 7), (4, 1), (3, 2), (2, 5), (4, 10)]
makers = pytest.mark.parametrize("make", [SpacecraftFTCEnv, lambda: SpacecraftFTCVectorEnv(2)])


def expected(past, steps, stride):
    """Return the history of one spacecraft from the list of its episode's observations."""
    return np.concatenate([past[max(len(past) - 1 - age * stride, 0)] for age in range(steps)])


@pytest.mark.parametrize(("steps", "stride"), SHAPES)
def test_a_single_environment(steps, stride):
    env, plain = ObservationHistory(SpacecraftFTCEnv(**SETTINGS), steps, stride), SpacecraftFTCEnv(**SETTINGS)
    random, lengths = np.random.default_rng(0), []
    for seed in (3, None, None):
        observation, past, done = env.reset(seed=seed)[0], [plain.reset(seed=seed)[0]], False
        while not done:
            np.testing.assert_array_equal(observation, expected(past, steps, stride))
            action = random.uniform(-1.0, 1.0, WHEELS)
            observation, *_ = env.step(action)
            latest, _, terminated, truncated, _ = plain.step(action)
            past.append(latest)
            done = terminated or truncated
        np.testing.assert_array_equal(observation, expected(past, steps, stride))
        lengths.append(len(past))
    assert max(lengths) > 10


def test_a_reset_in_the_middle_of_an_episode_forgets():
    env = ObservationHistory(SpacecraftFTCEnv(), 3)
    env.reset(seed=0)
    env.step(np.ones(WHEELS))
    observation, _ = env.reset()
    first, second, third = np.split(observation, 3)
    np.testing.assert_array_equal(first, second)
    np.testing.assert_array_equal(first, third)


@pytest.mark.parametrize(("steps", "stride"), SHAPES)
@pytest.mark.parametrize("mode", MODES)
def test_a_vector_environment(mode, steps, stride):
    plain = SpacecraftFTCVectorEnv(COUNT, autoreset_mode=mode, **SETTINGS)
    env = ObservationHistory(SpacecraftFTCVectorEnv(COUNT, autoreset_mode=mode, **SETTINGS), steps, stride)
    random, ends, single_end = np.random.default_rng(0), 0, False
    rows, (observation, _) = plain.reset(seed=3)[0], env.reset(seed=3)
    past, waiting = [[row] for row in rows], np.zeros(COUNT, dtype=bool)
    for _ in range(60):
        np.testing.assert_array_equal(observation, [expected(rows, steps, stride) for rows in past])
        action = random.uniform(-1.0, 1.0, (COUNT, WHEELS))
        rows, _, terminated, truncated, plain_infos = plain.step(action)
        observation, *_, infos = env.step(action)
        done = terminated | truncated
        ends += done.sum()
        single_end |= bool(done.any() and not done.all())
        for spacecraft in range(COUNT):
            if mode == "SameStep" and done[spacecraft]:
                last = expected([*past[spacecraft], plain_infos["final_obs"][spacecraft]], steps, stride)
                np.testing.assert_array_equal(infos["final_obs"][spacecraft], last)
                assert env.single_observation_space.contains(infos["final_obs"][spacecraft])
            fresh = waiting[spacecraft] or (mode == "SameStep" and done[spacecraft])
            past[spacecraft] = [rows[spacecraft]] if fresh else [*past[spacecraft], rows[spacecraft]]
        waiting = done & (mode == "NextStep")
        if mode == "Disabled" and done.any():
            np.testing.assert_array_equal(observation, [expected(rows, steps, stride) for rows in past])
            rows, (observation, _) = (
                plain.reset(options={"reset_mask": done})[0],
                env.reset(options={"reset_mask": done}),
            )
            past = [[row] if new else rows for row, new, rows in zip(rows, done, past, strict=True)]
    assert ends >= 8 and single_end


@makers
def test_spaces(make):
    plain, env = make(), ObservationHistory(make(), 3, 2)
    space = getattr(plain, "single_observation_space", plain.observation_space)
    wrapped = getattr(env, "single_observation_space", env.observation_space)
    np.testing.assert_array_equal(wrapped.high, np.tile(space.high, 3))
    np.testing.assert_array_equal(wrapped.low, np.tile(space.low, 3))
    observation, _ = env.reset(seed=0)
    assert env.observation_space.contains(observation) and observation.dtype == np.float32


@makers
def test_one_step_is_the_identity_and_gives_fresh_arrays(make):
    plain, env = make(), ObservationHistory(make(), 1)
    assert env.observation_space == plain.observation_space
    first, _ = env.reset(seed=0)
    first[:] = 9.0
    plain.reset(seed=0)
    action = np.zeros(env.action_space.shape)
    second = env.step(action)[0]
    np.testing.assert_array_equal(second, plain.step(action)[0])
    second[:] = 9.0
    np.testing.assert_array_equal(env.step(action)[0], plain.step(action)[0])


@makers
@pytest.mark.parametrize("name", ["steps", "stride"])
@pytest.mark.parametrize("value", [0, -1, 1.5, True, "2", None])
def test_bad_arguments(make, name, value):
    with pytest.raises(ValueError, match=f"{name} must be a whole number, 1 or more, got {value!r}"):
        ObservationHistory(make(), **{name: value})
