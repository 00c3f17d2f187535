"""Point estimates with bootstrap intervals, alone and in pairs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import stats

from ftac_gym.parameters import FloatArray, require

RESAMPLES = 2000
CONFIDENCE = 0.95


@dataclass(frozen=True)
class Estimate:
    """A point estimate with its confidence interval.

    Attributes
    ----------
    value
        Point estimate.
    low, high
        Ends of the interval.
    count
        Episodes behind it.
    """

    value: float
    low: float
    high: float
    count: int

    @property
    def excludes_zero(self) -> bool:
        """Whether zero lies outside the interval."""
        return self.low > 0.0 or self.high < 0.0


def mean(values: FloatArray, axis: int = -1) -> Any:
    """Return the mean."""
    return np.mean(values, axis=axis)


def interquartile_mean(values: FloatArray, axis: int = -1) -> Any:
    """Return the mean of the middle half: robust like the median, but it uses half of the data."""
    return stats.trim_mean(values, 0.25, axis=axis)


def estimate(values: FloatArray, statistic: Callable[..., Any] = mean, seed: int = 0) -> Estimate:
    """Estimate a statistic of per-episode values.

    Parameters
    ----------
    values
        (N,) one value per episode; NaN is left out.
    statistic
        :func:`mean` or :func:`interquartile_mean`, or any function of (values, axis).
    seed
        Seed of the resampling.

    Returns
    -------
    The estimate with a percentile bootstrap interval; NaN if there are no values.
    """
    known = np.asarray(values, dtype=np.float64)
    known = known[~np.isnan(known)]
    if known.size == 0:
        return Estimate(float("nan"), float("nan"), float("nan"), 0)
    point = float(statistic(known))
    if known.size == 1 or np.ptp(known) == 0.0:
        return Estimate(point, point, point, known.size)
    interval = stats.bootstrap(
        (known,),
        statistic,
        n_resamples=RESAMPLES,
        confidence_level=CONFIDENCE,
        method="percentile",
        rng=np.random.default_rng(seed),
    ).confidence_interval
    return Estimate(point, float(interval.low), float(interval.high), known.size)


def paired_difference(
    first: FloatArray, second: FloatArray, statistic: Callable[..., Any] = mean, seed: int = 0
) -> Estimate:
    """Estimate a statistic of first - second over the same episodes.

    Episodes in which either is NaN are left out. Resampling whole pairs keeps what the two have in common out of the
    interval: luck in the draw of the episodes cancels.

    Raises
    ------
    ValueError
        If the two do not have the same episodes.
    """
    require(len(first) == len(second), "episodes", f"must be the same {len(first)} for both", len(second))
    return estimate(np.asarray(first) - np.asarray(second), statistic, seed)
