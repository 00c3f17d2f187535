"""Excitation of the wheels: the condition under which the effectiveness of a wheel can be identified."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ftac_gym.baselines.gains import Gains, parameter
from ftac_gym.baselines.memory import Memory
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, positive


@dataclass(frozen=True)
class ExcitationGains(Gains):
    """Gains of an observer that identifies the excited wheels."""

    excitation_time: float = parameter(2.0, "Time constant of the low-passed command", "s", positive)
    excitation_threshold: float = parameter(0.05, "Threshold of it over the torque limit", "", positive)


class Excitation:
    """Low-passed command of each wheel: chatter cancels in it, sustained torque stays.

    An effectiveness multiplies the command, so that it cannot be identified while the command is near zero. An estimate
    needs sustained torque. Neither paper states when its estimates are valid.

    Parameters
    ----------
    scenario
        The task; a wheel's threshold is a share of its torque limit, or of 1 N m without one.
    memory
        Store of the average.
    gains
        Time constant and threshold.
    """

    def __init__(self, scenario: Scenario, memory: Memory, gains: ExcitationGains) -> None:
        limits = scenario.spacecraft.wheels.torque_limits
        self._threshold = gains.excitation_threshold * np.where(np.isfinite(limits), limits, 1.0)
        self._time_constant = gains.excitation_time
        self._memory = memory
        memory.add("sustained_torque", (len(limits),))

    def update(self, command: FloatArray, dt: float) -> None:
        """Take in the command (N, m) [N m] of a period dt [s]."""
        average = self._memory["sustained_torque"]
        share = 1.0 - math.exp(-dt / self._time_constant)
        self._memory["sustained_torque"] = average + share * (command - average)

    @property
    def identifiable(self) -> npt.NDArray[np.bool_]:
        """Mask of the wheels that can be identified, (N, m)."""
        flags: npt.NDArray[np.bool_] = np.abs(self._memory["sustained_torque"]) > self._threshold
        return flags
