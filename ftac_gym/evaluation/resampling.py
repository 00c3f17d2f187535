"""Bootstrap of crossed data, training seeds by episodes, as counts: how often a resample draws each row and column.

Data are sorted once, a resample is a row of weights on them, and a trimmed mean is a sum over cumulative weights. The
first row of all counts is the sample itself, everything drawn once.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
import numpy.typing as npt

from ftac_gym.parameters import FloatArray, require

RESAMPLES = 2000
CONFIDENCE = 0.95

Levels = Literal["both", "seeds"]
"""What is drawn anew: seeds and episodes, or seeds alone, in every episode for itself."""


def known(*values: npt.ArrayLike) -> list[FloatArray]:
    """Return data as (seeds, episodes), of the episodes in which every contestant has a value at all.

    Parameters
    ----------
    *values
        (seeds, episodes) or (episodes,), one per contestant; NaN is no value.

    Raises
    ------
    ValueError
        If data have other axes or are not of the same episodes.
    """
    data = [np.atleast_2d(np.asarray(item, dtype=np.float64)) for item in values]
    for item in data:
        require(item.ndim == 2, "values", "must have shape (seeds, episodes) or (episodes,)", item.shape)
        rule = f"must be the same {data[0].shape[1]} for both"
        require(item.shape[1] == data[0].shape[1], "episodes", rule, item.shape[1])
    chosen = np.all([~np.isnan(item).all(axis=0) for item in data], axis=0)
    return [item[:, chosen] for item in data]


def draw(data: Sequence[FloatArray], seed: int, levels: Levels) -> tuple[FloatArray, list[FloatArray]]:
    """Draw resamples of data (seeds, episodes) of contestants on the same episodes.

    Returns
    -------
    How often each episode is drawn, (1 + RESAMPLES, episodes), for all contestants together, and how often each seed
    is, (1 + RESAMPLES, seeds, episodes), for each contestant on its own.

    Raises
    ------
    ValueError
        If the levels are unknown.
    """
    require(levels in ("both", "seeds"), "levels", "must be 'both' or 'seeds'", levels)
    random = np.random.default_rng(seed)
    size, strata = data[0].shape[1], data[0].shape[1] if levels == "seeds" else 1
    episodes = np.ones((1 + RESAMPLES, size))
    if levels == "both":
        episodes[1:] = _counts(random, RESAMPLES, size)
    seeds = []
    for item in data:
        counts = np.ones((1 + RESAMPLES, len(item), strata))
        drawn = _counts(random, RESAMPLES * strata, len(item))
        counts[1:] = drawn.reshape(RESAMPLES, strata, len(item)).swapaxes(1, 2)
        seeds.append(np.broadcast_to(counts, (1 + RESAMPLES, *item.shape)))
    return episodes, seeds


def weighted(values: FloatArray, seeds: FloatArray, episodes: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the known values (K,) in rising order and their weights (B, K): how often seed and episode are drawn."""
    row, column = np.nonzero(~np.isnan(values))
    order = np.argsort(values[row, column], kind="stable")
    row, column = row[order], column[order]
    return values[row, column], seeds[:, row, column] * episodes[:, column]


def _counts(random: np.random.Generator, resamples: int, size: int) -> FloatArray:
    """Return how often each of some things is drawn in as many draws with replacement, (resamples, size)."""
    drawn = random.integers(0, size, (resamples, size))
    drawn += size * np.arange(resamples)[:, None]
    counts: FloatArray = np.bincount(drawn.ravel(), minlength=resamples * size).reshape(resamples, size).astype(float)
    return counts


def trimmed_means(values: FloatArray, weights: FloatArray, share: float) -> FloatArray:
    """Return the means (B,) of weighted data without a share of the weight at either end.

    Whole numbers as weights count repetitions: the result is that of ``scipy.stats.trim_mean`` on the repeated data.

    Parameters
    ----------
    values
        (K,) in rising order.
    weights
        (B, K), none negative.
    share
        What is cut off at either end, in [0, 0.5); zero gives the mean.
    """
    reached = np.cumsum(weights, axis=1)
    total = weights.sum(axis=1, keepdims=True)
    cut = np.floor(share * total)
    np.clip(reached, cut, total - cut, out=reached)
    kept = np.diff(reached, axis=1, prepend=cut)
    with np.errstate(invalid="ignore"):
        means: FloatArray = kept @ values / (total - 2.0 * cut)[:, 0]
    return means


def interval(draws: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the ends of the percentile interval of the resamples (RESAMPLES, ...), undefined ones left out."""
    tail = 50.0 * (1.0 - CONFIDENCE)
    low, high = np.nanpercentile(draws, [tail, 100.0 - tail], axis=0)
    return low, high
