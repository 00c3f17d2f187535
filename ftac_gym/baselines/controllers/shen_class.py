"""An inertia-free attitude controller within the torque limits, of the family of Shen et al."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ftac_gym.baselines.components.adaptation import LeakyAdaptation
from ftac_gym.baselines.components.allocation import limit_each
from ftac_gym.baselines.components.relative_motion import relative_motion
from ftac_gym.baselines.components.rows import dot
from ftac_gym.baselines.controllers.fault_tolerant import FaultTolerantController, FaultTolerantGains
from ftac_gym.baselines.gains import Range, fixed, parameter
from ftac_gym.baselines.observers.rate_predictor import RatePredictor
from ftac_gym.task.measurement import Measurement
from ftac_gym.utils.parameters import FloatArray, non_negative, positive


@dataclass(frozen=True)
class ShenClassGains(FaultTolerantGains):
    """Gains of :class:`ShenClass`."""

    faults: str = fixed("none")
    observer: Mapping[str, Any] | None = fixed(None)
    smallest_effectiveness: float = fixed(0.05)
    surface_gain: float = parameter(0.2, "alpha", "rad/s", positive, Range(0.02, 0.5, log=True))
    surface_steepness: float = parameter(1.8, "beta", "", positive, Range(0.5, 20.0, log=True))
    gain: float = parameter(100.0, "k", "N m s/rad", positive, Range(10.0, 200.0, log=True))
    regularisation: float = parameter(0.1, "e1", "rad/s", positive)
    smoothing: float = parameter(0.01, "mu", "rad/s", positive)
    forgetting: float = parameter(0.01, "c1", "1/s", non_negative)
    adaptation: float = parameter(0.1, "c2", "", non_negative, Range(1e-3, 1.0, log=True))
    monitor_gain: float = parameter(5.0, "L. Zero leaves f^ out", "N m s/rad", non_negative, Range(0.5, 50.0, log=True))
    monitor_threshold: float = parameter(2e-3, "Threshold of f^", "rad/s", non_negative, Range(1e-5, 1e-2, log=True))


class ShenClass(FaultTolerantController):
    """Sliding mode on w_e + alpha atan(beta q_v) with an adaptive bound and a torque that never exceeds the limit.

    The comparator [4] of Zhang and Zhou 2019 (Shen, Wang, Zhu and Poh 2015) was not available. This is the law of the
    same family that Shen, Yue, Goh and Wang published in 2019 (IEEE Transactions on Industrial Electronics 66(5))::

        S = w_e + alpha atan(beta q_v),  Phi = 1 + |w| + |w|^2
        eta = k + S'f^ / (|S|^2 + e1^2) + h^ Phi / (|S| + mu / Phi)
        h^' = -c1 h^ + c2 Phi |S|^2 / (|S| + mu / Phi)
        u = -(u_max / e0) D^+ sat(S; e0 eta / u_max),  e0 = |D^+|

    where sat(S; g) is g S, shortened to length one. f^ is the torque of a fault monitor, J w^' = -w^ x J w^ + D u + L
    (w - w^): L (w - w^) while ``|w - w^|`` exceeds a threshold, else zero. The sources leave the exact f^ open. eta is
    held above zero. Only the monitor needs the inertia.

    Raises
    ------
    ValueError
        If a gain breaks a rule or a wheel has no torque limit.
    """

    gains = ShenClassGains()
    needs_torque_limits: ClassVar[bool] = True

    def _build(self) -> None:
        super()._build()
        own = self.gains
        self._bound = LeakyAdaptation(self.memory, "torque_bound", 1, own.adaptation, own.forgetting, self._period)
        norm = float(np.linalg.norm(np.linalg.pinv(self._axes_transposed.T), 2))
        self._largest = float(self._torque_limits.min()) / norm
        self._monitor = RatePredictor(self.scenario, self.memory)

    def sliding_variable(self, measurement: Measurement) -> FloatArray:
        """Return S (N, 3) [rad/s] at a measurement."""
        motion = relative_motion(measurement.attitude, measurement, self._moving)
        bent = np.arctan(self.gains.surface_steepness * motion.error[:, 1:])
        return motion.rate_error + self.gains.surface_gain * bent

    def _monitored(self, measurement: Measurement) -> FloatArray:
        """Return f^ (N, 3) [N m] and advance the monitor."""
        torque = (
            measurement.command_in_effect @ self._axes_transposed + self.gains.monitor_gain * self._monitor.mismatch
        )
        mismatch, _ = self._monitor.update(measurement, torque, self._period)
        alarm = np.sqrt(np.einsum("ni,ni->n", mismatch, mismatch)) > self.gains.monitor_threshold
        fault_torque: FloatArray = self.gains.monitor_gain * mismatch * alarm[:, None]
        return fault_torque

    def act(self, measurement: Measurement) -> FloatArray:
        """Return the wheel torques to command, (N, wheels) [N m]."""
        variable = self.sliding_variable(measurement)
        square = dot(variable, variable)
        length = np.sqrt(square)
        speed_square = dot(measurement.rate, measurement.rate)
        growth = 1.0 + np.sqrt(speed_square) + speed_square
        soft = length + self.gains.smoothing / growth
        gain = self.gains.gain + self._bound.value * growth / soft
        if self.gains.monitor_gain > 0.0:
            along = np.einsum("ni,ni->n", variable, self._monitored(measurement))[:, None]
            gain = gain + along / (square + self.gains.regularisation**2)
        self._bound.update(growth * square / soft)
        torque = np.minimum(np.maximum(gain, 0.0), self._largest / np.maximum(length, 1e-300)) * -variable
        return limit_each(self._allocation(torque, None), self._torque_limits)
