"""What a viewer can do: pause, step, change the speed, break and mend wheels, start again."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ftac_gym.faults import Fault, WheelFault
from ftac_gym.faults.specification import example, kinds
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import require
from ftac_gym.viewer.flight import Flight

SLOWEST, FASTEST = 0.125, 16.0
"""Limits of the speed, in seconds of the episode per second."""


class Session:
    """Policies that fly the same episode side by side, and the knobs of who watches them.

    Parameters
    ----------
    scenario
        What is flown.
    policies
        One or more, by the names that are shown; see :func:`~ftac_gym.policies.resolve`.
    seed, episode
        The first episode.

    Raises
    ------
    ValueError
        If there is no policy, one is unknown or does not fit the scenario, or a number is negative.
    """

    def __init__(self, scenario: Scenario, policies: Mapping[str, Any], seed: int = 0, episode: int = 0) -> None:
        require(len(policies) > 0, "policies", "must be one at least", dict(policies))
        for name, number in (("seed", seed), ("episode", episode)):
            require(number >= 0, name, "must not be negative", number)
        self.scenario = scenario
        self.flights = [Flight(scenario, policy, name) for name, policy in policies.items()]
        self.kinds = kinds()
        self.kind = next(iter(self.kinds))
        """Name of the fault that strikes next."""
        self.seed, self.episode = seed, episode
        self.paused = False
        self.speed = 1.0
        self._owed = 0.0
        self._struck = 0
        self.restart()

    @property
    def time(self) -> float:
        """Of the episode [s]."""
        return self.flights[0].time

    @property
    def over(self) -> bool:
        """Whether the episode has come to its end."""
        return self.flights[0].over

    def restart(self, episode: int | None = None) -> None:
        """Start the same episode again, or another one of the seed; what was broken live is whole again."""
        self.episode = self.episode if episode is None else episode
        drawn = self.scenario.draw_episodes([self.seed], np.array([self.episode]))
        for flight in self.flights:
            flight.reset(drawn)
        self._owed, self._struck = 0.0, 0

    def run(self, seconds: float) -> None:
        """Let so many seconds of the viewer's time go by.

        The episode moves in whole control periods; what is left over counts next time.
        """
        if self.paused or self.over:
            return
        period = self.scenario.control_period
        self._owed += seconds * self.speed
        # A little early rather than late: sums of rounded times must not lose a period.
        periods = int(self._owed / period + 1e-6)
        self._owed -= periods * period
        for _ in range(periods):
            self.step()

    def step(self) -> None:
        """Fly on for one control period."""
        for flight in self.flights:
            flight.step()

    def hurry(self, factor: float) -> None:
        """Multiply the speed, within its limits."""
        self.speed = min(max(self.speed * factor, SLOWEST), FASTEST)

    def choose(self, step: int) -> None:
        """Take another kind of fault, so many further in the list."""
        names = list(self.kinds)
        self.kind = names[(names.index(self.kind) + step) % len(names)]

    def strike(self, wheel: int, fault: Fault | None = None) -> bool:
        """Let a fault begin now on all craft, the same one.

        Parameters
        ----------
        wheel
            The wheel it strikes; faults of sensors strike whatever the number.
        fault
            The fault; None takes the example of the chosen kind.

        Returns
        -------
        Whether there is such a wheel, and the fault fits it.
        """
        if wheel >= self.scenario.spacecraft.wheels.count:
            return False
        kind = self.kinds[self.kind]
        try:
            chosen = fault or example(kind, **({"wheel": wheel} if issubclass(kind, WheelFault) else {}))
            for flight in self.flights:
                # The same draws for everyone, and for the same keys at the same times.
                flight.strike(chosen, np.random.default_rng([self.seed, self.episode, self._struck]))
        except ValueError:
            return False
        self._struck += 1
        return True

    def repair(self, wheel: int | None) -> bool:
        """Put a wheel in order on all craft, or their sensors if it is None; tell whether there is such a wheel."""
        if wheel is not None and wheel >= self.scenario.spacecraft.wheels.count:
            return False
        for flight in self.flights:
            flight.repair(wheel)
        return True

    def repair_all(self) -> None:
        """Put all wheels and the sensors in order."""
        for wheel in (None, *range(self.scenario.spacecraft.wheels.count)):
            self.repair(wheel)
