"""An inertia-free, saturation-respecting attitude controller of the family of Shen et al."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from ftac_gym.baselines.components.adaptation import LeakyAdaptation
from ftac_gym.baselines.components.allocation import limit_each
from ftac_gym.baselines.components.relative_motion import relative_motion
from ftac_gym.baselines.controllers.fault_tolerant import FaultTolerantController
from ftac_gym.baselines.gains import Range, SearchSpace
from ftac_gym.baselines.observers.rate_predictor import RatePredictor
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, fields_named, non_negative, positive, require


class ShenClass(FaultTolerantController):
    """Sliding mode on w_e + alpha atan(beta q_v) with an adaptive bound and a torque that never exceeds the limit.

    The comparator [4] of Zhang and Zhou 2019 (Shen, Wang, Zhu and Poh 2015) was not to be had; this is the law of the
    same family that Shen, Yue, Goh and Wang published in 2019 (IEEE Transactions on Industrial Electronics 66(5)):

        S = w_e + alpha atan(beta q_v),  Phi = 1 + |w| + |w|^2
        eta = k + S'f^ / (|S|^2 + e1^2) + h^ Phi / (|S| + mu / Phi)
        h^' = -c1 h^ + c2 Phi |S|^2 / (|S| + mu / Phi)
        u = -(u_max / e0) D^+ sat(S; e0 eta / u_max),  e0 = |D^+|

    where sat(S; g) is g S, shortened to length one. f^ is the torque of a fault monitor, J w^' = -w^ x J w^ + D u +
    L (w - w^): L (w - w^) while |w - w^| exceeds a threshold, else zero; what f^ is exactly, the sources leave open.
    eta is held above zero. Nothing but the monitor needs the inertia.

    Parameters
    ----------
    scenario, num_spacecraft
        As for every baseline; every wheel needs a torque limit.
    surface_gain, surface_steepness
        alpha [rad/s], beta.
    gain
        k [N m s/rad].
    regularisation
        e1 [rad/s].
    smoothing
        mu [rad/s].
    forgetting, adaptation
        c1 [1/s], c2.
    monitor_gain
        L [N m s/rad]; zero leaves f^ out.
    monitor_threshold
        [rad/s].

    Raises
    ------
    ValueError
        If a gain breaks a rule or a wheel has no torque limit.
    """

    search_space: ClassVar[SearchSpace] = {
        "surface_gain": Range(0.02, 0.5, log=True),
        "surface_steepness": Range(0.5, 20.0, log=True),
        "gain": Range(10.0, 200.0, log=True),
        "adaptation": Range(1e-3, 1.0, log=True),
        "monitor_gain": Range(0.5, 50.0, log=True),
        "monitor_threshold": Range(1e-5, 1e-2, log=True),
    }

    def __init__(
        self,
        scenario: Scenario,
        num_spacecraft: int = 1,
        surface_gain: float = 0.2,
        surface_steepness: float = 1.8,
        gain: float = 100.0,
        regularisation: float = 0.1,
        smoothing: float = 0.01,
        forgetting: float = 0.01,
        adaptation: float = 0.1,
        monitor_gain: float = 5.0,
        monitor_threshold: float = 2e-3,
    ) -> None:
        super().__init__(scenario, num_spacecraft)
        limited = bool(np.isfinite(self._torque_limits).all())
        require(limited, "torque_limit", "must be finite for every wheel", self._torque_limits.tolist())
        self._surface_gain = positive(surface_gain, "surface_gain")
        self._surface_steepness = positive(surface_steepness, "surface_steepness")
        self._gain = positive(gain, "gain")
        self._regularisation = positive(regularisation, "regularisation")
        self._smoothing = positive(smoothing, "smoothing")
        with fields_named(gain="adaptation", leak="forgetting"):
            self._bound = LeakyAdaptation(self.memory, "torque_bound", 1, adaptation, forgetting, self._period)
        self._monitor_gain = non_negative(monitor_gain, "monitor_gain")
        self._threshold = non_negative(monitor_threshold, "monitor_threshold")
        inverse = np.linalg.pinv(self._axes_transposed.T)
        self._norm = float(np.linalg.norm(inverse, 2))
        self._largest = float(self._torque_limits.min()) / self._norm
        self._monitor = RatePredictor(scenario, self.memory)

    def sliding_variable(self, measurement: Measurement) -> FloatArray:
        """Return S (N, 3) [rad/s] at a measurement."""
        motion = relative_motion(measurement.attitude, measurement, self.scenario.reference.moving)
        bent = np.arctan(self._surface_steepness * motion.error[:, 1:])
        variable: FloatArray = motion.rate_error + self._surface_gain * bent
        return variable

    def _monitored(self, measurement: Measurement) -> FloatArray:
        """Return f^ (N, 3) [N m] and move the monitor on."""
        torque = measurement.last_command @ self._axes_transposed + self._monitor_gain * self._monitor.mismatch
        mismatch, _ = self._monitor.update(measurement, torque, self._period)
        alarm = np.sqrt(np.einsum("ni,ni->n", mismatch, mismatch)) > self._threshold
        seen: FloatArray = self._monitor_gain * mismatch * alarm[:, None]
        return seen

    def act(self, measurement: Measurement) -> FloatArray:
        """Return the wheel torques to command, (N, wheels) [N m]."""
        variable = self.sliding_variable(measurement)
        square = np.einsum("ni,ni->n", variable, variable)[:, None]
        length = np.sqrt(square)
        speed_square = np.einsum("ni,ni->n", measurement.rate, measurement.rate)[:, None]
        growth = 1.0 + np.sqrt(speed_square) + speed_square
        soft = length + self._smoothing / growth
        gain = self._gain + self._bound.value * growth / soft
        if self._monitor_gain > 0.0:
            along = np.einsum("ni,ni->n", variable, self._monitored(measurement))[:, None]
            gain = gain + along / (square + self._regularisation**2)
        self._bound.update(growth * square / soft)
        torque = np.minimum(np.maximum(gain, 0.0), self._largest / np.maximum(length, 1e-300)) * -variable
        return limit_each(self._allocation(torque, None), self._torque_limits)
