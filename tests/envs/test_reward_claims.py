"""Claims of the reward: it pays for skill, and on no task for spinning, tumbling, bang-bang or a constant action."""

import gymnasium as gym
import numpy as np
import pytest

from ftac_gym import scenarios
from ftac_gym.envs import SpacecraftFTCVectorEnv
from ftac_gym.evaluation import rollout
from ftac_gym.task import RewardWeights

TASKS = [entry.kwargs["default_scenario"] for name, entry in gym.registry.items() if name.startswith("SpacecraftFTC")]
FIXED = [name for name in TASKS if scenarios.get(name).tumble_rate is None]
RANDOM = [name for name in TASKS if name not in FIXED]
DISCOUNTS = np.array([0.9, 0.95, 0.99, 0.999, 1.0])[:, None]


def discounted(env, command, seed=0, episodes=None):
    """Return the returns (discounts, N) of a command, a function of the time [s] and of the body rates [rad/s]."""
    env.reset(seed=None if episodes else [seed] * env.num_envs, options={"episodes": episodes} if episodes else None)
    returns, running = np.zeros((len(DISCOUNTS), env.num_envs)), np.ones(env.num_envs)
    period = env.scenario.control_period
    for step in range(env.batch.horizon):
        fraction = command((step + 0.5) * period, env.batch.simulator.state.rate)
        actions = np.broadcast_to(fraction, (env.num_envs, env.single_action_space.shape[0]))
        _, rewards, terminated, *_ = env.step(actions)
        assert (rewards >= 0.0).all()
        returns += DISCOUNTS**step * rewards * running
        env._ended[:] = False  # Go on with the others; the reward of those that have tumbled counts no more.
        running *= ~terminated
    return returns


def square(time, period):
    return 1.0 if time % period < 0.5 * period else -1.0


OPEN_LOOP = {
    "constant on one wheel": lambda time, _: np.array([0.0, 1.0, 0.0, 0.0]),
    "small constant": lambda time, _: np.array([-0.1, 0.1, 0.1, 0.0]),
    "constant on all wheels": lambda time, _: np.full(4, -1.0),
    "spin-up, then coasting": lambda time, _: np.array([1.0, 0.0, 0.0, 0.0]) * (time < 4.0),
    "bang-bang of all wheels": lambda time, _: np.array([1.0, 1.0, 1.0, 1.0]) * square(time, 4.0),
    "bang-bang of one wheel": lambda time, _: np.array([0.0, 0.0, 1.0, 0.0]) * square(time, 20.0),
}


@pytest.mark.parametrize("name", RANDOM)
def test_nothing_without_feedback_earns_more_than_zero_action(name):
    """In the mean over 1,000 random starts, by the interval of the paired differences, for the first 20 s.

    Whole episodes, more levels, wheels and periods were measured once; the differences only grow with time.
    """
    task = scenarios.get(name).replace(duration=20.0)
    env = SpacecraftFTCVectorEnv(1000, scenario=task, autoreset_mode="Disabled")
    episodes = task.draw(12, 1000)
    idle = discounted(env, lambda time, rate: np.zeros(4), episodes=episodes)
    for kind, command in OPEN_LOOP.items():
        difference = discounted(env, command, episodes=episodes) - idle
        error = difference.std(axis=1) / np.sqrt(1000.0)
        assert (difference.mean(axis=1) - 1.96 * error <= 0.0).all(), kind
        if "small" not in kind and "coasting" not in kind:
            assert (difference.mean(axis=1) + 1.96 * error < 0.0).all(), kind


@pytest.mark.parametrize("name", RANDOM)
def test_pd_earns_at_least_five_times_as_much_as_zero_action(name):
    skilled, idle = (rollout(name, policy, seed=12, count=48).reward.sum(axis=0) for policy in ("pd", "zero"))
    assert skilled.mean() - 1.96 * skilled.std() / np.sqrt(48.0) >= 5.0 * idle.mean()


@pytest.mark.parametrize("name", FIXED)
def test_spin_tumble_and_bang_bang_do_not_pay_from_a_fixed_start(name):
    """In the mean over directions, without discount; of bang-bang over periods too, by the interval of the mean.

    A single command may pass the target by luck: the fastest slew is a bang-bang. The target of Zhang and Zhou 2019
    turns at 1.4 rad/s, and no command without feedback matters there.
    """
    own = scenarios.get(name)
    task = own.replace(control_period=round(max(0.04, own.control_period), 6))
    wheels = task.spacecraft.wheels
    random = np.random.default_rng(0)
    torque = np.linalg.pinv(wheels.axis_matrix) @ np.concatenate(
        [random.normal(size=(3, 10)), np.eye(3), -np.eye(3)], 1
    )
    push = np.concatenate([np.eye(wheels.count), -np.eye(wheels.count), (torque / abs(torque).max(axis=0)).T])
    count, periods = len(push), (1.0, 4.0, 20.0, 60.0)
    tumbled = np.zeros(count, dtype=bool)

    def command(time, rate):
        nonlocal tumbled
        tumbled = tumbled | (np.linalg.norm(rate[count : 2 * count], axis=1) > 2.0)
        bangs = [push * square(time, period) for period in periods]
        return np.concatenate([push, push * ~tumbled[:, None], *bangs, np.zeros((1, wheels.count))])

    env = SpacecraftFTCVectorEnv((2 + len(periods)) * count + 1, scenario=task, autoreset_mode="Disabled")
    returns = discounted(env, command)[-1]
    spin, tumble, bang = np.split(returns[:-1], [count, 2 * count])
    for kind, values in {"spin": spin, "tumble": tumble, "bang-bang": bang}.items():
        error = values.std() / np.sqrt(len(values)) if kind == "bang-bang" else 0.0
        assert values.mean() - 1.96 * error < returns[-1], kind


def test_shaping_alone_can_make_a_step_negative():
    env = SpacecraftFTCVectorEnv(64, faults=None, reward=RewardWeights(progress=100.0))
    env.reset(seed=0)
    assert (env.step(np.ones((64, 4)))[1] < 0.0).any()
