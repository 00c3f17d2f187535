"""Sessions of the viewer: pause, step, speed, faults and restarts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ftac_gym.faults import Fault, WheelFault
from ftac_gym.faults.specification import example, kinds
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import require
from ftac_gym.viewer.live_episode import LiveEpisode

SLOWEST, FASTEST = 0.125, 16.0
"""Limits of the speed, in seconds of the episode per second."""


class Session:
    """Policies that fly the same episode side by side, with controls for the viewer.

    Parameters
    ----------
    scenario
        The task.
    policies
        One or more policies by the names to show; see :func:`~ftac_gym.policies.resolve`.
    seed, episode
        The first episode.

    Attributes
    ----------
    live
        The episode of each policy.
    kind
        Name of the fault to add next.
    paused, speed
        Whether time stands still, and seconds of the episode per second.

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
        self.live = [LiveEpisode(scenario, policy, name) for name, policy in policies.items()]
        self.kinds = kinds()
        self.kind = next(iter(self.kinds))
        self.seed, self.episode = seed, episode
        self.paused, self.speed = False, 1.0
        self.restart()

    @property
    def time(self) -> float:
        """Time since the start of the episode [s]."""
        return self.live[0].time

    @property
    def over(self) -> bool:
        """True after the end of the episode."""
        return self.live[0].over

    def restart(self, episode: int | None = None) -> None:
        """Start the same episode again, or another one of the seed, without the faults that were added."""
        self.episode = self.episode if episode is None else episode
        drawn = self.scenario.draw_episodes([self.seed], np.array([self.episode]))
        for live in self.live:
            live.reset(drawn)
        self._remaining, self._added = 0.0, 0

    def run(self, seconds: float) -> None:
        """Advance by a time of the viewer [s], in whole control periods; the remainder is added to the next call."""
        if self.paused or self.over:
            return
        period = self.scenario.control_period
        self._remaining += seconds * self.speed
        # The tolerance keeps sums of rounded times from losing a period.
        periods = int(self._remaining / period + 1e-6)
        self._remaining -= periods * period
        for _ in range(periods):
            self.step()

    def step(self) -> None:
        """Fly for one control period."""
        for live in self.live:
            live.step()

    def change_speed(self, factor: float) -> None:
        """Multiply the speed, within its limits."""
        self.speed = min(max(self.speed * factor, SLOWEST), FASTEST)

    def choose_kind(self, offset: int) -> None:
        """Choose the kind of fault at an offset from the present one in the list."""
        names = list(self.kinds)
        self.kind = names[(names.index(self.kind) + offset) % len(names)]

    def add_fault(self, wheel: int, fault: Fault | None = None) -> bool:
        """Add a fault that begins now to all spacecraft, with the same draws.

        Parameters
        ----------
        wheel
            The affected wheel; faults of sensors ignore it.
        fault
            The fault; None takes the example of the chosen kind.

        Returns
        -------
        Whether there is such a wheel, and the fault fits it.
        """
        kind = self.kinds[self.kind]
        if not self._has(wheel):
            return False
        try:
            chosen = fault or example(kind, **({"wheel": wheel} if issubclass(kind, WheelFault) else {}))
            for live in self.live:
                # The draws depend only on the episode and on the number of faults before.
                live.add_fault(chosen, np.random.default_rng([self.seed, self.episode, self._added]))
        except ValueError:
            return False
        self._added += 1
        return True

    def clear_faults(self, wheel: int) -> bool:
        """End all faults of a wheel on all spacecraft; return whether there is such a wheel."""
        if self._has(wheel):
            for live in self.live:
                live.clear_faults(wheel)
        return self._has(wheel)

    def clear_all_faults(self) -> None:
        """End all faults of wheels and sensors on all spacecraft."""
        for live in self.live:
            for wheel in (None, *range(self.scenario.spacecraft.wheels.count)):
                live.clear_faults(wheel)

    def _has(self, wheel: int) -> bool:
        return wheel < self.scenario.spacecraft.wheels.count
