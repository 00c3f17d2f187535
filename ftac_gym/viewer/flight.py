"""One policy on one craft, control period by control period."""

from __future__ import annotations

from typing import Any

import numpy as np

from ftac_gym.envs.rendering.snapshot import Snapshot, snapshots
from ftac_gym.faults import Fault
from ftac_gym.faults.live import add_fault, clear_faults
from ftac_gym.policies import PolicyRunner, resolve
from ftac_gym.task.episodes import Episodes
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import require


class Flight:
    """A policy that flies an episode while somebody watches and breaks things.

    Parameters
    ----------
    scenario
        What is flown. A tumbling craft flies on.
    policy
        See :func:`~ftac_gym.policies.resolve`.
    name
        What the policy is called on the screen.

    Raises
    ------
    ValueError
        If the policy is unknown or does not fit the scenario.
    """

    def __init__(self, scenario: Scenario, policy: Any, name: str) -> None:
        self.scenario = scenario
        self.name = name
        self._runner = PolicyRunner(scenario, resolve(policy, scenario.name))
        self._batch = self._runner.env.batch

    def reset(self, episode: Episodes) -> None:
        """Start an episode: an ``Episodes`` with one in it."""
        require(len(episode) == 1, "episode", "must be one", len(episode))
        self._runner.reset(episode)

    def step(self) -> None:
        """Fly on for one control period; a flight that is over stays as it is."""
        if not self.over:
            self._runner.step()

    @property
    def time(self) -> float:
        """Since the start of the episode [s]."""
        return float(self._batch.simulator.time[0])

    @property
    def over(self) -> bool:
        """Whether the episode has come to its end."""
        return bool(self._batch.simulator.ticks[0] >= self._batch.horizon)

    @property
    def episode(self) -> Episodes:
        """The episode with what was done to it: flown again, it gives the same flight."""
        return self._batch.simulator.episodes

    def snapshot(self) -> Snapshot:
        """Return what there is to see now."""
        return snapshots(self._batch, self.name)[0]

    def strike(self, fault: Fault, random: np.random.Generator) -> None:
        """Let a fault begin now, as :func:`ftac_gym.faults.live.add_fault` does.

        Raises
        ------
        ValueError
            If the fault of a wheel names none, or one that the craft does not have, or does not fit the wheels.
        """
        simulator, wheels = self._batch.simulator, self.scenario.spacecraft.wheels
        fault.check(wheels)
        simulator.set_faults(add_fault(simulator.faults, 0, fault, self.time, wheels.torque_limits, random))

    def repair(self, wheel: int | None) -> None:
        """Put a wheel in order, or the sensors if the wheel is None."""
        simulator = self._batch.simulator
        simulator.set_faults(clear_faults(simulator.faults, 0, wheel, self.time))
