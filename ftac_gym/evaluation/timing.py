"""What a control step costs. Here, and nowhere else in evaluations, a clock is read."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from copy import copy
from statistics import median
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np

from ftac_gym.envs import SpacecraftFTCVectorEnv
from ftac_gym.evaluation.threads import one_torch_thread
from ftac_gym.policies import resolve
from ftac_gym.task.scenario import Scenario

if TYPE_CHECKING:
    from ftac_gym.evaluation.entries import Entry

GROUPS, STEPS = 30, 20
"""Groups of control steps, and steps of each: an agent that decides every few steps does so alike in all groups."""


class Stopwatch:
    """Sums up the seconds spent inside :meth:`running`."""

    def __init__(self) -> None:
        self.seconds = 0.0

    @contextmanager
    def running(self) -> Iterator[None]:
        """Let the clock run inside."""
        started = perf_counter()
        try:
            yield
        finally:
            self.seconds += perf_counter() - started


class _TimedEnv(SpacecraftFTCVectorEnv):
    """An environment that knows what it costs itself."""

    def __init__(self, **arguments: Any) -> None:
        super().__init__(**arguments)
        self.stopwatch = Stopwatch()

    def step(self, actions: Any) -> Any:
        """Step on the clock."""
        with self.stopwatch.running():
            return super().step(actions)


def step_cost(entry: Entry, scenario: Scenario) -> float:
    """Measure one control step of one craft [us]: all that the controller computes, its base and observers included.

    The median over groups of steps of a running craft, on one thread; the environment's own time is taken off.

    Parameters
    ----------
    entry
        Whose first policy flies.
    scenario
        The task.
    """
    contestant = resolve(copy(entry.policies[0]))
    env = _TimedEnv(num_envs=1, scenario=scenario.replace(tumble_rate=None), observation=contestant.tier)
    wrapped, costs = contestant.attach(env), []
    observation, _ = wrapped.reset(seed=0)
    state, start = None, np.ones(1, dtype=np.bool_)
    with one_torch_thread():
        for _ in range(1 + GROUPS):
            whole = Stopwatch()
            env.stopwatch = Stopwatch()
            for _ in range(STEPS):
                with whole.running():
                    action, state = contestant.predict(observation, state, start, True)
                    observation, *_ = wrapped.step(action)
                start = np.zeros(1, dtype=np.bool_)
            costs.append(1e6 * (whole.seconds - env.stopwatch.seconds) / STEPS)
    return median(costs[1:])  # the first group warms up
