"""Adaptive backstepping without prescribed performance: comparator M2 of Chen, Chen, He and Sun 2018."""

from __future__ import annotations

from typing import ClassVar

from ftac_gym.attitude import angular_velocity_from_mrp
from ftac_gym.baselines.components.fuzzy import FuzzyApproximator
from ftac_gym.baselines.controllers.chen import ChenController
from ftac_gym.baselines.gains import Range, SearchSpace
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, positive


class ChenM2(ChenController):
    """Eqs. (64)-(66), corrected: a = -k1 G^-1 sigma, z2 = w - a, v = J0 [-k2 z2 - theta P'P z2 / (2 h^2)].

    theta and P are those of :class:`~..components.fuzzy.FuzzyApproximator` on (w, a); its inputs are not printed.
    (65) and (66) are printed with M1's s2.

    Parameters
    ----------
    scenario, num_spacecraft
        As for every baseline.
    attitude_gain, rate_gain
        k1, k2 [1/s].
    fuzzy_width, fuzzy_gain, fuzzy_leak
        h, lambda, m1.
    shadow_switch
        See :class:`~ftac_gym.baselines.controllers.chen.ChenController`.
    attitude_filter_time
        Time constant of the attitude filter [s]; zero for none.

    Raises
    ------
    ValueError
        If a gain breaks a rule or the reference moves.
    """

    search_space: ClassVar[SearchSpace] = {
        "attitude_gain": Range(0.01, 1.0, log=True),
        "rate_gain": Range(0.2, 8.0, log=True),
        "attitude_filter_time": Range(0.0, 5.0),
    }

    def __init__(
        self,
        scenario: Scenario,
        num_spacecraft: int = 1,
        attitude_gain: float = 0.1,
        rate_gain: float = 0.8,
        fuzzy_width: float = 0.5,
        fuzzy_gain: float = 2.0,
        fuzzy_leak: float = 0.001,
        shadow_switch: bool = True,
        attitude_filter_time: float = 0.0,
    ) -> None:
        super().__init__(scenario, num_spacecraft, shadow_switch, attitude_filter_time)
        self._attitude_gain, self._rate_gain = (
            positive(attitude_gain, "attitude_gain"),
            positive(rate_gain, "rate_gain"),
        )
        self._fuzzy = FuzzyApproximator(self.memory, 6, fuzzy_gain, fuzzy_leak, fuzzy_width, self._period)

    def sliding_variable(self, measurement: Measurement) -> FloatArray:
        """Return z2 (N, 3) [rad/s] at a measurement, for its unfiltered attitude."""
        sigma = self._sigma(measurement.attitude, measurement, move_on=False)
        variable: FloatArray = measurement.rate + self._attitude_gain * angular_velocity_from_mrp(sigma, sigma)
        return variable

    def act(self, measurement: Measurement) -> FloatArray:
        """Return the wheel torques to command, (N, wheels) [N m]."""
        sigma = self._sigma(self._filter.update(measurement), measurement, move_on=True)
        virtual = -self._attitude_gain * angular_velocity_from_mrp(sigma, sigma)
        variable = measurement.rate - virtual
        wanted = -self._rate_gain * variable - self._fuzzy(variable, measurement.rate, virtual)
        torque: FloatArray = wanted @ self._inertia
        return self._to_wheels(torque)
