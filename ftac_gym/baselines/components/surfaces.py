"""Sliding surfaces: the function c(x) of the attitude error in s = rate error + c(x), and its slope.

A surface is evaluated once for both, ``term, slope = surface(x)`` with ``term' = slope * x'``, axis by axis; c' is the
feed-forward of a controller.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ftac_gym.utils.parameters import FloatArray, non_negative, positive, within


def signed_power(value: FloatArray, exponent: float) -> FloatArray:
    """Return sig(x)^a = ``|x|^a`` sign(x), elementwise."""
    return np.copysign(np.abs(value) ** exponent, value)


@dataclass(frozen=True)
class _TerminalSurface:
    """A linear term and a power below one.

    Parameters
    ----------
    linear
        Gain of x [rad/s per unit of x].
    terminal
        Gain of the power [rad/s per unit of the power].
    exponent
        Exponent of the power, within (0, 1).

    Raises
    ------
    ValueError
        If a value breaks a rule.
    """

    linear: float
    terminal: float
    exponent: float

    def __post_init__(self) -> None:
        """Check the fields."""
        non_negative(self.linear, "linear")
        non_negative(self.terminal, "terminal")
        within(self.exponent, 0.0, 1.0, "exponent")


@dataclass(frozen=True)
class FastTerminalSurface(_TerminalSurface):
    """c(x) = a x + b sig(x)^p, whose slope is singular at zero and is therefore held below a guard.

    Eqs. (29), (30) and (33) of Zhang and Zhou 2019, the last with the test on x itself (it is printed for x'). Within
    the guard the slope is not that of c: this error is the price of having no singularity.

    Parameters
    ----------
    linear, terminal, exponent
        a, b and p.
    guard
        ``|x|`` below which the slope of the second term stays at its value there.

    Raises
    ------
    ValueError
        If a value breaks a rule.
    """

    guard: float

    def __post_init__(self) -> None:
        """Check the fields."""
        super().__post_init__()
        positive(self.guard, "guard")

    def __call__(self, error: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return c(x) and its guarded slope."""
        term = self.linear * error + self.terminal * signed_power(error, self.exponent)
        steep = np.maximum(np.abs(error), self.guard) ** (self.exponent - 1.0)
        return term, self.linear + (self.terminal * self.exponent) * steep


@dataclass(frozen=True)
class NonsingularTerminalSurface(_TerminalSurface):
    """c(x) = k1 x + k2 S(x) with S = sig(x)^r outside ``|x|`` = mu and a parabola inside that continues it.

    Eqs. (63), (64) of Zhang and Zhou 2019, extended to negative x. The coefficients of the parabola c1 x + c2 x ``|x|``
    are not free, as printed: c1 = (2 - r) mu^(r-1) and c2 = (r - 1) mu^(r-2) make value and slope continuous.

    Parameters
    ----------
    linear, terminal, exponent
        k1, k2 and r.
    bound
        mu.

    Raises
    ------
    ValueError
        If a value breaks a rule.
    """

    bound: float

    def __post_init__(self) -> None:
        """Check the fields."""
        super().__post_init__()
        positive(self.bound, "bound")

    def __call__(self, error: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return c(x) and its slope."""
        ratio, slope = self.profile(np.abs(error))
        return ratio * error, slope

    def profile(self, magnitude: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return c(x)/x and dc/dx for ``|x|``, in any shape."""
        ratio, slope = self.terminal_part(magnitude)
        return self.linear + self.terminal * ratio, self.linear + self.terminal * slope

    def terminal_part(self, magnitude: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return S(x)/x and dS/dx for ``|x|``, in any shape."""
        return terminal_part(magnitude, self.exponent, self.bound)


def terminal_part(magnitude: FloatArray, exponent: float, bound: float | FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return S(x)/x and dS/dx of :class:`NonsingularTerminalSurface` for ``|x|`` in any shape, r and mu."""
    power = np.maximum(magnitude, bound) ** (exponent - 1.0)
    at_bound = bound ** (exponent - 1.0)
    first, second = (2.0 - exponent) * at_bound, (exponent - 1.0) * at_bound / bound
    near = magnitude < bound
    bent = second * magnitude
    return np.where(near, first + bent, power), np.where(near, first + 2.0 * bent, exponent * power)


def bound_of_slope(slope: float | FloatArray, terminal: float | FloatArray, exponent: float) -> float | FloatArray:
    """Return the mu with which k2 S(x) has a slope at zero: mu^(r-1) = slope / ((2 - r) k2).

    It stays within 1e-100 and 1e100, so that its powers are numbers.

    Parameters
    ----------
    slope, terminal
        Slope and k2 [rad/s], numbers or columns (N, 1).
    exponent
        r.
    """
    exact = np.log((2.0 - exponent) / slope * np.maximum(terminal, 1e-300)) / (1.0 - exponent)
    bound: float | FloatArray = np.exp(np.clip(exact, -230.0, 230.0))
    return bound
