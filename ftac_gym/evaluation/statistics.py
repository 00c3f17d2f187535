"""Point estimates with bootstrap intervals: of policies and of agents over training seeds, alone and in pairs.

Tables use intervals over training seeds *and* episodes (``levels="both"``): they describe a new seed of the method on
new episodes. Agarwal et al. 2021 ("Deep reinforcement learning at the edge of the statistical precipice", rliable) hold
the tasks fixed and draw runs anew within each task. With episodes as tasks that is ``levels="seeds"``, which describes
other seeds on the same episodes.

A baseline has a single run, and only its episodes can be drawn anew. Drawing rows and columns is slightly conservative
(Owen 2007, "The pigeonhole bootstrap"). The variance of a seed in a single episode is counted up to three times, an
excess that vanishes with the number of both. Shares have intervals of their own (:mod:`ftac_gym.evaluation.shares`).
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import stats

from ftac_gym.evaluation.bootstrap import Levels, aligned, bootstrap, resampled
from ftac_gym.evaluation.shares import difference_ends, effective_count, share_ends
from ftac_gym.utils.parameters import FloatArray

Statistic = Callable[..., Any]
"""Function of values and axis: :func:`mean`, :func:`share`, :func:`interquartile_mean` or another one."""


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


def share(values: FloatArray, axis: int = -1) -> Any:
    """Return the mean of values within [0, 1]; its interval covers near zero and one too."""
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
        :func:`mean`, :func:`share` or :func:`interquartile_mean`, or any function of (values, axis).
    seed
        Seed of the resampling.
    levels
        ``"both"`` draws seeds and episodes anew, ``"seeds"`` seeds alone, in each episode for itself.

    Returns
    -------
    The estimate with a percentile bootstrap interval; NaN if there are no values. A :func:`share` of seeds and episodes
    has Wilson's interval (:mod:`ftac_gym.evaluation.shares`).

    Raises
    ------
    ValueError
        If the levels are unknown or values have other axes.
    """
    found = _estimate([values], lambda item: _over_known(item, statistic), seed, levels)
    if statistic is not share or levels == "seeds" or not found.count:
        return found
    data = aligned(values)
    count = float(found.count)
    if len(data[0]) > 1 or not _binary(data[0]):
        _, drawn = resampled(data, lambda item: _over_known(item, share), seed, levels)
        count = effective_count(found.value * (1.0 - found.value), float(np.nanvar(drawn)), found.count)
    low, high = share_ends(found.value, count)
    return replace(found, low=low, high=high)


def paired_difference(
    first: npt.ArrayLike, second: npt.ArrayLike, statistic: Statistic = mean, seed: int = 0, levels: Levels = "both"
) -> Estimate:
    """Estimate a statistic of first - second over pairs of training seeds in the same episode.

    Pairs in which either is NaN are left out. Episodes are drawn for both together, which cancels the common part of
    both in the interval. The seeds of each are drawn on their own. A difference of a :func:`share` of values that are 0
    or 1 has the interval of Bonett and Price (:mod:`ftac_gym.evaluation.shares`).

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
    found = _estimate(
        [first, second], lambda one, other: _over_known(_differences(one, other), statistic), seed, levels
    )
    data = aligned(first, second)
    if statistic is not share or levels == "seeds" or not found.count or not all(map(_binary, data)):
        return found
    pairs = _differences(data[0][None], data[1][None])
    pairs = pairs[~np.isnan(pairs)]
    better, worse, count = float((pairs > 0.0).mean()), float((pairs < 0.0).mean()), float(found.count)
    if max(map(len, data)) > 1:
        _, drawn = resampled(data, lambda one, other: _over_known(_differences(one, other), share), seed, levels)
        count = effective_count(better + worse - found.value**2, float(np.nanvar(drawn)), found.count)
    low, high = difference_ends(better, worse, count)
    return replace(found, low=low, high=high)


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

    def chance(one: FloatArray, other: FloatArray) -> FloatArray:
        won = 0.5 + 0.5 * np.sign(sign * _differences(one, other))
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", "Mean of empty slice")
            found: FloatArray = np.nanmean(np.nanmean(won, axis=(1, 2)), axis=1)
        return found

    return _estimate([first, second], chance, seed, levels)


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


def _binary(values: FloatArray) -> bool:
    """Return whether all values are zero, one or NaN."""
    return bool(np.isin(values[~np.isnan(values)], (0.0, 1.0)).all())


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
