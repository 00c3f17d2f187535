"""Buffers of Stable-Baselines3 as arrays whose axes are the steps and the environments."""

import numpy as np
from helpers.library_pages import assert_flown


def assert_rollout_flown(model, duration, counts_success=True):
    """Assert that a rollout buffer, which has been trained on, holds true transitions and the statistics their sums."""
    buffer = model.rollout_buffer
    steps, count = buffer.rewards.shape

    def apart(array):
        return array.reshape(count, steps, -1).swapaxes(0, 1)

    stored = {"observation": apart(buffer.observations)}
    expected = assert_flown(apart(buffer.actions), stored, duration)
    ended = expected["truncated"] | expected["terminated"]
    # To the reward of a step that runs out of time SB3 adds the value of the last observation.
    np.testing.assert_allclose(buffer.rewards[~ended], expected["reward"][~ended], atol=1e-5)
    assert (buffer.rewards[expected["truncated"]] != expected["reward"][expected["truncated"]]).all()
    starts = buffer.episode_starts
    starts = starts if starts.shape == ended.shape else apart(starts)[..., 0]
    np.testing.assert_array_equal(starts[1:].astype(bool), ended[:-1])
    assert_statistics(model, expected, ended, counts_success)


def assert_replay_flown(model, duration):
    """Assert that a replay buffer holds true transitions, and the statistics their sums."""
    buffer = model.replay_buffer
    stored = {
        "observation": buffer.observations,
        "next_observation": buffer.next_observations,
        "reward": buffer.rewards,
        "truncated": buffer.timeouts.astype(bool),
    }
    stored = {name: values[: buffer.pos] for name, values in stored.items()}
    expected = assert_flown(buffer.actions[: buffer.pos], stored, duration)
    ended = expected["truncated"] | expected["terminated"]
    np.testing.assert_array_equal(buffer.dones[: buffer.pos].astype(bool), ended)
    assert_statistics(model, expected, ended)


def assert_statistics(model, expected, ended, counts_success=True):
    """Assert that the returns and lengths of the episodes are those of the rewards, and success is known."""
    returns = []
    for spacecraft in range(ended.shape[1]):
        stops = np.flatnonzero(ended[:, spacecraft]) + 1
        returns += [part.sum() for part in np.split(expected["reward"][:, spacecraft], stops)[: len(stops)]]
    infos = model.ep_info_buffer
    assert len(infos) == len(returns) and len(model.ep_success_buffer) == (len(returns) if counts_success else 0)
    np.testing.assert_allclose(sorted(info["r"] for info in infos), sorted(returns), atol=1e-4)
    assert {info["l"] for info in infos} == {20}
