import pytest

pytest.importorskip("torchrl", reason="needs the extra libraries")

import torch
from helpers.library_pages import assert_flown, run


def stored(data):
    """Return observation, next observation, reward and ends of a rollout, with the time first."""
    following = data["next"]
    values = {
        "observation": data["observation"],
        "next_observation": following["observation"],
        "reward": following["reward"],
        "terminated": following["terminated"],
        "truncated": following["truncated"],
    }
    return {name: value.movedim(-2, 0) for name, value in values.items()}


def test_gym_env_makes_episodes_of_true_transitions(duration):
    data = run("TorchRL", 0)["data"].unsqueeze(0)
    assert data["observation"].dtype == torch.float32 and data["action"].shape == (1, 64, 4)
    expected = assert_flown(data["action"].movedim(-2, 0), stored(data), duration)
    sums = data["next", "episode_reward"].squeeze()[torch.as_tensor(expected["truncated"]).squeeze()]
    torch.testing.assert_close(sums.double(), torch.as_tensor(expected["reward"][:60].reshape(3, 20).sum(axis=1)))
    assert data["next", "step_count"].max() == 20


def test_infos_are_read(duration):
    data = run("TorchRL", 1)["data"]
    assert data["next", "is_success"].dtype == torch.bool and data["next", "is_success"].shape == (64,)
    angles = data["next", "attitude_error"]
    assert ((angles > 0.0) & (angles <= 180.0)).all() and angles.unique().numel() > 32


def test_a_collector_on_the_vector_environment_stores_true_transitions(duration):
    data = run("TorchRL", 2)["data"]
    assert data.shape == (8, 64)
    assert_flown(data["action"].movedim(-2, 0), stored(data), duration)
