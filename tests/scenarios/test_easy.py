"""The easy task: the flagship without faults, near its target, and success that separates policies."""

import numpy as np

from ftac_gym import scenarios
from ftac_gym.evaluation import rollout
from ftac_gym.task import Scenario

EASY, FLAGSHIP = scenarios.get("easy"), scenarios.get("flagship")


def test_everything_else_is_the_flagship():
    easy, flagship = EASY.to_dict(), FLAGSHIP.to_dict()
    different = {name for name in easy if easy[name] != flagship[name]}
    assert different == {"name", "initial_state", "faults", "duration", "reward", "success"}
    assert EASY.faults is None and EASY.duration == 60.0
    assert Scenario.from_json(EASY.to_json()) == EASY


def test_starts_are_near_the_target():
    episodes = EASY.draw(0, 2000)
    angles = np.degrees(2.0 * np.arccos(np.abs(episodes.initial["attitude"][:, 0])))
    assert angles.min() < 0.1 and 19.9 < angles.max() < 20.0
    assert np.all(episodes.feasible)


def test_a_controller_succeeds_and_zero_action_fails():
    """Success means the last 20 s within 1 deg and 0.2 deg/s."""
    policies = ("pd", lambda observation: np.zeros(4))
    pd, idle = (rollout("easy", policy, seed=1, count=100).metrics() for policy in policies)
    assert pd["success"].mean() == 1.0
    assert idle["success"].mean() < 0.05
