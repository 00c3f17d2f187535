import numpy as np
import pytest
from helpers.library_pages import returns_and_lengths, run

from ftac_gym.envs import SpacecraftFTCEnv, SpacecraftFTCVectorEnv

STEPS = 64


@pytest.fixture
def record(monkeypatch):
    """Record rewards and ends of the steps of each environment of a class, before any wrapper changes them."""

    def start(kind):
        inner, flights = kind.step, {}

        def step(env, action):
            result = inner(env, action)
            flights.setdefault(id(env), []).append((np.array(result[1]), np.array(result[2] | result[3])))
            return result

        monkeypatch.setattr(kind, "step", step)
        return flights

    return start


def test_single_environments_side_by_side_log_the_sums_of_their_rewards(short_episodes, record):
    flights = record(SpacecraftFTCEnv)
    names = run("CleanRL", 0)
    # Gymnasium's checker of environments steps none here; the order is that of the vector environment.
    assert len(flights) == 2
    episodes = []
    for rows in flights.values():
        rewards, ended = (np.array(column)[:, None] for column in zip(*rows, strict=True))
        assert len(rows) + ended[: STEPS - 1].sum() in (STEPS, STEPS + 1)
        episodes += returns_and_lengths(rewards, ended)[:, 0].tolist()
    np.testing.assert_allclose(sorted(names["returns"]), sorted(episodes), rtol=1e-5)
    assert names["infos"]["is_success"].dtype == np.bool_


def test_the_vector_environment_logs_the_sums_of_its_rewards(short_episodes, record):
    flights = record(SpacecraftFTCVectorEnv)
    names = run("CleanRL", 1)
    (rows,) = flights.values()
    rewards, ended = (np.array(column) for column in zip(*rows, strict=True))
    resets = np.vstack([np.zeros_like(ended[:1]), ended[:-1]])
    assert resets.any(axis=0).all() and (rewards[resets] == 0.0).all() and not ended[resets].any()
    episodes = returns_and_lengths(rewards, ended)[:, 0]
    np.testing.assert_allclose(sorted(names["returns"]), episodes, rtol=1e-5)
    assert names["observation"].shape == (16, 22) and np.abs(names["observation"]).max() <= 10.0
