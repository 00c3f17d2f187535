"""A robust adaptive fixed-time sliding-mode control: the family of Esmaeilzadeh, Golestani and Mobayen 2021."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from ftac_gym.attitude import cross
from ftac_gym.baselines.components.adaptation import LeakyAdaptation
from ftac_gym.baselines.components.relative_motion import RelativeMotion
from ftac_gym.baselines.components.surfaces import NonsingularTerminalSurface, signed_power
from ftac_gym.baselines.controllers.flexible import FlexibleController
from ftac_gym.baselines.gains import Range, SearchSpace
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, fields_named, non_negative, positive, require


class RAFTSMCClass(FlexibleController):
    """A fixed-time terminal surface, a two-power reaching law and an adaptive bound.

        S = w_e + k1 sig(q_ev)^r1 + k2 S_au(q_ev),  S_au = sig(q)^r2 outside |q| = phi, a parabola inside
        torque = w x J w + feed-forward - J_q c'(q_ev) q_ev'
                 - kappa_a sig(S)^r3 - kappa_b sig(S)^r4 - rho^ S / (|S| + e)
        rho^ = c1 + c2 |w|,  c_i' = g_i (|w|^(i-1) |S| - p_i c_i)

    with J_q = J - delta' delta and c the part of S that depends on the attitude. Surface and numbers are those that Li
    et al. 2023 print; l1 = 8.8 and l2 = -252 there are what makes the parabola smooth. The law behind them was not to
    be had: reaching and adaptation are of its class, with the gains at the places that fit their names best.

    Parameters
    ----------
    scenario, num_spacecraft
        As for every baseline.
    first, second
        k1, k2 [rad/s].
    first_exponent, second_exponent
        r1, at least one, and r2 within (0, 1).
    bound
        phi.
    reaching_high, reaching_low
        kappa_a, kappa_b [N m per power of rad/s].
    high_exponent, low_exponent
        r3, at least one, and r4 within (0, 1).
    adaptation, forgetting
        g1 = g2 [N m s^-1 per rad/s] and p1 = p2.
    layer
        e [rad/s].
    limit, short_way, attitude_filter_time
        See :class:`~ftac_gym.baselines.controllers.flexible.FlexibleController`.

    Raises
    ------
    ValueError
        If a gain breaks a rule.
    """

    search_space: ClassVar[SearchSpace] = {
        "first": Range(0.01, 1.0, log=True),
        "second": Range(0.01, 1.0, log=True),
        "reaching_high": Range(1.0, 300.0, log=True),
        "reaching_low": Range(0.1, 30.0, log=True),
        "adaptation": Range(1e-3, 10.0, log=True),
        "layer": Range(1e-3, 0.3, log=True),
        "attitude_filter_time": Range(0.0, 5.0),
    }

    def __init__(
        self,
        scenario: Scenario,
        num_spacecraft: int = 1,
        first: float = 0.2,
        second: float = 0.2,
        first_exponent: float = 1.2,
        second_exponent: float = 0.6,
        bound: float = 0.01,
        reaching_high: float = 20.0,
        reaching_low: float = 8.0,
        high_exponent: float = 1.5,
        low_exponent: float = 0.6,
        adaptation: float = 1.0,
        forgetting: float = 0.1,
        layer: float = 0.01,
        limit: str = "each",
        short_way: bool = True,
        attitude_filter_time: float = 0.0,
    ) -> None:
        super().__init__(scenario, num_spacecraft, "none", None, 0.0, limit, short_way, attitude_filter_time)
        self._first = non_negative(first, "first")
        for name, value in (("first_exponent", first_exponent), ("high_exponent", high_exponent)):
            require(1.0 <= value < np.inf, name, "must be at least 1, and finite", value)
        self._first_exponent, self._high_exponent = float(first_exponent), float(high_exponent)
        with fields_named(terminal="second", exponent="second_exponent"):
            self._terminal = NonsingularTerminalSurface(0.0, second, second_exponent, bound)
        require(0.0 < low_exponent < 1.0, "low_exponent", "must lie within (0, 1)", low_exponent)
        self._low_exponent = float(low_exponent)
        self._reaching_high = non_negative(reaching_high, "reaching_high")
        self._reaching_low = non_negative(reaching_low, "reaching_low")
        self._layer = positive(layer, "layer")
        leak = non_negative(forgetting, "forgetting") * non_negative(adaptation, "adaptation")
        with fields_named(gain="adaptation", leak="adaptation times forgetting"):
            self._bounds = LeakyAdaptation(self.memory, "bounds", 2, adaptation, leak, self._period)

    def _surface(self, error: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return c(q_ev) and its slope, each (N, 3)."""
        magnitude = np.abs(error)
        value, slope = self._terminal(error)
        power = self._first_exponent
        value = value + self._first * signed_power(error, power)
        return value, slope + (self._first * power) * magnitude ** (power - 1.0)

    def _variable(self, motion: RelativeMotion) -> FloatArray:
        """Return S (N, 3) [rad/s]."""
        return motion.rate_error + self._surface(motion.error[:, 1:])[0]

    def _torque(self, measurement: Measurement, motion: RelativeMotion, variable: FloatArray) -> FloatArray:
        scalar, vector = motion.error[:, :1], motion.error[:, 1:]
        turning = 0.5 * (scalar * motion.rate_error + cross(vector, motion.rate_error))
        _, slope = self._surface(vector)
        size = np.linalg.norm(variable, axis=1, keepdims=True)
        speed = np.linalg.norm(measurement.rate, axis=1, keepdims=True)
        growth = np.concatenate([np.ones_like(speed), speed], axis=1)
        adaptive = (self._bounds.value * growth).sum(axis=1, keepdims=True)
        self._bounds.update(growth * size)
        reaching = self._reaching_high * signed_power(variable, self._high_exponent)
        reaching += self._reaching_low * signed_power(variable, self._low_exponent)
        torque = self._gyroscopic_torque(measurement, motion) - (slope * turning) @ self._quick_inertia
        torque -= reaching + adaptive / (size + self._layer) * variable
        return torque
