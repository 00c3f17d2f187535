"""The adaptive fast terminal sliding mode of Lu, Xia, Yu and Liu 2016: comparator M3 of Chen et al. 2018."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from ftac_gym.baselines.components.adaptation import LeakyAdaptation
from ftac_gym.baselines.components.reaching import PowerReaching
from ftac_gym.baselines.components.surfaces import NonsingularTerminalSurface
from ftac_gym.baselines.controllers.chen import ChenController
from ftac_gym.baselines.gains import Range, SearchSpace
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, fields_named, positive


class ChenM3(ChenController):
    """Eqs. (67)-(71), corrected.

        S = w + K1 sigma + K2 S_au(sigma),  S_au = sig(sigma)^r outside |sigma_i| = bound, a parabola inside
        v = -tau S - rho sig(S)^(1/2) - v_ss,  F = c1 + c2 |w| + c3 |w|^2
        v_ss = S/|S| F where |S| F > layer, else S F^2 / layer
        c_i' = -o c_i + p |S| |w|^(i-1)

    (70) adds sum_i o_i c_i / (4 p_i) S / |S|^2 outside the layer, which makes v_ss jump there: ``jump=True``. The
    second coefficient of the parabola is (r - 1) bound^(r-2), not (2 - r).

    The printed tau and rho suit a body of 10 to 20 kg m^2, not the 350 of the example: 100 and 10 do.

    Parameters
    ----------
    scenario, num_spacecraft
        As for every baseline.
    linear, terminal
        K1, K2 [rad/s].
    exponent, bound
        r, and epsilon of (68).
    reaching_linear, reaching_power_gain, reaching_exponent
        tau [N m s/rad], rho, and the exponent 0.5.
    adaptation, forgetting
        p and o [1/s].
    layer
        epsilon of (70) [N m rad/s].
    jump
        Whether v_ss has the term that makes it jump.
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
        "linear": Range(0.005, 1.0, log=True),
        "terminal": Range(0.005, 1.0, log=True),
        "exponent": Range(0.5, 0.95),
        "bound": Range(1e-4, 0.1, log=True),
        "reaching_linear": Range(1.0, 100.0, log=True),
        "reaching_power_gain": Range(1e-3, 10.0, log=True),
        "adaptation": Range(1e-4, 2.0, log=True),
        "attitude_filter_time": Range(0.0, 5.0),
    }

    def __init__(
        self,
        scenario: Scenario,
        num_spacecraft: int = 1,
        linear: float = 0.4,
        terminal: float = 0.2,
        exponent: float = 9.0 / 11.0,
        bound: float = 0.01,
        reaching_linear: float = 10.0,
        reaching_power_gain: float = 1.0,
        reaching_exponent: float = 0.5,
        adaptation: float = 2.0,
        forgetting: float = 0.1,
        layer: float = 1e-4,
        jump: bool = False,
        shadow_switch: bool = True,
        attitude_filter_time: float = 0.0,
    ) -> None:
        super().__init__(scenario, num_spacecraft, shadow_switch, attitude_filter_time)
        self._surface = NonsingularTerminalSurface(linear, terminal, exponent, bound)
        with fields_named("reaching_"):
            self._reaching = PowerReaching(reaching_linear, reaching_power_gain, reaching_exponent)
        with fields_named(gain="adaptation", leak="forgetting"):
            self._growth = LeakyAdaptation(self.memory, "torque_bounds", 3, adaptation, forgetting, self._period)
        self._layer = positive(layer, "layer")
        self._jump = forgetting / (4.0 * positive(adaptation, "adaptation")) if jump else 0.0

    def _variable(self, sigma: FloatArray, rate: FloatArray) -> FloatArray:
        return rate + self._surface(sigma)[0]

    def sliding_variable(self, measurement: Measurement) -> FloatArray:
        """Return S (N, 3) [rad/s] at a measurement, for its unfiltered attitude."""
        return self._variable(self._sigma(measurement.attitude, measurement, move_on=False), measurement.rate)

    def act(self, measurement: Measurement) -> FloatArray:
        """Return the wheel torques to command, (N, wheels) [N m]."""
        rate = measurement.rate
        variable = self._variable(self._sigma(self._filter.update(measurement), measurement, move_on=True), rate)
        distance = np.sqrt(np.einsum("ni,ni->n", variable, variable))[:, None]
        square = np.einsum("ni,ni->n", rate, rate)[:, None]
        powers = np.concatenate([np.ones_like(square), np.sqrt(square), square], axis=1)
        bounds = self._growth.value
        largest = np.einsum("ni,ni->n", bounds, powers)[:, None]
        outside = distance * largest > self._layer
        safe = np.maximum(distance, 1e-150)
        share = np.where(outside, largest / safe, largest**2 / self._layer)
        if self._jump > 0.0:
            share = share + np.where(outside, self._jump * bounds.sum(axis=1, keepdims=True) / safe**2, 0.0)
        self._growth.update(distance * powers)
        return self._to_wheels(self._reaching(variable) - share * variable)
