"""The predefined-time feedback: what makes a squared error vanish before a time that is chosen."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ftac_gym.parameters import FloatArray, non_negative, positive, require

_SMALLEST = 1e-24
"""Floor of V, |x| = 1.4e-12: keeps 0 times infinity from being asked for."""


@dataclass(frozen=True)
class PredefinedTime:
    """The gain f(V) of x' = -f(V) x, V = |x|^2 / 2, with which V' = -exp(V^h) V^(1-h) / (h T).

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
        require(0.0 < self.exponent < 1.0, "exponent", "must lie within (0, 1)", self.exponent)
        positive(self.time, "time")
        non_negative(self.regularisation, "regularisation")

    @classmethod
    def with_gain(cls, exponent: float, time: float, gain: float) -> PredefinedTime:
        """Return the feedback whose gain at zero is ``gain`` [1/s] by regularisation: what sampling can bear."""
        power = 2.0 * exponent * time * positive(gain, "gain")
        return cls(exponent, time, float(power ** (-1.0 / exponent)))

    def gain(self, energy: FloatArray) -> FloatArray:
        """Return f [1/s] for V, in any shape."""
        power = np.maximum(energy, _SMALLEST) ** self.exponent
        regular = self.regularisation
        inverse = 1.0 / power if regular == 0.0 else (energy + regular) ** -self.exponent
        gain: FloatArray = np.exp(power) * inverse * (1.0 / (2.0 * self.exponent * self.time))
        return gain

    def gain_and_slope(self, energy: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return f [1/s] and df/dV [1/s] for V, in any shape.

        With the regularisation r: df/dV = f h (V^(h-1) - 1/(V + r)).
        """
        safe = np.maximum(energy, _SMALLEST)
        power = safe**self.exponent
        shifted = safe + self.regularisation
        inverse = 1.0 / power if self.regularisation == 0.0 else shifted**-self.exponent
        gain = np.exp(power) * inverse * (1.0 / (2.0 * self.exponent * self.time))
        return gain, self.exponent * gain * (power / safe - 1.0 / shifted)

    def reaching_time(self, energy: FloatArray) -> FloatArray:
        """Return when V is zero, T (1 - exp(-V(0)^h)) [s]: the closed form, without regularisation."""
        time: FloatArray = self.time * -np.expm1(-(energy**self.exponent))
        return time
