"""The command-filtered backstepping with prescribed performance of Chen, Chen, He and Sun 2018."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ftac_gym.attitude import mrp_derivative
from ftac_gym.baselines.components.command_filter import LevantFilter
from ftac_gym.baselines.components.error_transformation import Transformed
from ftac_gym.baselines.components.fuzzy import FuzzyApproximator
from ftac_gym.baselines.components.reaching import PowerReaching
from ftac_gym.baselines.components.surfaces import signed_power
from ftac_gym.baselines.controllers.chen import ChenController, ChenFuzzyGains
from ftac_gym.baselines.controllers.prescribed import PrescribedError, PrescribedGains
from ftac_gym.baselines.gains import Range, changed, fixed, parameter
from ftac_gym.baselines.rules import choice, interval, whole_number
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.prescribed_bound import PrescribedBound
from ftac_gym.utils.parameters import FloatArray, non_negative, positive


@dataclass(frozen=True)
class ChenM1Gains(ChenFuzzyGains, PrescribedGains):
    """Gains of :class:`ChenM1`."""

    shadow_switch: bool = fixed(True)
    rate_gain: float = changed(ChenFuzzyGains, "rate_gain", rule=non_negative)
    attitude_power_gain: float = parameter(0.01, "tau1", "", non_negative)
    rate_power_gain: float = parameter(0.5, "tau2", "", non_negative)
    power: float = parameter(0.3, 'g ("gamma")', "", interval(0.0, 1.0))
    compensation_gain: float = parameter(0.01, "l1", "", non_negative)
    filter_first: float = parameter(3.0, "b1", "", positive)
    filter_second: float = parameter(4.0, "b2", "", positive)
    filter_substeps: int = parameter(1, "Euler steps per call, not printed. Zero for no filter", "", whole_number(0))
    filter_start: str = parameter("zero", "Start of the filter, not printed", rule=choice("zero", "virtual"))
    bound: Mapping[str, Any] | None = changed(
        PrescribedGains,
        "bound",
        search={
            "initial": Range(1.05, 3.0, log=True),
            "final": Range(1e-4, 0.2, log=True),
            "decay": Range(0.01, 0.5, log=True),
        },
    )


class ChenM1(ChenController):
    """Eqs. (21)-(45), corrected.

    With epsilon, r and theta_t of :class:`~ftac_gym.baselines.components.error_transformation.ErrorTransformation` and
    sigma' = G w::

        z1 = epsilon,  s1 = z1 - xi,  a = G^-1 r^-1 [-k1 z1 - tau1 sig(s1)^g - theta_t]
        x_c follows a through :class:`~ftac_gym.baselines.components.command_filter.LevantFilter`
        xi' = -k1 xi + r G (x_c - a) - l1 sign(xi)
        s2 = w - x_c
        v  = J0 [-k2 s2 - theta P'P s2 / (2 h^2) - tau2 sig(s2)^g]

    with theta and P of :class:`~ftac_gym.baselines.components.fuzzy.FuzzyApproximator` on (w, x_c, x_c'). One call
    takes one Euler step of theta, and ``filter_substeps`` of filter and xi with the virtual control held. The product
    of r^-1 and epsilon is largest inside the bounds and zero at them. There the virtual control moves with the bound
    and does not leave it.

    ``filter_substeps=0`` takes x_c = a, which leaves xi at zero: with ``rate_power_gain=0`` this is stable with a hold
    of 0.05 to 0.2 s; with the filter it is not. The filter starts at zero or at the virtual control.

    A spacecraft must start within its bounds. Where it breaches them later, epsilon continues along its tangent.

    Raises
    ------
    ValueError
        If a gain breaks a rule or the reference moves; ``act`` if a spacecraft starts outside its bounds.
    """

    gains = ChenM1Gains()

    def _build(self) -> None:
        super()._build()
        own = self.gains
        self._reaching = PowerReaching(own.rate_gain, own.rate_power_gain, own.power)
        self._error = PrescribedError(self.scenario, self.memory, own)
        self._fuzzy = FuzzyApproximator(self.memory, 9, own.fuzzy_gain, own.fuzzy_leak, own.fuzzy_width, self._period)
        self._command_filter = None
        if own.filter_substeps > 0:
            at_input = own.filter_start == "virtual"
            self._command_filter = LevantFilter(
                self.memory, own.filter_first, own.filter_second, self._period, own.filter_substeps, at_input
            )
        self.memory.add("compensation", (3,))

    @property
    def bound(self) -> PrescribedBound:
        """The bounds, not mirrored."""
        return self._error.bound

    def _virtual(self, sigma: FloatArray, transformed: Transformed) -> FloatArray:
        """Return the virtual control a (N, 3) [rad/s]."""
        own = self.gains
        change = -own.attitude_gain * transformed.error
        if own.attitude_power_gain > 0.0:
            compensated = transformed.error - self.memory["compensation"]
            change = change - own.attitude_power_gain * signed_power(compensated, own.power)
        return transformed.rate(sigma, change)

    def _followed(self, virtual: FloatArray) -> FloatArray:
        """Return x_c (N, 3) [rad/s]."""
        return virtual if self._command_filter is None else self._command_filter.output(virtual)

    def sliding_variable(self, measurement: Measurement) -> FloatArray:
        """Return s2 (N, 3) [rad/s] at a measurement, for its unfiltered attitude."""
        sigma = self._sigma(measurement, move_on=False)
        transformed, _ = self._error.peek(sigma, measurement.time)
        return measurement.rate - self._followed(self._virtual(sigma, transformed))

    def act(self, measurement: Measurement) -> FloatArray:
        """Return the wheel torques to command, (N, wheels) [N m]."""
        sigma = self._sigma(measurement, move_on=True)
        transformed = self._error.update(sigma, measurement.time)
        virtual = self._virtual(sigma, transformed)
        followed, change = self._followed(virtual), np.zeros_like(virtual)
        if self._command_filter is not None:
            change = self._command_filter.rate(virtual)
            self._follow(self._command_filter, sigma, transformed.slope, virtual)
        variable = measurement.rate - followed
        acceleration = self._reaching(variable) - self._fuzzy(variable, measurement.rate, followed, change)
        torque: FloatArray = acceleration @ self._inertia
        return self._to_wheels(torque)

    def _follow(self, command_filter: LevantFilter, sigma: FloatArray, slope: FloatArray, virtual: FloatArray) -> None:
        """Advance the command filter and xi by one period, with sigma, r and the virtual control held."""
        compensation = self.memory["compensation"]
        for _ in range(command_filter.substeps):
            behind = mrp_derivative(sigma, command_filter.output(virtual) - virtual)
            change = slope * behind - self.gains.attitude_gain * compensation
            change -= self.gains.compensation_gain * np.sign(compensation)
            command_filter.advance(virtual)
            compensation = compensation + command_filter.step * change
        self.memory["compensation"] = compensation
