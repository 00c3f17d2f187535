"""The predefined-time attitude controller of Cao, Gong and Han 2022."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, NamedTuple

from ftac_gym.attitude import (
    angular_velocity_from_mrp,
    mrp_curvature,
    mrp_derivative,
    mrp_from_quaternion,
)
from ftac_gym.baselines.components.allocation import limit_each
from ftac_gym.baselines.components.predefined_time_gain import PredefinedTime, PredefinedTimeSliding
from ftac_gym.baselines.components.reaching import switching
from ftac_gym.baselines.controllers.fault_tolerant import FaultTolerantController
from ftac_gym.baselines.gains import Range, SearchSpace
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, fields_named, non_negative, require


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

    With z1 = sigma - sigma_d, z2 = z1', V_a = |z1|^2 / 2, s = z2 + xi, V_b = |s|^2 / 2:

        xi = f_a z1,  f_a = exp(V_a^h1) V_a^-h1 / (2 h1 T1)
        xi' = f_a z2 + f_a h1 (V_a^h1 - 1) / V_a (z1'z2) z1
        u  = (D E^)^+ {w x J w - D b^ - sw(s) - J G^-1 (G' w - sigma_d'' + xi' + f_b s)},
        f_b = exp(V_b^h2) V_b^-h2 / (2 h2 T2)

    On the nominal plant s' = -f_b s minus the switching term: s is zero at T2 (1 - exp(-V_b(0)^h2)), and z1 after
    T1 (1 - exp(-V_a^h1)) more. T1 + T2 bounds that time as long as the wheels do not saturate.

    The sign term is printed as k_s sgn(s), a torque, which need not oppose s: s'G J^-1 sgn(s) is negative for some s.
    ``switching_form="acceleration"`` takes k_s J G^-1 sgn(s), which does; there k_s counts in 1/s^2.

    h1 = 0.5, as in Table 1, asks for full speed on arrival: xi' is infinite at z1 = 0. The torque on s = 0 is bounded
    for h1 <= 0.25.

    Parameters
    ----------
    scenario, num_spacecraft
        As for every baseline.
    faults, observer
        Where the estimates of the faults come from.
    position_exponent, rate_exponent
        h1, h2.
    position_time, rate_time
        T1, T2 [s].
    position_regularisation, rate_regularisation
        Added to V_a and V_b in the negative powers; zero for the law itself.
    switching_gain
        k_s [N m], or [1/s^2] with ``switching_form="acceleration"``, where some 0.1 will do.
    switching_form
        ``"torque"`` (printed) or ``"acceleration"``.
    layer
        Boundary layer of the sign [1/s]; zero takes the sign, as printed.
    smallest_effectiveness
        An effectiveness believed smaller counts as this in (D E^)^+; 1e-4 is printed, and lets an observer that is
        wrong multiply the torque by ten thousand.

    Raises
    ------
    ValueError
        If a gain breaks a rule.
    """

    search_space: ClassVar[SearchSpace] = {
        "position_time": Range(1.0, 100.0, log=True),
        "rate_time": Range(1.0, 100.0, log=True),
        "rate_exponent": Range(0.05, 0.5),
        "position_regularisation": Range(1e-12, 1e-2, log=True),
        "rate_regularisation": Range(1e-12, 1e-2, log=True),
        "switching_gain": Range(1e-4, 10.0, log=True),
        "layer": Range(1e-4, 0.5, log=True),
    }

    def __init__(
        self,
        scenario: Scenario,
        num_spacecraft: int = 1,
        faults: str = "none",
        observer: Mapping[str, Any] | None = None,
        position_exponent: float = 0.25,
        rate_exponent: float = 0.3,
        position_time: float = 10.0,
        rate_time: float = 10.0,
        position_regularisation: float = 0.0,
        rate_regularisation: float = 0.0,
        switching_gain: float = 5.0,
        switching_form: str = "torque",
        layer: float = 0.0,
        smallest_effectiveness: float = 0.05,
    ) -> None:
        super().__init__(
            scenario, num_spacecraft, faults=faults, observer=observer, smallest_effectiveness=smallest_effectiveness
        )
        with fields_named("position_"):
            position = PredefinedTime(position_exponent, position_time, position_regularisation)
        with fields_named("rate_"):
            rate = PredefinedTime(rate_exponent, rate_time, rate_regularisation)
        self._sliding = PredefinedTimeSliding(position, rate)
        self._switching_gain = non_negative(switching_gain, "switching_gain")
        known = ("torque", "acceleration")
        require(switching_form in known, "switching_form", f"must be one of {list(known)}", switching_form)
        self._as_torque = switching_form == "torque"
        self._layer = non_negative(layer, "layer")
        self._moving = scenario.reference.moving

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
        variable, wanted = self._sliding.demand(error, error_rate, mrp_curvature(sigma, sigma_rate, rate))
        if target_rate is not None:
            wanted -= mrp_curvature(target, target_rate, measurement.reference_rate)
            wanted -= mrp_derivative(target, measurement.reference_acceleration)
        switched = self._switching_gain * switching(variable, self._layer)
        if not self._as_torque:
            wanted = wanted + switched
        gyroscopic = self._gyroscopic.torque(rate, measurement.wheel_momentum)
        torque = gyroscopic - angular_velocity_from_mrp(sigma, wanted) @ self._inertia
        if self._as_torque:
            torque = torque - switched
        return limit_each(self._to_wheels(torque, self._faults.update(measurement)), self._torque_limits)
