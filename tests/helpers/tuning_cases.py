"""A short task and small baselines for tests of tuning."""

from typing import ClassVar

import numpy as np

from ftac_gym import scenarios
from ftac_gym.baselines import Range, registry
from ftac_gym.baselines.controllers.pd import PD
from ftac_gym.evaluation.tuning_objective import Search
from ftac_gym.task.initial_state import InitialState
from ftac_gym.task.objective import SuccessCriterion

# Small turns, which fit into four seconds.
TINY = scenarios.get("flagship").replace(
    duration=4.0, success=SuccessCriterion(hold=1.0), initial_state=InitialState(angle=(0.0, 0.05))
)
SEARCH = Search("pd", TINY, episodes=5)


def judge(search, gains):
    """Return a value with its maximum, zero, at a rate gain of 1.2 and a braking share of 0.4."""
    return -25.0 * (gains["rate_gain"] - 1.2) ** 2 - 10.0 * (gains["braking_share"] - 0.4) ** 2


class SelectivePD(PD):
    """A baseline that refuses half of its search space, and diverges in some of the rest."""

    search_space: ClassVar = {"rate_gain": Range(0.8, 1.6), "braking_share": Range(0.2, 1.8)}
    gains_at = classmethod(lambda cls, point: dict(point))

    def __init__(self, scenario, num_spacecraft=1, **gains):
        super().__init__(scenario, num_spacecraft, **gains)
        self.diverges = gains.get("rate_gain", 0.8) > 1.4

    def act(self, measurement):
        return super().act(measurement) * (np.nan if self.diverges else 1.0)


class DirectPD(PD):
    """A baseline whose gains are searched directly."""

    search_space: ClassVar = {"braking_share": Range(0.2, 1.0), "rate_limit": Range(0.4, 2.5, log=True)}
    gains_at = classmethod(lambda cls, point: dict(point))


def register(monkeypatch):
    """Register both baselines for the time of a test, as "selective" and "direct"."""
    for name, law in (("selective", SelectivePD), ("direct", DirectPD)):
        monkeypatch.setitem(registry.ENTRIES, name, registry.Entry(law))
