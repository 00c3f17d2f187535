"""The adaptive fast terminal sliding mode of Lu, Xia, Yu and Liu 2016: comparator M3 of Chen et al. 2018."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ftac_gym.baselines.components.adaptation import LeakyAdaptation
from ftac_gym.baselines.components.reaching import PowerReaching
from ftac_gym.baselines.components.rows import dot, length
from ftac_gym.baselines.components.surfaces import NonsingularTerminalSurface
from ftac_gym.baselines.controllers.chen import ChenController, ChenGains
from ftac_gym.baselines.gains import Range, parameter
from ftac_gym.baselines.rules import interval
from ftac_gym.task.measurement import Measurement
from ftac_gym.utils.parameters import FloatArray, fields_named, flag, non_negative, positive


@dataclass(frozen=True)
class ChenM3Gains(ChenGains):
    """Gains of :class:`ChenM3`."""

    linear: float = parameter(0.4, "K1", "rad/s", non_negative, Range(0.005, 1.0, log=True))
    terminal: float = parameter(0.2, "K2", "rad/s", non_negative, Range(0.005, 1.0, log=True))
    exponent: float = parameter(9.0 / 11.0, "r", "", interval(0.0, 1.0), Range(0.5, 0.95))
    bound: float = parameter(0.01, "epsilon of (68)", "", positive, Range(1e-4, 0.1, log=True))
    reaching_linear: float = parameter(10.0, "tau", "N m s/rad", non_negative, Range(1.0, 100.0, log=True))
    reaching_power_gain: float = parameter(1.0, "rho", "", non_negative, Range(1e-3, 10.0, log=True))
    reaching_exponent: float = parameter(0.5, "Exponent of the reaching law", "", interval(0.0, 1.0))
    adaptation: float = parameter(2.0, "p", "", non_negative, Range(1e-4, 2.0, log=True))
    forgetting: float = parameter(0.1, "o", "1/s", non_negative)
    layer: float = parameter(1e-4, "epsilon of (70)", "N m rad/s", positive)
    jump: bool = parameter(False, "Whether v_ss has the term that makes it jump", rule=flag)

    def __post_init__(self) -> None:
        """Check the fields."""
        super().__post_init__()
        if self.jump:
            positive(self.adaptation, "adaptation")


class ChenM3(ChenController):
    """Eqs. (67)-(71), corrected.

    ::

        S = w + K1 sigma + K2 S_au(sigma),  S_au = sig(sigma)^r outside |sigma_i| = bound, a parabola inside
        v = -tau S - rho sig(S)^(1/2) - v_ss,  F = c1 + c2 |w| + c3 |w|^2
        v_ss = S/|S| F where |S| F > layer, else S F^2 / layer
        c_i' = -o c_i + p |S| |w|^(i-1)

    (70) adds sum_i o_i c_i / (4 p_i) S / ``|S|^2`` outside the layer, which makes v_ss jump there: ``jump=True``. The
    second coefficient of the parabola is (r - 1) bound^(r-2), not (2 - r).

    The printed tau and rho suit a body of 10 to 20 kg m^2, not the 350 of the example: 100 and 10 do.
    """

    gains = ChenM3Gains()

    def _build(self) -> None:
        super()._build()
        own = self.gains
        self._surface = NonsingularTerminalSurface(own.linear, own.terminal, own.exponent, own.bound)
        self._reaching = PowerReaching(own.reaching_linear, own.reaching_power_gain, own.reaching_exponent)
        with fields_named(leak="forgetting"):
            self._growth = LeakyAdaptation(
                self.memory, "torque_bounds", 3, own.adaptation, own.forgetting, self._period
            )
        self._jump = own.forgetting / (4.0 * own.adaptation) if own.jump else 0.0

    def _variable(self, sigma: FloatArray, rate: FloatArray) -> FloatArray:
        return rate + self._surface(sigma)[0]

    def sliding_variable(self, measurement: Measurement) -> FloatArray:
        """Return S (N, 3) [rad/s] at a measurement, for its unfiltered attitude."""
        return self._variable(self._sigma(measurement, move_on=False), measurement.rate)

    def act(self, measurement: Measurement) -> FloatArray:
        """Return the wheel torques to command, (N, wheels) [N m]."""
        rate = measurement.rate
        variable = self._variable(self._sigma(measurement, move_on=True), rate)
        distance = length(variable)
        square = dot(rate, rate)
        powers = np.concatenate([np.ones_like(square), np.sqrt(square), square], axis=1)
        bounds = self._growth.value
        largest = dot(bounds, powers)
        outside = distance * largest > self.gains.layer
        safe = np.maximum(distance, 1e-150)
        share = np.where(outside, largest / safe, largest**2 / self.gains.layer)
        if self._jump > 0.0:
            share = share + np.where(outside, self._jump * bounds.sum(axis=1, keepdims=True) / safe**2, 0.0)
        self._growth.update(distance * powers)
        return self._to_wheels(self._reaching(variable) - share * variable)
