"""Buffers of Stable-Baselines3 as arrays whose axes are the steps and the environments."""

import numpy as np
from helpers.library_pages import assert_flown, returns_and_lengths


def assert_rollout_flown(model, counts_success=True):
    """Assert that a rollout buffer, which has been trained on, holds true transitions and the statistics their sums."""
    buffer = model.rollout_buffer
    steps, count = buffer.rewards.shape

    def apart(array):
        return array if array.shape == (steps, count) else array.reshape(count, steps, -1).swapaxes(0, 1)

    expected = assert_flown(apart(buffer.actions), {"observation": apart(buffer.observations)})
    # To the reward of a step that runs out of time SB3 adds the value of the last observation.
    truncated = expected["truncated"] & ~expected["terminated"]
    np.testing.assert_allclose(buffer.rewards[~truncated], expected["reward"][~truncated], atol=1e-5)
    assert (buffer.rewards[truncated] != expected["reward"][truncated]).all()
    starts = apart(buffer.episode_starts).reshape(steps, count).astype(bool)
    np.testing.assert_array_equal(starts[1:], expected["ended"][:-1])
    assert_statistics(model, expected, counts_success)


def assert_replay_flown(model):
    """Assert that a replay buffer holds true transitions, and the statistics their sums."""
    buffer = model.replay_buffer
    stored = {
        "observation": buffer.observations,
        "next_observation": buffer.next_observations,
        "reward": buffer.rewards,
    }
    stored = {name: values[: buffer.pos] for name, values in stored.items()}
    expected = assert_flown(buffer.actions[: buffer.pos], stored)
    truncated = expected["truncated"] & ~expected["terminated"]
    np.testing.assert_array_equal(buffer.timeouts[: buffer.pos].astype(bool), truncated)
    np.testing.assert_array_equal(buffer.dones[: buffer.pos].astype(bool), expected["ended"])
    assert_statistics(model, expected)


def assert_statistics(model, expected, counts_success=True):
    """Assert that the returns and lengths of the last 100 episodes are those of the rewards, and success is counted."""
    infos = np.array([(info["r"], info["l"]) for info in model.ep_info_buffer])
    episodes = returns_and_lengths(expected["reward"], expected["ended"])
    assert len(infos) == min(100, len(episodes))
    for seen in infos:
        assert (np.abs(episodes - seen) < 1e-4).all(axis=1).any(), seen
    assert len(model.ep_success_buffer) == (len(infos) if counts_success else 0)
