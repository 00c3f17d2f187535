"""Non-singular fast terminal sliding mode for sampled control with small wheels."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ftac_gym.attitude import mrp_derivative
from ftac_gym.baselines.components.reaching import ExponentialReaching
from ftac_gym.baselines.components.rows import dot, length
from ftac_gym.baselines.components.surfaces import bound_of_slope, terminal_part
from ftac_gym.baselines.controllers.relative import RelativeController, RelativeGains
from ftac_gym.baselines.gains import Range, Share, parameter
from ftac_gym.baselines.rules import interval
from ftac_gym.baselines.units import ACCELERATION, PER_LOOP, PER_SPEED, SPEED
from ftac_gym.task.measurement import Measurement
from ftac_gym.utils.parameters import FloatArray, non_negative, positive


@dataclass(frozen=True)
class NFTSMGains(RelativeGains):
    """Gains of :class:`NFTSM`."""

    linear: float = parameter(0.4261, "k1", SPEED, non_negative, Range(0.04, 4.0, log=True), schedule=(0.04, 4.0))
    terminal: float = parameter(1.278, "k2", SPEED, non_negative, Range(0.2, 4.0, log=True), schedule=(0.4, 5.0))
    exponent: float = parameter(0.6, "r of the surface", "", interval(0.0, 1.0), Range(0.5, 0.95))
    terminal_slope: float = parameter(
        0.6656, "Slope of k2 S(n) at zero, which sets mu", PER_LOOP, positive, Range(0.1, 1.6, log=True)
    )
    reaching_linear: float = parameter(
        0.2, "e1", PER_LOOP, non_negative, Range(0.05, 0.95), (0.05, 0.9), Share("reaching_share", of="rate_gain")
    )
    reaching_switching: float = parameter(
        0.3632, "e2", ACCELERATION, positive, Range(7e-3, 7.0, log=True), schedule=(7e-3, 3.6)
    )
    steepness: float = parameter(0.5867, "alpha of the reaching law", PER_SPEED, non_negative)
    rate_gain: float = parameter(0.8, "Gain of the rate loop at s = 0", PER_LOOP, positive, Range(0.1, 2.2), (0.2, 1.9))


class NFTSM(RelativeController):
    """The surface and the reaching law of Zhang and Zhou 2019 for sampled control.

    With the error MRP sigma, its length n, and the surface's parts S(n)/n and S'(n), Eqs. (63), (64), (66)::

        s    = w_e + (k1 + k2 S(n)/n) sigma
        w_e' = -d/dt[(k1 + k2 S(n)/n) sigma] - e1 s - (e2 / N(s)) tanh(s / layer)

    Differences from the tracking law of the paper, with reasons:

    - The power acts on the length of the error, not on each component: the spacecraft turns about one axis.
    - The derivative of the surface is fed forward whole; there is no backstepping and no growing bound.
    - Near the surface the law is linear with the rate gain e1 + e2 / layer, which sampling limits. The layer follows
      from ``rate_gain``, so that the gain of the rate loop is given directly, independent of e2. It must stay
      well below 2 / L.
    - At the target the surface has the slope k1 + ``terminal_slope``, which the loop limits too. The bound mu, inside
      which S is a parabola, follows from it.

    Along the surface the error brakes in proportion to n^(2r - 1): evenly for r = 1/2.
    """

    gains = NFTSMGains()

    def _build(self) -> None:
        super()._build()
        own: NFTSMGains = self.scheduled
        self._reaching = ExponentialReaching(own.reaching_linear, own.reaching_switching, steepness=own.steepness)
        self._bound = bound_of_slope(own.terminal_slope, own.terminal, own.exponent)

    def _schedule(self, gains: Mapping[str, FloatArray]) -> None:
        super()._schedule(gains)
        own: NFTSMGains = self.scheduled
        self._bound = bound_of_slope(own.terminal_slope, own.terminal, own.exponent)

    def _profile(self, length: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the ratio and the slope of the surface for lengths (N, 1) of the error."""
        own: NFTSMGains = self.scheduled
        ratio, slope = terminal_part(length, own.exponent, self._bound)
        linear, terminal = own.linear, own.terminal
        return linear + terminal * ratio, linear + terminal * slope

    def _variable(self, measurement: Measurement, error: FloatArray, rate_error: FloatArray) -> FloatArray:
        size = length(error)
        return rate_error + self._profile(size)[0] * error

    def _acceleration(self, measurement: Measurement, error: FloatArray, rate_error: FloatArray) -> FloatArray:
        square = dot(error, error)
        ratio, slope = self._profile(np.sqrt(square))
        speed = mrp_derivative(error, rate_error)
        along = dot(error, speed) / np.maximum(square, 1e-300)
        change = ratio * speed + ((slope - ratio) * along) * error
        gains: NFTSMGains = self.scheduled
        linear, switching = gains.reaching_linear, gains.reaching_switching
        layer = switching / (gains.rate_gain - linear)
        return self._reaching.scheduled(rate_error + ratio * error, linear, switching, layer) - change
