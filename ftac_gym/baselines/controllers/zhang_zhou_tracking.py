"""The fault-tolerant attitude tracking of Zhang and Zhou 2019."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ftac_gym.attitude import (
    angular_velocity_from_mrp,
    mrp_curvature,
    mrp_derivative,
    mrp_from_quaternion,
)
from ftac_gym.baselines.components.adaptation import LeakyAdaptation
from ftac_gym.baselines.components.reaching import switching
from ftac_gym.baselines.components.rows import dot
from ftac_gym.baselines.components.surfaces import NonsingularTerminalSurface
from ftac_gym.baselines.controllers.zhang_zhou import ZhangZhou, ZhangZhouGains
from ftac_gym.baselines.gains import Range, changed, parameter
from ftac_gym.task.measurement import Measurement
from ftac_gym.utils.parameters import FloatArray, finite, flag, non_negative, positive, require


@dataclass(frozen=True)
class ZhangZhouTrackingGains(ZhangZhouGains):
    """Gains of :class:`ZhangZhouTracking`; the paper prints k1, k2 and those of the reaching law."""

    virtual_gain: float = parameter(0.6, "c", "1/s", positive, Range(0.01, 1.0, log=True))
    linear: float = changed(ZhangZhouGains, "linear", meaning="k1")
    terminal: float = changed(ZhangZhouGains, "terminal", meaning="k2")
    exponent: float = changed(ZhangZhouGains, "exponent", meaning="r of S")
    bound: float = parameter(0.05, "mu of S", "", positive)
    feed_forward: bool = parameter(False, "Whether k2 S'(z1) z1' is subtracted; not printed", rule=flag)
    bound_gain: float = parameter(0.01, "theta1", "", non_negative)
    coupling_gain: float = parameter(0.01, "theta3", "", non_negative)
    coupling_high: float = parameter(0.02, "delta_m, above delta_n", "", finite)
    coupling_low: float = parameter(0.01, "delta_n", "", positive)
    initial_eta: float = parameter(1.0, "eta(0), at least eta_min", "", finite)
    smallest_eta: float = parameter(1e-3, "eta_min", "", positive)

    def __post_init__(self) -> None:
        """Check the fields."""
        super().__post_init__()
        rule = f"must exceed coupling_low = {self.coupling_low!r} > 0"
        require(self.coupling_high > self.coupling_low, "coupling_high", rule, self.coupling_high)
        rule = f"must be at least {self.smallest_eta!r}"
        require(self.initial_eta >= self.smallest_eta, "initial_eta", rule, self.initial_eta)


class _State(NamedTuple):
    """Errors and feed-forward of the tracking law, each (N, 3)."""

    error: FloatArray
    error_rate: FloatArray
    virtual_acceleration: FloatArray
    variable: FloatArray
    slope: FloatArray


class ZhangZhouTracking(ZhangZhou):
    """Non-singular fast terminal sliding mode with backstepping, Eqs. (56)-(76), corrected.

    With z1 = sigma - sigma_d and the virtual rate w_d = G^-1 (sigma_d' - c z1) (the print has both signs minus)::

        z2  = w - w_d,  z1' = -c z1 + G z2
        s   = z2 + k1 z1 + k2 S(z1)
        u_1 = -e3 s - (e4 / N(s)) sign(s)
        u_2 = J^-1 (w x J w - D b^ - W' phi) - L1 xi + w_d' - k1 z1' - Omega sign(s)
              - s (1 + eta) |z1' G z2| / (|s|^2 + delta_n)          [- k2 S'(z1) z1' with ``feed_forward``]
        u   = E^2 D' (J^-1 D E^3 D')^-1 (u_1 + u_2)
        Omega' = theta1 |s|,  W' : theta2
        eta'   = (theta3 / eta) (eta |s|^2 - delta_m) / (|s|^2 + delta_n) |z1' G z2|,  eta >= eta_min

    w_d' = G^-1 [sigma_d'' - c z1' - G' w_d] is exact: sigma' = G w is known, so that neither a differentiator nor the
    acceleration is needed. The print lets eta reach zero in finite time, where its derivative is infinite: it is held
    above ``smallest_eta``. Omega can only grow. Omega, eta and the network take one Euler step per call. The error z1
    is the difference of MRPs, not the rotation between them, and jumps where sigma changes to its shadow.
    """

    gains = ZhangZhouTrackingGains()

    def _build(self) -> None:
        super()._build()
        own = self.gains
        self._surface = NonsingularTerminalSurface(own.linear, own.terminal, own.exponent, own.bound)
        self._bound = LeakyAdaptation(self.memory, "bound", 1, own.bound_gain, 0.0, self._period)
        self._coupling_gain = own.coupling_gain * self._period
        self.memory.add("eta", (1,), initial=own.initial_eta)

    def _state(self, measurement: Measurement) -> _State:
        rate, gain = measurement.rate, self.gains.virtual_gain
        sigma, target = mrp_from_quaternion(measurement.attitude), mrp_from_quaternion(measurement.reference_attitude)
        error, sigma_rate = sigma - target, mrp_derivative(sigma, rate)
        if self._moving:
            target_rate = mrp_derivative(target, measurement.reference_rate)
            error_rate, reference = sigma_rate - target_rate, target_rate - gain * error
            bent = mrp_curvature(target, target_rate, measurement.reference_rate)
            reference_change = bent + mrp_derivative(target, measurement.reference_acceleration) - gain * error_rate
        else:
            error_rate, reference = sigma_rate, -gain * error
            reference_change = -gain * error_rate
        virtual = angular_velocity_from_mrp(sigma, reference)
        change = angular_velocity_from_mrp(sigma, reference_change - mrp_curvature(sigma, sigma_rate, virtual))
        term, slope = self._surface(error)
        return _State(error, error_rate, change, rate - virtual + term, slope)

    def sliding_variable(self, measurement: Measurement) -> FloatArray:
        """Return s (N, 3) [rad/s] at a measurement."""
        return self._state(measurement).variable

    def act(self, measurement: Measurement) -> FloatArray:
        """Return the wheel torques to command, (N, wheels) [N m]."""
        memory = self.memory
        error, error_rate, change, variable, slope = self._state(measurement)
        # z1' + c z1 = G z2
        coupling = np.abs(np.einsum("ni,ni->n", error, error_rate + self.gains.virtual_gain * error))[:, None]
        square = dot(variable, variable)
        eta = memory["eta"]
        share = coupling / (square + self.gains.coupling_low)
        known = (slope if self.gains.feed_forward else self.gains.linear) * error_rate
        acceleration = (
            self._reaching(variable)
            + change
            - known
            - ((1.0 + eta) * share) * variable
            - self._bound.value * switching(variable, self.gains.layer)
        )
        self._bound.update(np.sqrt(square))
        eta = eta + self._coupling_gain / eta * (eta * square - self.gains.coupling_high) * share
        memory["eta"] = np.maximum(eta, self.gains.smallest_eta)
        return self._command(measurement, variable, acceleration)
