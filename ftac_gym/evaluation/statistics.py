"""Point estimates with bootstrap intervals: of policies and of agents over training seeds, alone and in pairs.

Tables use intervals over training seeds *and* episodes (``levels="both"``): they describe a new seed of the method on
new episodes. Agarwal et al. 2021 ("Deep reinforcement learning at the edge of the statistical precipice", rliable) hold
the tasks fixed and draw runs anew within each task. With episodes as tasks that is ``levels="seeds"``, which describes
other seeds on the same episodes.

A baseline has a single run, and only its episodes can be drawn anew. Drawing rows and columns is slightly conservative
(Owen 2007, "The pigeonhole bootstrap"). The variance of a seed in a single episode is counted up to three times, an
excess that vanishes with the number of both.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import stats

from ftac_gym.evaluation.bootstrap import Levels, aligned, bootstrap
from ftac_gym.utils.parameters import FloatArray

Statistic = Callable[..., Any]
"""Function of values and axis: :func:`mean`, :func:`interquartile_mean` or another one."""


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
        Number of episodes in which the metric is defined.
    defined, total
        Number of values, over all training seeds, and of all that could be defined; of pairs for comparisons.
    """

    value: float
    low: float
    high: float
    count: int
    defined: int = field(default=0, compare=False)
    total: int = field(default=0, compare=False)

    @property
    def excludes_zero(self) -> bool:
        """True if zero lies outside the interval."""
        return self.low > 0.0 or self.high < 0.0


def mean(values: FloatArray, axis: int = -1) -> Any:
    """Return the mean."""
    return np.mean(values, axis=axis)


def interquartile_mean(values: FloatArray, axis: int = -1) -> Any:
    """Return the mean of the middle half: robust like the median, but it uses half of the data."""
    return stats.trim_mean(values, 0.25, axis=axis)


def estimate(values: npt.ArrayLike, statistic: Statistic = mean, seed: int = 0, levels: Levels = "both") -> Estimate:
    """Estimate a statistic of the values of all training seeds and episodes.

    Parameters
    ----------
    values
        (seeds, episodes), or (episodes,) of a policy without seeds; NaN is left out.
    statistic
        :func:`mean` or :func:`interquartile_mean`, or any function of (values, axis).
    seed
        Seed of the resampling.
    levels
        ``"both"`` draws seeds and episodes anew, ``"seeds"`` seeds alone, in each episode for itself.

    Returns
    -------
    The estimate with a percentile bootstrap interval; NaN if there are no values.

    Raises
    ------
    ValueError
        If the levels are unknown or values have other axes.
    """
    return _estimate([values], lambda item: _over_known(item, statistic), seed, levels)


def paired_difference(
    first: npt.ArrayLike, second: npt.ArrayLike, statistic: Statistic = mean, seed: int = 0, levels: Levels = "both"
) -> Estimate:
    """Estimate a statistic of first - second over pairs of training seeds in the same episode.

    Pairs in which either is NaN are left out. Episodes are drawn for both together, which cancels the common part of
    both in the interval. The seeds of each are drawn on their own.

    Parameters
    ----------
    first, second
        (seeds, episodes), with numbers of seeds of their own, or (episodes,).
    statistic, seed, levels
        See :func:`estimate`.

    Raises
    ------
    ValueError
        If the two do not have the same episodes, the levels are unknown, or values have other axes.
    """
    return _estimate([first, second], lambda one, other: _over_known(_differences(one, other), statistic), seed, levels)


def relative_difference(
    first: npt.ArrayLike,
    second: npt.ArrayLike,
    statistic: Statistic = interquartile_mean,
    seed: int = 0,
    levels: Levels = "both",
) -> Estimate:
    """Estimate statistic(first) / statistic(second) - 1 on the same episodes.

    Parameters and errors are those of :func:`paired_difference`. Rounding errors are cut off: equal policies have a
    difference of zero.
    """

    def ratio(one: FloatArray, other: FloatArray) -> FloatArray:
        change: FloatArray = _over_known(one, statistic) / _over_known(other, statistic) - 1.0
        return np.round(change, 12) + 0.0

    return _estimate([first, second], ratio, seed, levels)


def probability_of_improvement(
    first: npt.ArrayLike, second: npt.ArrayLike, smaller_is_better: bool = False, seed: int = 0, levels: Levels = "both"
) -> Estimate:
    """Estimate the probability that the first is better than the second in an episode, a tie counting half.

    In every episode each seed of the first is compared with each of the second. The mean is over episodes, as that of
    Agarwal et al. 2021 is over tasks.

    Parameters
    ----------
    first, second
        (seeds, episodes), with numbers of seeds of their own, or (episodes,); pairs with NaN are left out.
    smaller_is_better
        Whether the better one has the smaller value.
    seed, levels
        See :func:`estimate`.

    Raises
    ------
    ValueError
        If the two do not have the same episodes, the levels are unknown, or values have other axes.
    """
    sign = -1.0 if smaller_is_better else 1.0

    def share(one: FloatArray, other: FloatArray) -> FloatArray:
        won = 0.5 + 0.5 * np.sign(sign * _differences(one, other))
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", "Mean of empty slice")
            found: FloatArray = np.nanmean(np.nanmean(won, axis=(1, 2)), axis=1)
        return found

    return _estimate([first, second], share, seed, levels)


@dataclass(frozen=True, eq=False)
class Curve:
    """A curve with a pointwise band.

    Attributes
    ----------
    x, y, low, high
        (K,) places, values, and the ends of their intervals.
    count
        Number of episodes, or of training seeds.
    """

    x: FloatArray
    y: FloatArray
    low: FloatArray
    high: FloatArray
    count: int


def performance_profile(
    values: npt.ArrayLike,
    thresholds: npt.ArrayLike,
    smaller_is_better: bool = False,
    seed: int = 0,
    levels: Levels = "both",
) -> Curve:
    """Return the share of scores, of all seeds and episodes, above each threshold: a performance profile.

    Parameters
    ----------
    values
        (seeds, episodes) or (episodes,); NaN is left out.
    thresholds
        (K,) in units of the values.
    smaller_is_better
        Return the share that is at or below each threshold instead.
    seed, levels
        See :func:`estimate`.

    Raises
    ------
    ValueError
        If the levels are unknown or values have other axes.
    """
    data, limits = aligned(values), np.asarray(thresholds, dtype=np.float64)

    def share(item: FloatArray) -> FloatArray:
        # NaN stands at the end of the ordered rows, above every threshold.
        rows = np.sort(item.reshape(len(item), -1), axis=1)
        known = (~np.isnan(rows)).sum(axis=1)[:, None]
        with np.errstate(invalid="ignore"):
            below: FloatArray = np.array([np.searchsorted(row, limits, side="right") for row in rows]) / known
        return below if smaller_is_better else 1.0 - below

    count = data[0].shape[1]
    if not count:
        nothing = np.full(limits.shape, np.nan)
        return Curve(limits, nothing, nothing, nothing, 0)
    return Curve(limits, *bootstrap(data, share, seed, levels), count)


def _estimate(
    values: Sequence[npt.ArrayLike], measure: Callable[..., FloatArray], seed: int, levels: Levels
) -> Estimate:
    """Return the estimate of a measure, as :func:`~ftac_gym.evaluation.bootstrap.bootstrap` takes it."""
    data = aligned(*values)
    # A value of one policy is in as many pairs of its episode as the other has values there.
    defined = int(np.prod([(~np.isnan(item)).sum(axis=0) for item in data], axis=0).sum())
    total = int(np.prod(list(map(len, data)))) * np.atleast_2d(np.asarray(values[0])).shape[1]
    count = data[0].shape[1]
    value, low, high = bootstrap(data, measure, seed, levels) if count else (np.full((), np.nan),) * 3
    return Estimate(float(value), float(low), float(high), count, defined, total)


def _differences(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return first - second (B, s, t, N) for all pairs of seeds of resamples (B, s, N) and (B, t, N)."""
    return first[:, :, None] - second[:, None]


def _over_known(values: FloatArray, statistic: Statistic) -> FloatArray:
    """Return the statistic of each of B resamples (B, ...), without NaN."""
    rows = values.reshape(len(values), -1)
    known = ~np.isnan(rows)
    if known.all():
        return np.asarray(statistic(rows, axis=-1))
    found = (statistic(row[there], axis=-1) if there.any() else np.nan for row, there in zip(rows, known, strict=True))
    return np.fromiter(found, dtype=np.float64)
