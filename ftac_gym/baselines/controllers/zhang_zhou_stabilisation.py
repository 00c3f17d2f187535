"""The fault-tolerant attitude stabilisation of Zhang and Zhou 2019."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ftac_gym.attitude import mrp_derivative, mrp_from_quaternion, quaternion_error
from ftac_gym.baselines.components.adaptation import LeakyAdaptation
from ftac_gym.baselines.components.reaching import switching
from ftac_gym.baselines.components.rows import length
from ftac_gym.baselines.components.surfaces import signed_power
from ftac_gym.baselines.controllers.zhang_zhou import ZhangZhou, ZhangZhouGains
from ftac_gym.baselines.gains import changed, parameter
from ftac_gym.task.measurement import Measurement
from ftac_gym.utils.parameters import FloatArray, non_negative


@dataclass(frozen=True)
class ZhangZhouStabilisationGains(ZhangZhouGains):
    """Gains of :class:`ZhangZhouStabilisation`."""

    linear: float = changed(ZhangZhouGains, "linear", meaning="a")
    terminal: float = changed(ZhangZhouGains, "terminal", meaning="b")
    exponent: float = changed(ZhangZhouGains, "exponent", meaning="p/q")
    rate_bound_gain: float = parameter(0.01, "mu1", "", non_negative)
    fault_bound_gain: float = parameter(0.001, "mu2", "", non_negative)


class ZhangZhouStabilisation(ZhangZhou):
    """Fast terminal sliding mode to a target at rest, Eqs. (29)-(42).

    With the MRP sigma of the attitude relative to the target and sigma' = G w::

        s   = w + a sigma + b sig(sigma)^(p/q)
        u_n = -e1 s - (e2 / N(s)) sign(s)
        u_m = J^-1 (w x J w - D b^ - W' phi) - L1 xi - (chi |sigma'| + rho |J^-1| |D|) sign(s)
        u   = E^2 D' (J^-1 D E^3 D')^-1 (u_n + u_m)
        chi' = mu1 |s| |sigma'|,  rho' = mu2 |s| |J^-1| |D|,  W' : mu3

    The derivative of a sigma + b sig(sigma)^(p/q) is not fed forward. It is dominated by chi, which like rho can only
    grow. chi and rho take one Euler step per call. The paper prints none of the gains.
    """

    gains = ZhangZhouStabilisationGains()
    rest_only: ClassVar[str] = "this law has no term for a reference rate"

    def _build(self) -> None:
        super()._build()
        own, memory, period = self.gains, self.memory, self._period
        self._norms = float(np.linalg.norm(self._inverse_inertia, 2) * np.linalg.norm(self._axes_transposed, 2))
        self._rate_bound = LeakyAdaptation(memory, "rate_bound", 1, own.rate_bound_gain, 0.0, period)
        self._fault_bound = LeakyAdaptation(memory, "fault_bound", 1, own.fault_bound_gain, 0.0, period * self._norms)

    def _variable(self, measurement: Measurement) -> tuple[FloatArray, FloatArray]:
        """Return sigma and s, each (N, 3)."""
        error = mrp_from_quaternion(quaternion_error(measurement.attitude, measurement.reference_attitude))
        power = signed_power(error, self.gains.exponent)
        return error, measurement.rate + self.gains.linear * error + self.gains.terminal * power

    def sliding_variable(self, measurement: Measurement) -> FloatArray:
        """Return s (N, 3) [rad/s] at a measurement."""
        return self._variable(measurement)[1]

    def act(self, measurement: Measurement) -> FloatArray:
        """Return the wheel torques to command, (N, wheels) [N m]."""
        rate = measurement.rate
        error, variable = self._variable(measurement)
        speed = mrp_derivative(error, rate)
        turning = length(speed)
        distance = length(variable)
        largest = self._rate_bound.value * turning + self._fault_bound.value * self._norms
        robust = largest * switching(variable, self.gains.layer)
        self._rate_bound.update(distance * turning)
        self._fault_bound.update(distance)
        return self._command(measurement, variable, self._reaching(variable) - robust)
