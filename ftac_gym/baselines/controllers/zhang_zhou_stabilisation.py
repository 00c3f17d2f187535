"""The fault-tolerant attitude stabilisation of Zhang and Zhou 2019."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from ftac_gym.attitude import mrp_derivative, mrp_from_quaternion, quaternion_error
from ftac_gym.baselines.components.adaptation import LeakyAdaptation
from ftac_gym.baselines.components.reaching import switching
from ftac_gym.baselines.components.surfaces import signed_power
from ftac_gym.baselines.controllers.zhang_zhou import ZhangZhou
from ftac_gym.baselines.gains import Range, SearchSpace
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, fields_named, non_negative, require, within


class ZhangZhouStabilisation(ZhangZhou):
    """Fast terminal sliding mode to a target at rest, Eqs. (29)-(42).

    With the MRP sigma of the attitude relative to the target and sigma' = G w:

        s   = w + a sigma + b sig(sigma)^(p/q)
        u_n = -e1 s - (e2 / N(s)) sign(s)
        u_m = J^-1 (w x J w - D b^ - W' phi) - L1 xi - (chi |sigma'| + rho |J^-1| |D|) sign(s)
        u   = E^2 D' (J^-1 D E^3 D')^-1 (u_n + u_m)
        chi' = mu1 |s| |sigma'|,  rho' = mu2 |s| |J^-1| |D|,  W' : mu3

    The derivative of a sigma + b sig(sigma)^(p/q) is not fed forward but overcome by chi, which can only grow, as rho.
    chi and rho take one Euler step per call. None of the gains is printed; those here are chosen.

    Parameters
    ----------
    scenario, num_spacecraft
        As for every baseline; the reference must be at rest.
    faults, observer
        Where the estimates of the faults come from.
    linear, terminal
        a, b [rad/s].
    exponent
        p/q.
    rate_bound_gain, fault_bound_gain
        mu1, mu2.
    network_gain
        mu3.
    reaching_linear, reaching_switching, reaching_floor, reaching_steepness, reaching_power, layer, anti_saturation
        See :class:`~ftac_gym.baselines.controllers.zhang_zhou.ZhangZhou`.

    Raises
    ------
    ValueError
        If a gain breaks a rule or the reference moves.
    """

    search_space: ClassVar[SearchSpace] = {
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
        linear: float = 0.6,
        terminal: float = 0.6,
        exponent: float = 5.0 / 7.0,
        rate_bound_gain: float = 0.01,
        fault_bound_gain: float = 0.001,
        network_gain: float = 1.0,
        reaching_linear: float = 1.5,
        reaching_switching: float = 1.5,
        reaching_floor: float = 0.5,
        reaching_steepness: float = 5.0,
        reaching_power: int = 1,
        layer: float = 0.05,
        anti_saturation: Mapping[str, Any] | None = None,
    ) -> None:
        rule = "must be at rest: this law has no term for a reference rate"
        require(not scenario.reference.moving, "reference", rule, type(scenario.reference).__name__)
        super().__init__(
            scenario, num_spacecraft, faults, observer, reaching_linear, reaching_switching, reaching_floor,
            reaching_steepness, reaching_power, layer, network_gain, anti_saturation,
        )  # fmt: skip
        self._linear, self._terminal = non_negative(linear, "linear"), non_negative(terminal, "terminal")
        self._exponent = within(exponent, 0.0, 1.0, "exponent")
        with fields_named(gain="rate_bound_gain"):
            self._rate_bound = LeakyAdaptation(self.memory, "rate_bound", 1, rate_bound_gain, 0.0, self._period)
        norms = np.linalg.norm(self._inverse_inertia, 2) * np.linalg.norm(self._axes_transposed, 2)
        self._norms = float(norms)
        with fields_named(gain="fault_bound_gain"):
            self._fault_bound = LeakyAdaptation(
                self.memory, "fault_bound", 1, fault_bound_gain, 0.0, self._period * self._norms
            )

    def _variable(self, measurement: Measurement) -> tuple[FloatArray, FloatArray]:
        """Return sigma and s, each (N, 3)."""
        error = mrp_from_quaternion(quaternion_error(measurement.attitude, measurement.reference_attitude))
        power = signed_power(error, self._exponent)
        return error, measurement.rate + self._linear * error + self._terminal * power

    def sliding_variable(self, measurement: Measurement) -> FloatArray:
        """Return s (N, 3) [rad/s] at a measurement."""
        return self._variable(measurement)[1]

    def act(self, measurement: Measurement) -> FloatArray:
        """Return the wheel torques to command, (N, wheels) [N m]."""
        rate = measurement.rate
        error, variable = self._variable(measurement)
        speed = mrp_derivative(error, rate)
        turning = np.sqrt(np.einsum("ni,ni->n", speed, speed))[:, None]
        distance = np.sqrt(np.einsum("ni,ni->n", variable, variable))[:, None]
        largest = self._rate_bound.value * turning + self._fault_bound.value * self._norms
        robust = largest * switching(variable, self._layer)
        self._rate_bound.update(distance * turning)
        self._fault_bound.update(distance)
        return self._command(measurement, variable, self._reaching(variable) - robust)
