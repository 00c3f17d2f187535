"""Non-singular fast terminal sliding mode for a sampled craft with small wheels."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from ftac_gym.attitude import mrp_derivative
from ftac_gym.baselines.components.reaching import ExponentialReaching
from ftac_gym.baselines.components.surfaces import NonsingularTerminalSurface
from ftac_gym.baselines.controllers.relative import RelativeLaw
from ftac_gym.baselines.gains import Range, SearchSpace, scheduled_share
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, non_negative, positive, require


class NFTSM(RelativeLaw):
    """The surface and the reaching law of Zhang and Zhou 2019 for control at some 10 Hz.

    With the error MRP sigma, its length n, and the surface's parts S(n)/n and S'(n), Eqs. (63), (64), (66):

        s    = w_e + (k1 + k2 S(n)/n) sigma
        w_e' = -d/dt[(k1 + k2 S(n)/n) sigma] - e1 s - (e2 / N(s)) tanh(s / layer)

    What differs from the paper's tracking law, and why:

    - The power acts on the length of the error, not on each component: the craft turns about one axis.
    - The derivative of the surface is fed forward whole; there is no backstepping and no growing bound.
    - Near the surface the law is linear with the rate gain e1 + e2 / layer, which sampling limits: the layer follows
      from ``rate_gain``, so that the gain of the rate loop is what is given, whatever e2.

    Parameters
    ----------
    scenario, num_spacecraft
        As for every baseline.
    faults, observer
        Where the estimates of the faults come from.
    linear, terminal
        k1, k2 [rad/s].
    exponent, bound
        r and mu of the surface. Along the surface the error brakes in proportion to n^(2r - 1): evenly for r = 1/2.
    reaching_linear, reaching_switching
        e1 [1/s], e2 [rad/s^2].
    rate_gain
        Gain of the rate loop at s = 0 [1/s]; above e1, and well below two over the control period.
    attitude_filter_time
        Time constant of the attitude filter [s]; zero for none.

    Raises
    ------
    ValueError
        If a gain breaks a rule.
    """

    search_space: ClassVar[SearchSpace] = {
        "linear": Range(0.005, 0.5, log=True),
        "terminal": Range(0.02, 0.5, log=True),
        "exponent": Range(0.5, 0.95),
        "bound": Range(1e-4, 0.1, log=True),
        "reaching_share": Range(0.05, 0.95),
        "reaching_switching": Range(1e-4, 0.1, log=True),
        "rate_gain": Range(0.5, 8.0),
        "attitude_filter_time": Range(0.1, 5.0),
    }
    shares: ClassVar = {"reaching_share": ("reaching_linear", "rate_gain")}
    schedulable: ClassVar = {
        "linear": (0.005, 0.5),
        "terminal": (0.05, 0.6),
        "reaching_share": (0.05, 0.9),
        "reaching_switching": (1e-4, 0.05),
        "rate_gain": (1.0, 9.5),
    }

    def __init__(
        self,
        scenario: Scenario,
        num_spacecraft: int = 1,
        faults: str = "none",
        observer: Mapping[str, Any] | None = None,
        linear: float = 0.05,
        terminal: float = 0.15,
        exponent: float = 0.6,
        bound: float = 1e-3,
        reaching_linear: float = 1.0,
        reaching_switching: float = 0.005,
        rate_gain: float = 4.0,
        attitude_filter_time: float = 1.0,
    ) -> None:
        super().__init__(scenario, num_spacecraft, faults, observer, attitude_filter_time)
        self._surface = NonsingularTerminalSurface(linear, terminal, exponent, bound)
        non_negative(reaching_linear, "reaching_linear")
        rule = f"must exceed reaching_linear = {reaching_linear!r}"
        require(positive(rate_gain, "rate_gain") > reaching_linear, "rate_gain", rule, rate_gain)
        layer = positive(reaching_switching, "reaching_switching") / (rate_gain - reaching_linear)
        self._reaching = ExponentialReaching(reaching_linear, reaching_switching, layer=layer)
        self._rate_gain = float(rate_gain)
        self._schedule({})

    def _schedule(self, gains: Mapping[str, FloatArray]) -> None:
        surface, reaching = self._surface, self._reaching
        self._linear, self._terminal = gains.get("linear", surface.linear), gains.get("terminal", surface.terminal)
        switching, rate = gains.get("reaching_switching", reaching.switching), gains.get("rate_gain", self._rate_gain)
        share = gains.get("reaching_share", reaching.linear / self._rate_gain)
        linear = scheduled_share(reaching.linear, self._rate_gain, share, rate)
        self._reaching_gains = linear, switching, switching / (rate - linear)

    def _profile(self, length: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the ratio and the slope of the surface for lengths (N, 1) of the error."""
        ratio, slope = self._surface.terminal_part(length)
        return self._linear + self._terminal * ratio, self._linear + self._terminal * slope

    def _variable(self, measurement: Measurement, error: FloatArray, rate_error: FloatArray) -> FloatArray:
        length = np.sqrt(np.einsum("ni,ni->n", error, error))[:, None]
        variable: FloatArray = rate_error + self._profile(length)[0] * error
        return variable

    def _acceleration(self, measurement: Measurement, error: FloatArray, rate_error: FloatArray) -> FloatArray:
        square = np.einsum("ni,ni->n", error, error)[:, None]
        ratio, slope = self._profile(np.sqrt(square))
        speed = mrp_derivative(error, rate_error)
        along = np.einsum("ni,ni->n", error, speed)[:, None] / np.maximum(square, 1e-300)
        change = ratio * speed + ((slope - ratio) * along) * error
        wanted: FloatArray = self._reaching.scheduled(rate_error + ratio * error, *self._reaching_gains) - change
        return wanted
