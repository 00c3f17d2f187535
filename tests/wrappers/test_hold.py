"""Holding an action for several control periods: in the adapter for training, and in the agent that flies."""

import gymnasium as gym
import numpy as np
import pytest

from ftac_gym.agents.agent import Agent
from ftac_gym.agents.interface import Interface
from ftac_gym.envs import SpacecraftFTCVectorEnv
from ftac_gym.wrappers import SB3VecEnv

COUNT = 5
SETTINGS = {"duration": 1.2, "tumble_rate": 0.016}  # s, rad/s


def make(hold):
    return SB3VecEnv(SpacecraftFTCVectorEnv(COUNT, autoreset_mode="SameStep", **SETTINGS), hold)


def test_a_held_action_is_the_same_action_several_times():
    held, plain = make(4), make(1)
    for env in (held, plain):
        env.seed(7)
        env.reset()
    random = np.random.default_rng(1)
    endings = 0
    for _ in range(15):
        action = random.uniform(-1.0, 1.0, (COUNT, 4)).astype(np.float32)
        observation, reward, done, infos = held.step(action)
        total, over = np.zeros(COUNT), np.zeros(COUNT, dtype=bool)
        last = [None] * COUNT
        for _ in range(4):
            fine_observation, fine_reward, fine_done, fine_infos = plain.step(np.where(over[:, None], 0.0, action))
            total += np.where(over, 0.0, fine_reward)
            for spacecraft in np.flatnonzero(fine_done & ~over):
                last[spacecraft] = fine_infos[spacecraft]
            over |= fine_done
        np.testing.assert_array_equal(observation, fine_observation)
        np.testing.assert_allclose(reward, total, rtol=1e-5, atol=1e-6)
        np.testing.assert_array_equal(done, over)
        for spacecraft in np.flatnonzero(done):
            endings += 1
            np.testing.assert_array_equal(
                infos[spacecraft]["terminal_observation"], last[spacecraft]["terminal_observation"]
            )
            assert infos[spacecraft]["TimeLimit.truncated"] is last[spacecraft]["TimeLimit.truncated"]
            assert infos[spacecraft]["time"] == last[spacecraft]["time"]
        assert all(not info for info, ended in zip(infos, done, strict=True) if not ended)
    assert endings > COUNT


def test_episode_lengths_count_control_periods():
    env = SB3VecEnv(SpacecraftFTCVectorEnv(COUNT, autoreset_mode="SameStep", duration=1.2, tumble_rate=None), 4)
    env.seed(0)
    env.reset()
    returns = np.zeros(COUNT)
    for _ in range(3):
        _, reward, done, infos = env.step(np.zeros((COUNT, 4), dtype=np.float32))
        returns += reward
    assert done.all()
    assert [info["episode"]["l"] for info in infos] == [12] * COUNT
    np.testing.assert_allclose([info["episode"]["r"] for info in infos], returns, rtol=1e-5)


@pytest.mark.parametrize("hold", [0, -1, 1.5, True])
def test_bad_hold(hold):
    with pytest.raises(ValueError, match="hold must be a whole number, 1 or more"):
        make(hold)


class Counting:
    """Stands for a model: its action is how often it was asked."""

    observation_space = gym.spaces.Box(-1.0, 1.0, (5,))
    policy = None

    def __init__(self):
        self.asked = 0

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        self.asked += 1
        return np.full((len(observation), 4), float(self.asked)), None


def test_an_agent_decides_once_per_hold_and_at_every_start():
    agent = Agent(Counting(), None, Interface(hold=3))
    state, start = None, np.array([True, True])
    decided = []
    for step in range(9):
        action, state = agent.predict(np.zeros((2, 5)), state, start)
        decided.append(action[:, 0].tolist())
        start = np.array([False, step == 3])  # the second spacecraft starts anew at step 4
    first, second = np.array(decided).T
    assert first.tolist() == [1, 1, 1, 2, 2, 2, 4, 4, 4]
    assert second.tolist() == [1, 1, 1, 2, 3, 3, 3, 5, 5]
