"""The predefined-time feedback, with which a squared error vanishes before a chosen time."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ftac_gym.baselines.components.rows import dot
from ftac_gym.utils.parameters import FloatArray, non_negative, positive, require, within

_SMALLEST = 1e-24
"""Floor of V, ``|x|`` = 1.4e-12, which avoids 0 times infinity."""


@dataclass(frozen=True)
class PredefinedTime:
    """The gain f(V) of x' = -f(V) x, V = ``|x|^2`` / 2, with which V' = -exp(V^h) V^(1-h) / (h T).

    f = exp(V^h) V^-h / (2 h T): Lemma 1 of Cao et al. 2022 with its sign corrected. V is zero at the time
    T (1 - exp(-V(0)^h)): T is an upper bound, and the time does depend on the start.

    Parameters
    ----------
    exponent
        h, within (0, 1). On x' = -f x, f x is continuous for h < 1/2 and has a bounded derivative for h <= 1/4.
    time
        T [s].
    regularisation
        Added to V in the negative power, so that f stays finite; zero for the law itself.

    Raises
    ------
    ValueError
        If a value breaks a rule.
    """

    exponent: float
    time: float
    regularisation: float = 0.0

    def __post_init__(self) -> None:
        """Check the fields."""
        within(self.exponent, 0.0, 1.0, "exponent")
        positive(self.time, "time")
        non_negative(self.regularisation, "regularisation")

    @classmethod
    def with_gain(cls, exponent: float, time: float, gain: float) -> PredefinedTime:
        """Return the feedback whose gain at zero is ``gain`` [1/s] by regularisation, for sampled control."""
        within(exponent, 0.0, 1.0, "exponent")
        logarithm = math.log(2.0 * exponent * positive(time, "time") * positive(gain, "gain")) / -exponent
        require(abs(logarithm) < 700.0, "gain", f"must be reachable with exponent {exponent!r} and time {time!r}", gain)
        return cls(exponent, time, math.exp(logarithm))

    def gain(self, energy: FloatArray) -> FloatArray:
        """Return f [1/s] for V, in any shape."""
        if self.regularisation == 0.0:
            energy = np.maximum(energy, _SMALLEST)
        power = energy**self.exponent
        inverse = 1.0 / power if self.regularisation == 0.0 else (energy + self.regularisation) ** -self.exponent
        return np.exp(power) * inverse * (1.0 / (2.0 * self.exponent * self.time))

    def gain_and_slope(self, energy: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return f [1/s] and df/dV [1/s] for V, in any shape.

        With the regularisation r: df/dV = f h (V^(h-1) - 1/(V + r)).
        """
        gain = self.gain(energy)
        safe = np.maximum(energy, _SMALLEST)
        return gain, self.exponent * gain * (safe ** (self.exponent - 1.0) - 1.0 / (safe + self.regularisation))

    def reaching_time(self, energy: FloatArray) -> FloatArray:
        """Return the time at which V is zero, T (1 - exp(-V(0)^h)) [s]: the closed form, without regularisation."""
        return self.time * -np.expm1(-(energy**self.exponent))


class PredefinedTimeSliding:
    """s = x' + f_a x and the feedback for s' = -f_b s, Eqs. (25) and (26) of Cao et al. 2022.

    Parameters
    ----------
    position, rate
        The feedbacks f_a of V_a = ``|x|^2`` / 2 and f_b of V_b = ``|s / w|^2`` / 2.
    rate_scale
        w [1/s]; 1 in the paper.
    """

    def __init__(self, position: PredefinedTime, rate: PredefinedTime, rate_scale: float = 1.0) -> None:
        self._position, self._rate = position, rate
        self._per_scale = 1.0 / rate_scale

    def variable(self, error: FloatArray, error_rate: FloatArray) -> FloatArray:
        """Return s (N, 3) [1/s] for x and x' [1/s], each (N, 3)."""
        return error_rate + self._position.gain(_energy(error)) * error

    def demand(self, error: FloatArray, error_rate: FloatArray, drift: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return s [1/s], and the drift of x'' [1/s^2] plus xi' + f_b s, each (N, 3).

        With xi = f_a x: xi' = f_a x' + (df_a/dV_a) (x.x') x.
        """
        gain, slope = self._position.gain_and_slope(_energy(error))
        along = dot(error, error_rate)
        variable = error_rate + gain * error
        reaching = self._rate.gain(_energy(variable * self._per_scale)) * variable
        return variable, drift + gain * error_rate + (slope * along) * error + reaching


def _energy(vector: FloatArray) -> FloatArray:
    return 0.5 * dot(vector, vector)
