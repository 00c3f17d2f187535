"""Cost of a control step: the only clock in evaluations."""

from collections.abc import Iterator
from contextlib import contextmanager
from statistics import median
from time import perf_counter
from typing import Any

from ftac_gym.evaluation.entries import Entry
from ftac_gym.evaluation.threads import one_torch_thread
from ftac_gym.policies import PolicyRunner, resolve
from ftac_gym.task.scenario import Scenario

GROUPS, STEPS = 30, 20
"""Groups of control steps, and steps of each: agents with an action hold decide equally often in all groups."""


class Stopwatch:
    """Sum of the seconds spent inside :meth:`running`."""

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


def step_cost(entry: Entry, scenario: Scenario) -> float:
    """Measure one control step of one spacecraft [us]: the policy with its base and observers.

    It is the median over groups of steps in one episode, on one thread, without the time of the environment.

    Parameters
    ----------
    entry
        Entry whose first policy acts.
    scenario
        The task.
    """
    duration = max(scenario.duration, (1 + GROUPS) * STEPS * scenario.control_period)
    runner = PolicyRunner(scenario.replace(duration=duration), resolve(entry.policies[0]))
    runner.reset(runner.env.scenario.draw(0, 1))
    step, whole, environment = runner.env.step, Stopwatch(), Stopwatch()

    def timed_step(actions: Any) -> Any:
        with environment.running():
            return step(actions)

    runner.env.step = timed_step  # type: ignore[method-assign]
    costs = []
    with one_torch_thread():
        for _ in range(1 + GROUPS):
            before = whole.seconds - environment.seconds
            for _ in range(STEPS):
                with whole.running():
                    runner.step()
            costs.append(1e6 * (whole.seconds - environment.seconds - before) / STEPS)
    return median(costs[1:])  # the first group warms up
