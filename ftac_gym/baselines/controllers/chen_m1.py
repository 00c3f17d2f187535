"""The command-filtered backstepping with prescribed performance of Chen, Chen, He and Sun 2018."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from ftac_gym.attitude import mrp_derivative
from ftac_gym.baselines.components.command_filter import LevantFilter
from ftac_gym.baselines.components.error_transformation import Transformed
from ftac_gym.baselines.components.fuzzy import FuzzyApproximator
from ftac_gym.baselines.components.reaching import PowerReaching
from ftac_gym.baselines.components.surfaces import signed_power
from ftac_gym.baselines.controllers.chen import ChenController
from ftac_gym.baselines.controllers.prescribed import PrescribedError
from ftac_gym.baselines.gains import Range, SearchSpace
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.prescribed_bound import PrescribedBound
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, fields_named, non_negative, positive, require, whole

FILTER_STARTS = ("zero", "virtual")
"""Where the command filter starts: at zero, or at the virtual control."""


class ChenM1(ChenController):
    """Eqs. (21)-(45), corrected.

    With epsilon, r and theta_t of :class:`~ftac_gym.baselines.components.error_transformation.ErrorTransformation` and
    sigma' = G w:

        z1 = epsilon,  s1 = z1 - xi,  a = G^-1 r^-1 [-k1 z1 - tau1 sig(s1)^g - theta_t]
        x_c follows a through :class:`~ftac_gym.baselines.components.command_filter.LevantFilter`
        xi' = -k1 xi + r G (x_c - a) - l1 sign(xi)
        s2 = w - x_c
        v  = J0 [-k2 s2 - theta P'P s2 / (2 h^2) - tau2 sig(s2)^g]

    with theta and P of :class:`~..components.fuzzy.FuzzyApproximator` on (w, x_c, x_c'). theta takes one Euler
    step per call, filter and xi take ``filter_substeps`` with the virtual control held. r^-1 times epsilon is largest
    inside the bounds and goes to zero at them, where the virtual control is to move with the bound, not to leave it.

    ``filter_substeps=0`` takes x_c = a, which leaves xi at zero: with ``rate_power_gain=0`` that is what survives a
    hold of 0.05 to 0.2 s. The filter is what does not.

    A craft must start within its bounds. Where it breaches them later, epsilon goes on along its tangent.

    Parameters
    ----------
    scenario, num_spacecraft
        As for every baseline.
    attitude_gain, rate_gain
        k1, k2 [1/s].
    attitude_power_gain, rate_power_gain, power
        tau1, tau2, g ("gamma").
    compensation_gain
        l1.
    filter_first, filter_second, filter_substeps, filter_start
        b1, b2, Euler steps per call (zero for no filter), and one of :data:`FILTER_STARTS`; the last two not printed.
    fuzzy_width, fuzzy_gain, fuzzy_leak
        h, lambda, m1.
    bound
        Fields of the :class:`~ftac_gym.task.prescribed_bound.PrescribedBound` that differ from the scenario's.
    mirror
        Whether the bounds of each craft are mirrored, axis by axis, to the signs of its start.
    margin
        Distance to a bound, in units of that between the two, from which epsilon goes on along its tangent.
    attitude_filter_time
        Time constant of the attitude filter [s]; zero for none.

    Raises
    ------
    ValueError
        If a gain breaks a rule or the reference moves; :meth:`act` if a craft starts outside its bounds.
    """

    search_space: ClassVar[SearchSpace] = {
        "attitude_gain": Range(0.01, 1.0, log=True),
        "rate_gain": Range(0.2, 8.0, log=True),
        "bound.initial": Range(1.05, 3.0, log=True),
        "bound.final": Range(1e-4, 0.2, log=True),
        "bound.decay": Range(0.01, 0.5, log=True),
        "attitude_filter_time": Range(0.0, 5.0),
    }

    def __init__(
        self,
        scenario: Scenario,
        num_spacecraft: int = 1,
        attitude_gain: float = 0.1,
        rate_gain: float = 0.8,
        attitude_power_gain: float = 0.01,
        rate_power_gain: float = 0.5,
        power: float = 0.3,
        compensation_gain: float = 0.01,
        filter_first: float = 3.0,
        filter_second: float = 4.0,
        filter_substeps: int = 1,
        filter_start: str = "zero",
        fuzzy_width: float = 0.5,
        fuzzy_gain: float = 2.0,
        fuzzy_leak: float = 0.001,
        bound: Mapping[str, Any] | None = None,
        mirror: bool = False,
        margin: float = 1e-5,
        attitude_filter_time: float = 0.0,
    ) -> None:
        super().__init__(scenario, num_spacecraft, True, attitude_filter_time)
        self._attitude_gain = positive(attitude_gain, "attitude_gain")
        self._attitude_power_gain = non_negative(attitude_power_gain, "attitude_power_gain")
        self._power = power
        with fields_named("rate_", linear="rate_gain", exponent="power"):
            self._reaching = PowerReaching(rate_gain, rate_power_gain, power)
        self._compensation_gain = non_negative(compensation_gain, "compensation_gain")
        self._error = PrescribedError(scenario, self.memory, bound, mirror, margin)
        self._fuzzy = FuzzyApproximator(self.memory, 9, fuzzy_gain, fuzzy_leak, fuzzy_width, self._period)
        require(filter_start in FILTER_STARTS, "filter_start", f"must be one of {list(FILTER_STARTS)}", filter_start)
        self._command_filter = None
        if whole(filter_substeps, 0, "filter_substeps") > 0:
            at_input = filter_start == "virtual"
            with fields_named("filter_"):
                self._command_filter = LevantFilter(
                    self.memory, filter_first, filter_second, self._period, filter_substeps, at_input
                )
        self.memory.add("compensation", (3,))

    @property
    def bound(self) -> PrescribedBound:
        """The bounds, not mirrored."""
        return self._error.bound

    def _virtual(self, sigma: FloatArray, transformed: Transformed) -> FloatArray:
        """Return the virtual control a (N, 3) [rad/s]."""
        wanted = -self._attitude_gain * transformed.error
        if self._attitude_power_gain > 0.0:
            compensated = transformed.error - self.memory["compensation"]
            wanted = wanted - self._attitude_power_gain * signed_power(compensated, self._power)
        return transformed.rate(sigma, wanted)

    def _followed(self, virtual: FloatArray) -> FloatArray:
        """Return x_c (N, 3) [rad/s]."""
        return virtual if self._command_filter is None else self._command_filter.output(virtual)

    def sliding_variable(self, measurement: Measurement) -> FloatArray:
        """Return s2 (N, 3) [rad/s] at a measurement, for its unfiltered attitude."""
        sigma = self._sigma(measurement.attitude, measurement, move_on=False)
        transformed, _ = self._error.peek(sigma, measurement.time)
        variable: FloatArray = measurement.rate - self._followed(self._virtual(sigma, transformed))
        return variable

    def act(self, measurement: Measurement) -> FloatArray:
        """Return the wheel torques to command, (N, wheels) [N m]."""
        sigma = self._sigma(self._filter.update(measurement), measurement, move_on=True)
        transformed = self._error.update(sigma, measurement.time)
        virtual = self._virtual(sigma, transformed)
        followed, change = self._followed(virtual), np.zeros_like(virtual)
        if self._command_filter is not None:
            change = self._command_filter.rate(virtual)
            self._follow(self._command_filter, sigma, transformed.slope, virtual)
        variable = measurement.rate - followed
        wanted = self._reaching(variable) - self._fuzzy(variable, measurement.rate, followed, change)
        torque: FloatArray = wanted @ self._inertia
        return self._to_wheels(torque)

    def _follow(self, command_filter: LevantFilter, sigma: FloatArray, slope: FloatArray, virtual: FloatArray) -> None:
        """Move the command filter and xi on by one period, with sigma, r and the virtual control held."""
        compensation = self.memory["compensation"]
        for _ in range(command_filter.substeps):
            behind = mrp_derivative(sigma, command_filter.output(virtual) - virtual)
            change = slope * behind - self._attitude_gain * compensation
            change -= self._compensation_gain * np.sign(compensation)
            command_filter.advance(virtual)
            compensation = compensation + command_filter.step * change
        self.memory["compensation"] = compensation
