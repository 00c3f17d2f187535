"""Prescribed performance: bounds on the attitude error that shrink with time."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ftac_gym.utils.parameters import FloatArray, Vector, non_negative, normalise, optional, positive, require, vector
from ftac_gym.utils.serialization import serializable


class Factors(NamedTuple):
    """Bounds in units of rho and their derivatives [1/s], each (..., 3)."""

    lower: FloatArray
    upper: FloatArray
    lower_rate: FloatArray
    upper_rate: FloatArray


@serializable
@dataclass(frozen=True)
class PrescribedBound:
    """Bound -lower_i(t) rho(t) < sigma_i < upper_i(t) rho(t) for the MRP sigma of the attitude error, short branch.

    rho(t) = (initial - final) exp(-decay t) + final, Eq. (21) of Chen et al. 2018. The factors on it are constant, or
    decrease from ``initial_factor`` to their final values as exp(-factor_decay t), Eq. (23). The paper starts them at
    infinity, which cannot be simulated and would ask for an infinite rate.

    Parameters
    ----------
    initial, final
        rho_0 and rho_inf; the last must not exceed the first.
    decay
        kappa [1/s].
    lower, upper
        Final factors of the axes, q/p and b/a in the paper.
    initial_factor
        delta(0) of every factor, not below their final values; None keeps the factors at these.
    factor_decay
        p = a [1/s].

    Raises
    ------
    ValueError
        If a value breaks a rule.
    """

    initial: float = 1.5
    final: float = 1e-3
    decay: float = 0.04
    lower: Vector = (1.0, 1.0, 1.0)
    upper: Vector = (1.0, 1.0, 1.0)
    initial_factor: float | None = None
    factor_decay: float = 5.0

    def __post_init__(self) -> None:
        """Check and normalise the fields."""
        normalise(self, positive, "initial", "final")
        require(self.final <= self.initial, "final", f"must not exceed initial = {self.initial!r}", self.final)
        normalise(self, non_negative, "decay", "factor_decay")
        normalise(self, lambda value, name: vector(value, 3, name), "lower", "upper")
        for name in ("lower", "upper"):
            require(min(getattr(self, name)) > 0.0, name, "must be positive", getattr(self, name))
        normalise(self, optional(positive), "initial_factor")
        if self.initial_factor is not None:
            largest = max(*self.lower, *self.upper)
            rule = f"must not be below the final factors, of which the largest is {largest!r}"
            require(self.initial_factor >= largest, "initial_factor", rule, self.initial_factor)

    def rho(self, time: npt.ArrayLike) -> FloatArray:
        """Return rho at times of any shape [s]."""
        decay = np.exp(-self.decay * np.asarray(time, dtype=np.float64))
        return (self.initial - self.final) * decay + self.final

    def relative_rate(self, time: npt.ArrayLike) -> FloatArray:
        """Return rho' / rho at times of any shape [1/s]."""
        width = self.rho(time)
        return -self.decay * (width - self.final) / width

    def factors(self, time: npt.ArrayLike) -> Factors:
        """Return the factors on rho and their derivatives [1/s] at times (...) [s], each (..., 3)."""
        moments = np.asarray(time, dtype=np.float64)[..., None]
        lower, upper = np.array(self.lower), np.array(self.upper)
        if self.initial_factor is None:
            zero = np.zeros((*moments.shape[:-1], 3))
            return Factors(lower + zero, upper + zero, zero, zero)
        decay = np.exp(-self.factor_decay * moments)
        above_lower, above_upper = (self.initial_factor - lower) * decay, (self.initial_factor - upper) * decay
        return Factors(
            lower + above_lower, upper + above_upper, -self.factor_decay * above_lower, -self.factor_decay * above_upper
        )

    def bound(self, time: npt.ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return the least and the largest MRP allowed at times (...) [s], each (..., 3)."""
        factors, width = self.factors(time), self.rho(time)[..., None]
        return -factors.lower * width, factors.upper * width

    def margin(self, error: FloatArray, time: npt.ArrayLike) -> FloatArray:
        """Return the distance of errors from the nearer bound over that between the bounds; negative outside.

        Parameters
        ----------
        error
            (..., 3) MRP of the attitude error.
        time
            [s]; its shape (...) must broadcast with that of the errors.
        """
        low, high = self.bound(time)
        return np.minimum(error - low, high - error) / (high - low)

    def mirrored(self, axes: npt.ArrayLike) -> PrescribedBound:
        """Return the bounds with lower and upper exchanged on the axes of a mask (3,)."""
        mask = np.asarray(axes)
        valid = mask.shape == (3,) and mask.dtype == np.bool_
        require(valid, "axes", "must be a boolean array of shape (3,)", axes)
        lower, upper = np.where(mask, self.upper, self.lower), np.where(mask, self.lower, self.upper)
        return replace(self, lower=tuple(lower.tolist()), upper=tuple(upper.tolist()))
