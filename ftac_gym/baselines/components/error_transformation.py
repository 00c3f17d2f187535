"""The error transformation of prescribed performance: from the interval of the bounds to all real numbers."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ftac_gym.attitude import angular_velocity_from_mrp
from ftac_gym.task.prescribed_bound import PrescribedBound
from ftac_gym.utils.parameters import FloatArray, within


class Transformed(NamedTuple):
    """epsilon, r and theta of epsilon' = r sigma' + theta, each (N, 3)."""

    error: FloatArray
    slope: FloatArray
    drift: FloatArray

    def rate(self, sigma: FloatArray, change: FloatArray) -> FloatArray:
        """Return the body rate G^-1 r^-1 (epsilon' - theta) (N, 3) [rad/s] for a demanded epsilon' (N, 3) at sigma."""
        return angular_velocity_from_mrp(sigma, (change - self.drift) / self.slope)


class ErrorTransformation:
    """epsilon = 1/2 ln[(lower + x) / (upper - x)] with x = sigma / rho, Eqs. (24)-(27) of Chen et al. 2018.

    With l and u the factors of the bounds and x' at constant sigma equal to -x rho'/rho, Eq. (27) is::

        theta = 1/2 [(l' - x rho'/rho) / (l + x) - (u' + x rho'/rho) / (u - x)]

    whose parentheses are lost in print. epsilon = 0 is the middle of the bounds, which is sigma = 0 only where l = u.

    Within ``margin`` of a bound, in units of the distance l + u, and beyond it, epsilon continues along its tangent. It
    stays a continuous function of sigma and time with a continuous slope that is never zero. A law that drives epsilon
    to zero therefore brings sigma back after a breach.

    Parameters
    ----------
    bound
        The bounds.
    margin
        Within (0, 0.5).

    Raises
    ------
    ValueError
        If the margin is not within (0, 0.5).
    """

    def __init__(self, bound: PrescribedBound, margin: float) -> None:
        self.bound = bound
        self._margin = within(margin, 0.0, 0.5, "margin")

    def __call__(self, error: FloatArray, time: FloatArray, mirrored: FloatArray | None = None) -> Transformed:
        """Transform MRPs (N, 3) at times (N,) [s]; lower and upper are exchanged where ``mirrored`` (N, 3)."""
        lower, upper, lower_rate, upper_rate = self.bound.factors(time)
        if mirrored is not None:
            lower, upper = np.where(mirrored, upper, lower), np.where(mirrored, lower, upper)
            lower_rate, upper_rate = (
                np.where(mirrored, upper_rate, lower_rate),
                np.where(mirrored, lower_rate, upper_rate),
            )
        rho, shrinking = self.bound.rho(time)[:, None], self.bound.relative_rate(time)[:, None]
        distance, distance_rate = lower + upper, lower_rate + upper_rate
        share = (lower + error / rho) / distance
        # y = (l + x) / (l + u) goes from 0 to 1, and epsilon is a function of it alone.
        share_rate = (lower_rate - error / rho * shrinking - share * distance_rate) / distance
        inside = np.minimum(np.maximum(share, self._margin), 1.0 - self._margin)
        slope = 0.5 / (inside * (1.0 - inside))
        transformed = 0.5 * np.log(inside / (1.0 - inside)) + slope * (share - inside)
        return Transformed(transformed, slope / (distance * rho), slope * share_rate)
