"""The predefined-time attitude controller of Cao, Gong and Han 2022."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from ftac_gym.attitude import (
    angular_velocity_from_mrp,
    mrp_curvature,
    mrp_derivative,
    mrp_from_quaternion,
)
from ftac_gym.baselines.components.allocation import limit_each
from ftac_gym.baselines.components.predefined_time_gain import PredefinedTime, PredefinedTimeSliding
from ftac_gym.baselines.components.reaching import switching
from ftac_gym.baselines.controllers.fault_tolerant import FaultTolerantController, FaultTolerantGains
from ftac_gym.baselines.gains import Range, parameter
from ftac_gym.baselines.rules import choice, interval
from ftac_gym.task.measurement import Measurement
from ftac_gym.utils.parameters import FloatArray, non_negative, positive


@dataclass(frozen=True)
class PTCGains(FaultTolerantGains):
    """Gains of :class:`PTC`."""

    position_exponent: float = parameter(0.25, "h1", "", interval(0.0, 1.0))
    rate_exponent: float = parameter(0.3, "h2", "", interval(0.0, 1.0), Range(0.05, 0.5))
    position_time: float = parameter(10.0, "T1", "s", positive, Range(1.0, 100.0, log=True))
    rate_time: float = parameter(10.0, "T2", "s", positive, Range(1.0, 100.0, log=True))
    position_regularisation: float = parameter(0.0, "r_a", "", non_negative, Range(1e-12, 1e-2, log=True))
    rate_regularisation: float = parameter(0.0, "r_b", "", non_negative, Range(1e-12, 1e-2, log=True))
    switching_gain: float = parameter(5.0, "k_s", "N m or 1/s^2", non_negative, Range(1e-4, 10.0, log=True))
    switching_form: str = parameter("torque", "Form of the sign term", rule=choice("torque", "acceleration"))
    layer: float = parameter(0.0, "Layer of the sign. Zero for none", "1/s", non_negative, Range(1e-4, 0.5, log=True))


class _State(NamedTuple):
    """Attitude, reference and error of the predefined-time law, each (N, 3)."""

    sigma: FloatArray
    sigma_rate: FloatArray
    error: FloatArray
    error_rate: FloatArray
    target: FloatArray
    target_rate: FloatArray | None


class PTC(FaultTolerantController):
    """Predefined-time sliding mode, Eqs. (24)-(26), corrected.

    With z1 = sigma - sigma_d, z2 = z1', V_a = ``|z1|^2`` / 2, s = z2 + xi, V_b = ``|s|^2`` / 2::

        xi = f_a z1,  f_a = exp(V_a^h1) V_a^-h1 / (2 h1 T1)
        xi' = f_a z2 + f_a h1 (V_a^h1 - 1) / V_a (z1'z2) z1
        u  = (D E^)^+ {w x J w - D b^ - sw(s) - J G^-1 (G' w - sigma_d'' + xi' + f_b s)},
        f_b = exp(V_b^h2) V_b^-h2 / (2 h2 T2)

    On the nominal plant s' = -f_b s minus the switching term: s is zero at T2 (1 - exp(-V_b(0)^h2)), and z1 after
    T1 (1 - exp(-V_a^h1)) more. T1 + T2 bounds that time as long as the wheels do not saturate.

    The sign term is printed as k_s sgn(s), a torque, which need not oppose s: s'G J^-1 sgn(s) is negative for some s.
    ``switching_form="acceleration"`` takes k_s J G^-1 sgn(s), which does, with k_s of about 0.1 1/s^2.

    The regularisations r_a and r_b are added to V_a and V_b in the negative powers; they are zero in the printed law.
    The printed lower bound of the effectiveness in (D E^)^+ is 1e-4: a wrong estimate then multiplies the torque by ten
    thousand.

    h1 = 0.5, as in Table 1, demands full speed on arrival: xi' is infinite at z1 = 0. The torque on s = 0 is bounded
    for h1 <= 0.25.
    """

    gains = PTCGains()

    def _build(self) -> None:
        super()._build()
        own = self.gains
        position = PredefinedTime(own.position_exponent, own.position_time, own.position_regularisation)
        rate = PredefinedTime(own.rate_exponent, own.rate_time, own.rate_regularisation)
        self._sliding = PredefinedTimeSliding(position, rate)
        self._as_torque = own.switching_form == "torque"

    def _state(self, measurement: Measurement) -> _State:
        sigma, rate = mrp_from_quaternion(measurement.attitude), measurement.rate
        target = mrp_from_quaternion(measurement.reference_attitude)
        sigma_rate = error_rate = mrp_derivative(sigma, rate)
        target_rate = None
        if self._moving:
            target_rate = mrp_derivative(target, measurement.reference_rate)
            error_rate = sigma_rate - target_rate
        return _State(sigma, sigma_rate, sigma - target, error_rate, target, target_rate)

    def sliding_variable(self, measurement: Measurement) -> FloatArray:
        """Return s (N, 3) [1/s] at a measurement."""
        state = self._state(measurement)
        return self._sliding.variable(state.error, state.error_rate)

    def act(self, measurement: Measurement) -> FloatArray:
        """Return the wheel torques to command, (N, wheels) [N m]."""
        rate = measurement.rate
        sigma, sigma_rate, error, error_rate, target, target_rate = self._state(measurement)
        variable, demand = self._sliding.demand(error, error_rate, mrp_curvature(sigma, sigma_rate, rate))
        if target_rate is not None:
            demand -= mrp_curvature(target, target_rate, measurement.reference_rate)
            demand -= mrp_derivative(target, measurement.reference_acceleration)
        switched = self.gains.switching_gain * switching(variable, self.gains.layer)
        if not self._as_torque:
            demand = demand + switched
        gyroscopic = self._gyroscopic.torque(rate, measurement.wheel_momentum)
        torque = gyroscopic - angular_velocity_from_mrp(sigma, demand) @ self._inertia
        if self._as_torque:
            torque = torque - switched
        return limit_each(self._to_wheels(torque, self._faults.update(measurement)), self._torque_limits)
