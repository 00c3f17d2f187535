"""Policies without any skill."""

import numpy as np

from ftac_gym import scenarios
from ftac_gym.evaluation import rollout
from ftac_gym.policies.resolve import resolve

TASK = scenarios.get("easy").replace(duration=2.0)


def test_zero_action_commands_nothing():
    assert not rollout(TASK, "zero", count=3).command.any()


def test_random_action_is_uniform_and_the_same_in_every_flight():
    policy = resolve("random")
    first, second = rollout(TASK, policy, count=50), rollout(TASK, policy, count=50)
    level = first.command / TASK.spacecraft.wheels.torque_limits
    assert abs(level.mean()) < 0.03 and abs(level.std() - 1.0 / np.sqrt(3.0)) < 0.02 and abs(level).max() <= 1.0
    assert len(np.unique(level)) == level.size
    np.testing.assert_array_equal(first.command, second.command)


def test_policies_without_skill_tell_themselves_apart():
    assert len({resolve("zero").fingerprint, resolve("random").fingerprint}) == 2
