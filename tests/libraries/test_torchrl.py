import pytest

pytest.importorskip("torchrl", reason="needs the extra libraries")

import numpy as np
import torch
from helpers.library_pages import assert_flown, returns_and_lengths, run


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


def test_gym_env_makes_episodes_of_true_transitions(short_episodes):
    data = run("TorchRL", 0)["data"].unsqueeze(0)
    assert data["observation"].dtype == torch.float32 and data["action"].shape == (1, 64, 4)
    expected = assert_flown(data["action"].movedim(-2, 0), stored(data))
    ended = torch.as_tensor(expected["ended"]).squeeze()
    seen = torch.stack([data["next", name].squeeze()[ended].double() for name in ("episode_reward", "step_count")])
    episodes = returns_and_lengths(expected["reward"], expected["ended"])
    np.testing.assert_allclose(sorted(seen.T.tolist()), episodes, atol=1e-4)


def test_infos_of_a_single_environment_are_read(short_episodes):
    data = run("TorchRL", 1)["data"]
    assert data["next", "is_success"].dtype == torch.bool and data["next", "is_success"].shape == (64,)
    shares = data["next", "availability"]
    assert ((shares >= 0.0) & (shares <= 1.0)).all()


def test_a_collector_on_the_vector_environment_stores_true_transitions(short_episodes):
    data = run("TorchRL", 2)["data"]
    assert data.shape == (8, 64)
    assert_flown(data["action"].movedim(-2, 0), stored(data))
    assert data["next", "is_success"].dtype == torch.bool and data["next", "is_success"].shape == (8, 64)
    terms = [value for name, value in data["next"].items() if name.startswith("reward/")]
    torch.testing.assert_close(sum(terms).float(), data["next", "reward"].squeeze(-1).float(), atol=1e-5, rtol=0.0)
