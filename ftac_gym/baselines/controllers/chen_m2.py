"""Adaptive backstepping without prescribed performance: comparator M2 of Chen, Chen, He and Sun 2018."""

from __future__ import annotations

from ftac_gym.attitude import angular_velocity_from_mrp
from ftac_gym.baselines.components.fuzzy import FuzzyApproximator
from ftac_gym.baselines.controllers.chen import ChenController, ChenFuzzyGains
from ftac_gym.task.measurement import Measurement
from ftac_gym.utils.parameters import FloatArray


class ChenM2(ChenController):
    """Eqs. (64)-(66), corrected: a = -k1 G^-1 sigma, z2 = w - a, v = J0 [-k2 z2 - theta P'P z2 / (2 h^2)].

    theta and P are those of :class:`~ftac_gym.baselines.components.fuzzy.FuzzyApproximator` on (w, a); its inputs are
    not printed. (65) and (66) are printed with M1's s2.
    """

    gains = ChenFuzzyGains()

    def _build(self) -> None:
        super()._build()
        own = self.gains
        self._fuzzy = FuzzyApproximator(self.memory, 6, own.fuzzy_gain, own.fuzzy_leak, own.fuzzy_width, self._period)

    def sliding_variable(self, measurement: Measurement) -> FloatArray:
        """Return z2 (N, 3) [rad/s] at a measurement, for its unfiltered attitude."""
        sigma = self._sigma(measurement, move_on=False)
        return measurement.rate + self.gains.attitude_gain * angular_velocity_from_mrp(sigma, sigma)

    def act(self, measurement: Measurement) -> FloatArray:
        """Return the wheel torques to command, (N, wheels) [N m]."""
        sigma = self._sigma(measurement, move_on=True)
        virtual = -self.gains.attitude_gain * angular_velocity_from_mrp(sigma, sigma)
        variable = measurement.rate - virtual
        acceleration = -self.gains.rate_gain * variable - self._fuzzy(variable, measurement.rate, virtual)
        torque: FloatArray = acceleration @ self._inertia
        return self._to_wheels(torque)
