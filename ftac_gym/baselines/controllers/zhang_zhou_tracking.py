"""The fault-tolerant attitude tracking of Zhang and Zhou 2019."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, NamedTuple

import numpy as np

from ftac_gym.attitude import (
    angular_velocity_from_mrp,
    mrp_curvature,
    mrp_derivative,
    mrp_from_quaternion,
)
from ftac_gym.baselines.components.adaptation import LeakyAdaptation
from ftac_gym.baselines.components.reaching import switching
from ftac_gym.baselines.components.surfaces import NonsingularTerminalSurface
from ftac_gym.baselines.controllers.zhang_zhou import ZhangZhou
from ftac_gym.baselines.gains import Range, SearchSpace
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, fields_named, finite, non_negative, positive, require


class _State(NamedTuple):
    """Errors and feed-forward of the tracking law, each (N, 3)."""

    error: FloatArray
    error_rate: FloatArray
    virtual_acceleration: FloatArray
    variable: FloatArray
    slope: FloatArray


class ZhangZhouTracking(ZhangZhou):
    """Non-singular fast terminal sliding mode with backstepping, Eqs. (56)-(76), corrected.

    With z1 = sigma - sigma_d and the virtual rate w_d = G^-1 (sigma_d' - c z1) (the print has both signs minus):

        z2  = w - w_d,  z1' = -c z1 + G z2
        s   = z2 + k1 z1 + k2 S(z1)
        u_1 = -e3 s - (e4 / N(s)) sign(s)
        u_2 = J^-1 (w x J w - D b^ - W' phi) - L1 xi + w_d' - k1 z1' - Omega sign(s)
              - s (1 + eta) |z1' G z2| / (|s|^2 + delta_n)          [- k2 S'(z1) z1' with ``feed_forward``]
        u   = E^2 D' (J^-1 D E^3 D')^-1 (u_1 + u_2)
        Omega' = theta1 |s|,  W' : theta2
        eta'   = (theta3 / eta) (eta |s|^2 - delta_m) / (|s|^2 + delta_n) |z1' G z2|,  eta >= eta_min

    w_d' = G^-1 [sigma_d'' - c z1' - G' w_d] is exact: neither a differentiator nor the acceleration is needed, since
    sigma' = G w is known. The print lets eta reach zero in finite time, where its derivative is infinite: it is held
    above ``smallest_eta``. Omega can only grow. Omega, eta and the network take one Euler step per call. z1 is the
    difference of MRPs, not the rotation between them, and jumps where sigma changes to its shadow.

    Parameters
    ----------
    scenario, num_spacecraft
        As for every baseline.
    faults, observer
        Where the estimates of the faults come from.
    virtual_gain
        c [1/s]; not printed.
    linear, terminal
        k1, k2 [rad/s].
    exponent, bound
        r and mu of S; not printed.
    feed_forward
        Whether the law takes away k2 S'(z1) z1', which it knows, instead of leaving it to Omega, as printed.
    bound_gain, network_gain, coupling_gain
        theta1, theta2, theta3; not printed.
    coupling_high, coupling_low
        delta_m > delta_n > 0; not printed.
    initial_eta, smallest_eta
        eta(0) and eta_min; not printed.
    reaching_linear, reaching_switching, reaching_floor, reaching_steepness, reaching_power, layer, anti_saturation
        See :class:`~ftac_gym.baselines.controllers.zhang_zhou.ZhangZhou`.

    Raises
    ------
    ValueError
        If a gain breaks a rule.
    """

    search_space: ClassVar[SearchSpace] = {
        "virtual_gain": Range(0.01, 1.0, log=True),
        "linear": Range(0.01, 1.0, log=True),
        "terminal": Range(0.01, 1.0, log=True),
        "reaching_linear": Range(0.1, 6.0, log=True),
        "reaching_switching": Range(1e-4, 2.0, log=True),
        "layer": Range(1e-4, 0.5, log=True),
        "network_gain": Range(1e-3, 10.0, log=True),
    }

    def __init__(
        self,
        scenario: Scenario,
        num_spacecraft: int = 1,
        faults: str = "none",
        observer: Mapping[str, Any] | None = None,
        virtual_gain: float = 0.6,
        linear: float = 0.6,
        terminal: float = 0.6,
        exponent: float = 5.0 / 7.0,
        bound: float = 0.05,
        feed_forward: bool = False,
        bound_gain: float = 0.01,
        network_gain: float = 1.0,
        coupling_gain: float = 0.01,
        coupling_high: float = 0.02,
        coupling_low: float = 0.01,
        initial_eta: float = 1.0,
        smallest_eta: float = 1e-3,
        reaching_linear: float = 1.5,
        reaching_switching: float = 1.5,
        reaching_floor: float = 0.5,
        reaching_steepness: float = 5.0,
        reaching_power: int = 1,
        layer: float = 0.05,
        anti_saturation: Mapping[str, Any] | None = None,
    ) -> None:
        super().__init__(
            scenario, num_spacecraft, faults, observer, reaching_linear, reaching_switching, reaching_floor,
            reaching_steepness, reaching_power, layer, network_gain, anti_saturation,
        )  # fmt: skip
        self._virtual_gain = positive(virtual_gain, "virtual_gain")
        self._surface = NonsingularTerminalSurface(linear, terminal, exponent, bound)
        self._linear = linear
        self._feed_forward = bool(feed_forward)
        with fields_named(gain="bound_gain"):
            self._bound = LeakyAdaptation(self.memory, "bound", 1, bound_gain, 0.0, self._period)
        self._coupling_gain = non_negative(coupling_gain, "coupling_gain") * self._period
        rule = f"must exceed coupling_low = {coupling_low!r} > 0"
        above = finite(coupling_high, "coupling_high") > positive(coupling_low, "coupling_low")
        require(above, "coupling_high", rule, coupling_high)
        self._high, self._low = coupling_high, coupling_low
        self._smallest_eta = positive(smallest_eta, "smallest_eta")
        require(
            finite(initial_eta, "initial_eta") >= smallest_eta,
            "initial_eta",
            f"must be at least {smallest_eta!r}",
            initial_eta,
        )
        self._moving = scenario.reference.moving
        self.memory.add("eta", (1,), initial=initial_eta)

    def _state(self, measurement: Measurement) -> _State:
        rate, gain = measurement.rate, self._virtual_gain
        sigma, target = mrp_from_quaternion(measurement.attitude), mrp_from_quaternion(measurement.reference_attitude)
        error, sigma_rate = sigma - target, mrp_derivative(sigma, rate)
        if self._moving:
            target_rate = mrp_derivative(target, measurement.reference_rate)
            error_rate, wanted = sigma_rate - target_rate, target_rate - gain * error
            bent = mrp_curvature(target, target_rate, measurement.reference_rate)
            wanted_change = bent + mrp_derivative(target, measurement.reference_acceleration) - gain * error_rate
        else:
            error_rate, wanted = sigma_rate, -gain * error
            wanted_change = -gain * error_rate
        virtual = angular_velocity_from_mrp(sigma, wanted)
        change = angular_velocity_from_mrp(sigma, wanted_change - mrp_curvature(sigma, sigma_rate, virtual))
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
        coupling = np.abs(np.einsum("ni,ni->n", error, error_rate + self._virtual_gain * error))[:, None]
        square = np.einsum("ni,ni->n", variable, variable)[:, None]
        eta = memory["eta"]
        share = coupling / (square + self._low)
        known = (slope if self._feed_forward else self._linear) * error_rate
        acceleration = (
            self._reaching(variable)
            + change
            - known
            - ((1.0 + eta) * share) * variable
            - self._bound.value * switching(variable, self._layer)
        )
        self._bound.update(np.sqrt(square))
        eta = eta + self._coupling_gain / eta * (eta * square - self._high) * share
        memory["eta"] = np.maximum(eta, self._smallest_eta)
        return self._command(measurement, variable, acceleration)
