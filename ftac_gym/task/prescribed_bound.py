"""A prescribed performance: bounds that shrink with time, within which the attitude error shall stay."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ftac_gym.utils.parameters import FloatArray, Vector, non_negative, positive, require, vector
from ftac_gym.utils.serialization import serializable


class Factors(NamedTuple):
    """The bounds in units of rho, and how they change: each (..., 3)."""

    lower: FloatArray
    upper: FloatArray
    lower_rate: FloatArray
    upper_rate: FloatArray


@serializable
@dataclass(frozen=True)
class PrescribedBound:
    """-lower_i(t) rho(t) < sigma_i < upper_i(t) rho(t) for the MRP sigma of the attitude error, short branch.

    rho(t) = (initial - final) exp(-decay t) + final, Eq. (21) of Chen et al. 2018. The factors on it are constant, or
    come down from ``initial_factor`` to their final values as exp(-factor_decay t), Eq. (23); the paper starts them at
    infinity, which nothing can simulate and which would ask for an infinite rate.

    Parameters
    ----------
    initial, final
        rho_0 and rho_inf, of which the last is not above the first.
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
        for name in ("initial", "final"):
            object.__setattr__(self, name, positive(getattr(self, name), name))
        require(self.final <= self.initial, "final", f"must not exceed initial = {self.initial!r}", self.final)
        for name in ("decay", "factor_decay"):
            object.__setattr__(self, name, non_negative(getattr(self, name), name))
        for name in ("lower", "upper"):
            factors = vector(getattr(self, name), 3, name)
            require(min(factors) > 0.0, name, "must be positive", factors)
            object.__setattr__(self, name, factors)
        if self.initial_factor is not None:
            object.__setattr__(self, "initial_factor", positive(self.initial_factor, "initial_factor"))
            largest = max(*self.lower, *self.upper)
            rule = f"must not be below the final factors, of which the largest is {largest!r}"
            require(self.initial_factor >= largest, "initial_factor", rule, self.initial_factor)

    def rho(self, time: npt.ArrayLike) -> FloatArray:
        """Return rho at times of any shape [s]."""
        fading = np.exp(-self.decay * np.asarray(time, dtype=np.float64))
        width: FloatArray = (self.initial - self.final) * fading + self.final
        return width

    def relative_rate(self, time: npt.ArrayLike) -> FloatArray:
        """Return rho' / rho at times of any shape [1/s]."""
        width = self.rho(time)
        change: FloatArray = -self.decay * (width - self.final) / width
        return change

    def factors(self, time: npt.ArrayLike) -> Factors:
        """Return the factors on rho and their derivatives [1/s] at times (...) [s], each (..., 3)."""
        moments = np.asarray(time, dtype=np.float64)[..., None]
        lower, upper = np.array(self.lower), np.array(self.upper)
        if self.initial_factor is None:
            nothing = np.zeros((*moments.shape[:-1], 3))
            return Factors(lower + nothing, upper + nothing, nothing, nothing)
        fading = np.exp(-self.factor_decay * moments)
        above_lower, above_upper = (self.initial_factor - lower) * fading, (self.initial_factor - upper) * fading
        return Factors(
            lower + above_lower, upper + above_upper, -self.factor_decay * above_lower, -self.factor_decay * above_upper
        )

    def bound(self, time: npt.ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return the least and the largest MRP allowed at times (...) [s], each (..., 3)."""
        factors, width = self.factors(time), self.rho(time)[..., None]
        return -factors.lower * width, factors.upper * width

    def margin(self, error: FloatArray, time: npt.ArrayLike) -> FloatArray:
        """Return how far inside the bounds errors are, in units of the bounds' distance; negative outside.

        Parameters
        ----------
        error
            (..., 3) MRP of the attitude error.
        time
            [s]; its shape (...) must broadcast with that of the errors.
        """
        low, high = self.bound(time)
        share: FloatArray = np.minimum(error - low, high - error) / (high - low)
        return share

    def mirrored(self, axes: npt.ArrayLike) -> PrescribedBound:
        """Return the bounds with lower and upper exchanged on the axes of a mask (3,)."""
        mask = np.asarray(axes)
        valid = mask.shape == (3,) and mask.dtype == np.bool_
        require(valid, "axes", "must be a boolean array of shape (3,)", axes)
        lower, upper = np.where(mask, self.upper, self.lower), np.where(mask, self.lower, self.upper)
        return replace(self, lower=tuple(lower.tolist()), upper=tuple(upper.tolist()))
