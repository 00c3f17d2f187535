"""Non-singular fast terminal sliding mode for sampled control with small wheels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ftac_gym.attitude import mrp_derivative
from ftac_gym.baselines.components.reaching import ExponentialReaching
from ftac_gym.baselines.components.rows import dot, length
from ftac_gym.baselines.components.surfaces import NonsingularTerminalSurface
from ftac_gym.baselines.controllers.relative import RelativeController, RelativeGains
from ftac_gym.baselines.gains import Range, Share, parameter
from ftac_gym.baselines.rules import interval
from ftac_gym.task.measurement import Measurement
from ftac_gym.utils.parameters import FloatArray, non_negative, positive


@dataclass(frozen=True)
class NFTSMGains(RelativeGains):
    """Gains of :class:`NFTSM`."""

    linear: float = parameter(0.05, "k1", "rad/s", non_negative, Range(0.005, 0.5, log=True), schedule=(0.005, 0.5))
    terminal: float = parameter(0.15, "k2", "rad/s", non_negative, Range(0.02, 0.5, log=True), schedule=(0.05, 0.6))
    exponent: float = parameter(0.6, "r of the surface", "", interval(0.0, 1.0), Range(0.5, 0.95))
    bound: float = parameter(1e-3, "mu of the surface", "", positive, Range(1e-4, 0.1, log=True))
    reaching_linear: float = parameter(
        1.0, "e1", "1/s", non_negative, Range(0.05, 0.95), (0.05, 0.9), Share("reaching_share", of="rate_gain")
    )
    reaching_switching: float = parameter(0.005, "e2", "rad/s^2", positive, Range(1e-4, 0.1, log=True), (1e-4, 0.05))
    rate_gain: float = parameter(4.0, "Gain of the rate loop at s = 0", "1/s", positive, Range(0.5, 8.0), (1.0, 9.5))


class NFTSM(RelativeController):
    """The surface and the reaching law of Zhang and Zhou 2019 for sampled control at about 10 Hz.

    With the error MRP sigma, its length n, and the surface's parts S(n)/n and S'(n), Eqs. (63), (64), (66)::

        s    = w_e + (k1 + k2 S(n)/n) sigma
        w_e' = -d/dt[(k1 + k2 S(n)/n) sigma] - e1 s - (e2 / N(s)) tanh(s / layer)

    Differences from the tracking law of the paper, with reasons:

    - The power acts on the length of the error, not on each component: the spacecraft turns about one axis.
    - The derivative of the surface is fed forward whole; there is no backstepping and no growing bound.
    - Near the surface the law is linear with the rate gain e1 + e2 / layer, which sampling limits. The layer follows
      from ``rate_gain``, so that the gain of the rate loop is given directly, independent of e2. It must stay
      well below two over the control period.

    Along the surface the error brakes in proportion to n^(2r - 1): evenly for r = 1/2.
    """

    gains = NFTSMGains()

    def _build(self) -> None:
        super()._build()
        own = self.gains
        self._surface = NonsingularTerminalSurface(own.linear, own.terminal, own.exponent, own.bound)
        self._reaching = ExponentialReaching(own.reaching_linear, own.reaching_switching)

    def _profile(self, length: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the ratio and the slope of the surface for lengths (N, 1) of the error."""
        ratio, slope = self._surface.terminal_part(length)
        linear, terminal = self.scheduled.linear, self.scheduled.terminal
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
