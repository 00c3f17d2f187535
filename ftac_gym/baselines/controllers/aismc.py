"""The adaptive integral sliding-mode control that Li, Xu and Chang 2023 compare theirs with."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ftac_gym.attitude import cross
from ftac_gym.baselines.components.relative_motion import RelativeMotion
from ftac_gym.baselines.components.takagi_sugeno import TriangularSets
from ftac_gym.baselines.controllers.flexible import FlexibleController, ScheduledGains, scheduled_feedback
from ftac_gym.baselines.gains import Range, fixed, parameter
from ftac_gym.task.measurement import Measurement
from ftac_gym.utils.parameters import FloatArray, non_negative, positive


@dataclass(frozen=True)
class AISMCGains(ScheduledGains):
    """Gains of :class:`AISMC`."""

    faults: str = fixed("none")
    observer: None = fixed(None)
    margin: float = parameter(0.002, "sigma", "N m", non_negative, Range(1e-4, 0.1, log=True))
    layer: float = parameter(0.01, "sigma'", "rad/s", positive, Range(1e-3, 0.3, log=True))


class AISMC(FlexibleController):
    """Eqs. (70), (71) of Li et al. 2023, after Li, Liu and Shi 2020.

    ::

        torque = -(sum h_i |K_i s| + sigma + |S|) s / (|s| + layer) - g(s)
        S = s - integral of sum h_i (A_i + B K_i) s

    There is no observer: faults, disturbance and vibration are left to ``|S|``. It grows while s deviates from the
    motion by A_i + B K_i, without the direction of the deviation. K_i is that of the fuzzy controller: the paper takes
    it from a theorem of another one. The integral is the trapezoidal rule.

    Raises
    ------
    ValueError
        If the spacecraft is rigid, a gain breaks a rule, or K_i leaves an unstable s for this spacecraft.
    """

    gains = AISMCGains()

    def _build(self) -> None:
        super()._build()
        self._feedback = scheduled_feedback(self.scenario, self.gains.design)
        self._quick_inverse: FloatArray = np.linalg.inv(self._quick_inertia).astype(np.float64)
        self._membership = TriangularSets()
        self.memory.add("integral", (3,))
        self.memory.add("last_slope", (3,))
        self.memory.add("fresh", (1,), initial=True)

    def _torque(self, measurement: Measurement, motion: RelativeMotion, variable: FloatArray) -> FloatArray:
        memory, rate = self.memory, measurement.rate
        weights = self._membership(rate)
        feedback = np.einsum("rij,nj->nri", self._feedback, variable)
        pull = np.einsum("nr,nri->ni", weights, feedback) - cross(rate, variable @ self._inertia)
        slope = pull @ self._quick_inverse
        fresh = memory["fresh"]
        area = (0.5 * self._period) * (slope + memory["last_slope"])
        memory["integral"] = memory["integral"] + np.where(fresh, 0.0, area)
        memory["last_slope"], memory["fresh"] = slope, np.zeros_like(fresh)

        bound = np.linalg.norm(variable - memory["integral"], axis=1)
        gain = np.einsum("nr,nr->n", weights, np.linalg.norm(feedback, axis=2)) + self.gains.margin + bound
        size = np.linalg.norm(variable, axis=1) + self.gains.layer
        torque: FloatArray = -(gain / size)[:, None] * variable
        return torque - self._nonlinear_torque(measurement, motion)
