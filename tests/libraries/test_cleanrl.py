import gymnasium as gym
import numpy as np
import pytest
from helpers.library_pages import run

from ftac_gym.envs import SpacecraftFTCVectorEnv

STEPS, LENGTH = 64, 20


@pytest.fixture
def steps(monkeypatch):
    """Record reward (N,) and end (N,) of every step of a class of vector environments, before and after wrappers."""

    def record(kind):
        inner, rows = kind.step, []

        def step(envs, actions):
            result = inner(envs, actions)
            rows.append((result[1].copy(), result[2] | result[3]))
            return result

        monkeypatch.setattr(kind, "step", step)
        return rows

    return record


def test_single_environments_side_by_side_log_the_sums_of_their_rewards(duration, steps, monkeypatch):
    inner, raw = gym.wrappers.RecordEpisodeStatistics.step, []

    def kept(env, action):
        result = inner(env, action)
        raw.append(result[1])
        return result

    monkeypatch.setattr(gym.wrappers.RecordEpisodeStatistics, "step", kept)
    rows = steps(gym.vector.SyncVectorEnv)
    names = run("CleanRL", 0)
    assert_one_step_more_resets(rows)
    sums = np.array(raw[: 2 * 3 * LENGTH]).reshape(3, LENGTH, 2).sum(axis=1)
    np.testing.assert_allclose(names["returns"], sums.ravel(), rtol=1e-5)
    assert names["infos"]["is_success"].dtype == np.bool_


def test_the_vector_environment_logs_the_sums_of_its_rewards(duration, steps):
    rows = steps(SpacecraftFTCVectorEnv)
    names = run("CleanRL", 1)
    assert_one_step_more_resets(rows)
    rewards = np.array([reward for reward, _ in rows])[: 3 * (LENGTH + 1)].reshape(3, LENGTH + 1, 16)
    assert (rewards[:, -1] == 0.0).all()
    np.testing.assert_allclose(names["returns"], rewards.sum(axis=1).ravel(), rtol=1e-5)
    assert names["observation"].shape == (16, 22) and np.abs(names["observation"]).max() <= 10.0


def assert_one_step_more_resets(rows):
    """Assert that an episode and the step that resets it alternate for every spacecraft."""
    ended = np.array([end for _, end in rows])
    expected = np.arange(STEPS) % (LENGTH + 1) == LENGTH - 1
    np.testing.assert_array_equal(ended, np.repeat(expected[:, None], ended.shape[1], axis=1))
