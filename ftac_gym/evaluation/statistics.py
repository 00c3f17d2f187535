"""Point estimates with bootstrap intervals: of single policies and of agents over training seeds, alone and in pairs.

Tables use intervals over training seeds *and* episodes (``levels="both"``): what a reader wants to know is what the
method does with a new seed on new episodes. Agarwal et al. 2021 ("Deep reinforcement learning at the edge of the
statistical precipice", rliable) hold the tasks fixed and draw runs anew within each task; with episodes as tasks that
is ``levels="seeds"``, which says how well the seeds at hand stand for others on these very episodes. A baseline has a
single run: with seeds alone nothing could be drawn anew. Drawing both, rows and columns, is a little cautious: what
belongs to one seed in one episode alone is counted up to three times in the variance (Owen 2007, "The pigeonhole
bootstrap"), which vanishes with the number of both.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import stats

from ftac_gym.evaluation.bootstrap import (
    CONFIDENCE,
    RESAMPLES,
    Levels,
    draw,
    interval,
    known,
    means,
    over_seeds,
    trimmed_means,
    weighted,
)
from ftac_gym.utils.parameters import FloatArray, require


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
    given = np.asarray(values, dtype=np.float64)
    given = given[~np.isnan(given)]
    if given.size == 0:
        return Estimate(float("nan"), float("nan"), float("nan"), 0)
    point = float(statistic(given))
    if given.size == 1 or np.ptp(given) == 0.0:
        return Estimate(point, point, point, given.size)
    ends = stats.bootstrap(
        (given,),
        statistic,
        n_resamples=RESAMPLES,
        confidence_level=CONFIDENCE,
        method="percentile",
        rng=np.random.default_rng(seed),
    ).confidence_interval
    return Estimate(point, float(ends.low), float(ends.high), given.size)


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


def stratified_estimate(
    values: npt.ArrayLike, statistic: Callable[..., Any] = mean, seed: int = 0, levels: Levels = "both"
) -> Estimate:
    """Estimate a statistic of all values of several training seeds on the same episodes.

    Parameters
    ----------
    values
        (seeds, episodes), or (episodes,) of a policy that has no seeds; NaN is left out.
    statistic
        :func:`mean` or :func:`interquartile_mean`.
    seed
        Seed of the resampling.
    levels
        ``"both"`` draws seeds and episodes anew, ``"seeds"`` seeds alone, in each episode for itself.

    Raises
    ------
    ValueError
        If the statistic or the levels are unknown, or values have other axes.
    """
    data = known(values)
    episodes, (seeds,) = draw(data, seed, levels)
    return _summary(_resampled(data[0], seeds, episodes, statistic), data[0].shape[1])


def stratified_difference(
    first: npt.ArrayLike,
    second: npt.ArrayLike,
    statistic: Callable[..., Any] = mean,
    seed: int = 0,
    levels: Levels = "both",
    relative: bool = False,
) -> Estimate:
    """Estimate statistic(first) - statistic(second) of two contestants on the same episodes.

    Episodes are drawn for both together, so that luck in their draw cancels; the seeds of each on their own. What is
    compared are pairs of a seed of the first with one of the second in the same episode; those in which either is NaN
    are left out. The difference of means is the mean difference of these pairs.

    Parameters
    ----------
    first, second
        (seeds, episodes), with numbers of seeds of their own, or (episodes,).
    statistic
        :func:`mean` or :func:`interquartile_mean`.
    seed
        Seed of the resampling.
    levels
        ``"both"`` draws seeds and episodes anew, ``"seeds"`` seeds alone, in each episode for itself.
    relative
        Estimate statistic(first) / statistic(second) - 1 instead.

    Raises
    ------
    ValueError
        If the two do not have the same episodes, the statistic or the levels are unknown, or values have other axes.
    """
    one, other = data = known(first, second)
    episodes, seeds = draw(data, seed, levels)
    # A value counts as often as it has partners; with nothing missing, once.
    often = [
        episodes
        if not np.isnan(item).any()
        else episodes * over_seeds((~np.isnan(item)).astype(float), counts) / len(item)
        for counts, item in zip(seeds, data, strict=True)
    ]
    value, base = _resampled(one, seeds[0], often[1], statistic), _resampled(other, seeds[1], often[0], statistic)
    return _summary(value / base - 1.0 if relative else value - base, one.shape[1])


def probability_of_improvement(
    first: npt.ArrayLike,
    second: npt.ArrayLike,
    smaller_is_better: bool = False,
    seed: int = 0,
    levels: Levels = "both",
) -> Estimate:
    """Estimate how likely the first is better than the second in an episode, a tie counting half.

    In every episode each seed of the first is compared with each of the second; the mean is over episodes, as that of
    Agarwal et al. 2021 is over tasks.

    Parameters
    ----------
    first, second
        (seeds, episodes), with numbers of seeds of their own, or (episodes,); pairs with NaN are left out.
    smaller_is_better
        Whether the better one has the smaller value.
    seed
        Seed of the resampling.
    levels
        ``"both"`` draws seeds and episodes anew, ``"seeds"`` seeds alone, in each episode for itself.

    Raises
    ------
    ValueError
        If the two do not have the same episodes, the levels are unknown, or values have other axes.
    """
    one, other = data = known(first, second)
    episodes, seeds = draw(data, seed, levels)
    advantage = one[:, None] - other[None]
    comparable = ~np.isnan(advantage)
    won = np.where(comparable, 0.5 + 0.5 * np.sign(-advantage if smaller_is_better else advantage), 0.0)
    wins, pairs = (
        np.einsum("btn,btn->bn", np.einsum("bsn,stn->btn", seeds[0], item), seeds[1])
        for item in (won, comparable.astype(np.float64))
    )
    episodes = episodes * (pairs > 0.0)
    with np.errstate(invalid="ignore"):
        draws = (episodes * wins / np.maximum(pairs, 1.0)).sum(axis=1) / episodes.sum(axis=1)
    return _summary(draws, one.shape[1])


@dataclass(frozen=True, eq=False)
class PerformanceProfile:
    """What share of the scores is beyond each threshold, with a pointwise band.

    Attributes
    ----------
    thresholds
        (K,) in units of the scores.
    share, low, high
        (K,) the share and the ends of its interval.
    count
        Episodes behind it.
    """

    thresholds: FloatArray
    share: FloatArray
    low: FloatArray
    high: FloatArray
    count: int


def performance_profile(
    values: npt.ArrayLike,
    thresholds: npt.ArrayLike,
    smaller_is_better: bool = False,
    seed: int = 0,
    levels: Levels = "both",
) -> PerformanceProfile:
    """Return the share of scores, of all seeds and episodes, above each threshold.

    Parameters
    ----------
    values
        (seeds, episodes) or (episodes,); NaN is left out.
    thresholds
        (K,) where to look.
    smaller_is_better
        Return the share that is at or below each threshold instead.
    seed
        Seed of the resampling.
    levels
        ``"both"`` draws seeds and episodes anew, ``"seeds"`` seeds alone, in each episode for itself.

    Raises
    ------
    ValueError
        If the levels are unknown or values have other axes.
    """
    data = known(values)
    count = data[0].shape[1]
    episodes, (seeds,) = draw(data, seed, levels)
    ordered, weights = weighted(data[0], seeds, episodes)
    reached = np.cumsum(np.pad(weights, ((0, 0), (1, 0))), axis=1)
    where = np.asarray(thresholds, dtype=np.float64)
    with np.errstate(invalid="ignore"):
        below = reached[:, np.searchsorted(ordered, where, side="right")] / reached[:, -1:]
    share = below if smaller_is_better else 1.0 - below
    low, high = interval(share[1:]) if count else (share[0], share[0])
    return PerformanceProfile(where, share[0], low, high, count)


_CUT: dict[Callable[..., Any], float] = {mean: 0.0, interquartile_mean: 0.25}
"""What each statistic leaves out at either end."""


def _resampled(
    values: FloatArray, seeds: FloatArray, episodes: FloatArray, statistic: Callable[..., Any]
) -> FloatArray:
    """Return the statistic of the sample and of all resamples, (1 + RESAMPLES,)."""
    require(statistic in _CUT, "statistic", f"must be one of {[item.__name__ for item in _CUT]}", statistic)
    if statistic is mean:  # which needs no order
        return means(values, seeds, episodes)
    return trimmed_means(*weighted(values, seeds, episodes), _CUT[statistic])


def _summary(draws: FloatArray, count: int) -> Estimate:
    """Return the estimate of a statistic of the sample and of all resamples (1 + RESAMPLES,)."""
    if not count:
        return Estimate(float("nan"), float("nan"), float("nan"), 0)
    low, high = interval(draws[1:])
    return Estimate(float(draws[0]), float(low), float(high), count)
