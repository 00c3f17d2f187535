"""Which wheels can be told apart: those that have had to give torque."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from ftac_gym.baselines.memory import Memory
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, positive


class Excitation:
    """Low-passed command of each wheel: chatter cancels in it, sustained torque stays.

    An effectiveness multiplies the command, so that it cannot be told while the command is near zero; and no estimate
    of a wheel means much before the torque has lasted. Neither paper says when its estimates are to be believed.

    Parameters
    ----------
    scenario
        The task; a wheel's threshold is a share of its torque limit, or of 1 N m without one.
    memory
        Where the average is kept.
    time_constant
        Of the low-pass [s].
    threshold
        Share of the limit that the average must exceed.
    """

    def __init__(self, scenario: Scenario, memory: Memory, time_constant: float, threshold: float) -> None:
        limits = scenario.spacecraft.wheels.torque_limits
        self._threshold = positive(threshold, "excitation_threshold") * np.where(np.isfinite(limits), limits, 1.0)
        self._time_constant = positive(time_constant, "excitation_time")
        self._memory = memory
        memory.add("sustained_torque", (len(limits),))

    def update(self, command: FloatArray, dt: float) -> None:
        """Take in the command (N, m) [N m] of a period dt [s]."""
        average = self._memory["sustained_torque"]
        share = 1.0 - math.exp(-dt / self._time_constant)
        self._memory["sustained_torque"] = average + share * (command - average)

    @property
    def identifiable(self) -> npt.NDArray[np.bool_]:
        """Which wheels can be identified, (N, m)."""
        flags: npt.NDArray[np.bool_] = np.abs(self._memory["sustained_torque"]) > self._threshold
        return flags
