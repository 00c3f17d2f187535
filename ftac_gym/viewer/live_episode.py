"""An episode of one policy on one spacecraft, which is stepped and changed while it runs."""

from __future__ import annotations

from typing import Any

import numpy as np

from ftac_gym.envs.rendering.snapshot import Snapshot, snapshots
from ftac_gym.faults import Fault
from ftac_gym.faults.live import add_fault, clear_faults
from ftac_gym.policies import PolicyRunner, resolve
from ftac_gym.task.episodes import Episodes
from ftac_gym.task.scenario import Scenario


class LiveEpisode:
    """A policy that flies an episode in which faults are added and cleared while it runs.

    Parameters
    ----------
    scenario
        The task. A tumbling spacecraft is not taken out.
    policy
        See :func:`~ftac_gym.policies.resolve`.
    name
        Name of the policy on the screen.

    Raises
    ------
    ValueError
        If the policy is unknown or does not fit the scenario.
    """

    def __init__(self, scenario: Scenario, policy: Any, name: str) -> None:
        self.scenario = scenario
        self.name = name
        # An attached policy holds its environment, and one policy may fly in several episodes at once.
        self._runner = PolicyRunner(scenario, resolve(policy, scenario.name))
        self._batch = self._runner.env.batch
        self._simulator = self._batch.simulator

    def reset(self, episode: Episodes) -> None:
        """Start an episode, an ``Episodes`` of length one."""
        self._runner.reset(episode)

    def step(self) -> None:
        """Fly for one control period; after its end, the episode stays as it is."""
        if not self.over:
            self._runner.step()

    @property
    def time(self) -> float:
        """Time since the start of the episode [s]."""
        return float(self._simulator.time[0])

    @property
    def over(self) -> bool:
        """True after the end of the episode."""
        return bool(self._simulator.ticks[0] >= self._batch.horizon)

    @property
    def episode(self) -> Episodes:
        """The episode with all faults that were added and cleared: flown again, it gives the same states."""
        return self._simulator.episodes

    def snapshot(self) -> Snapshot:
        """Return the present state for the view."""
        return snapshots(self._batch, self.name)[0]

    def add_fault(self, fault: Fault, random: np.random.Generator) -> None:
        """Add a fault that begins now, as :func:`ftac_gym.faults.live.add_fault` does.

        Raises
        ------
        ValueError
            If a wheel fault names no wheel or a missing one, or does not fit the wheels.
        """
        wheels = self.scenario.spacecraft.wheels
        fault.check(wheels)
        faults = add_fault(self._simulator.faults, 0, fault, self.time, wheels.torque_limits, random)
        self._simulator.set_faults(faults)

    def clear_faults(self, wheel: int | None) -> None:
        """End all faults of a wheel, or of the sensors if it is None."""
        self._simulator.set_faults(clear_faults(self._simulator.faults, 0, wheel, self.time))
