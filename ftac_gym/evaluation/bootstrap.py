"""Bootstrap of crossed data, training seeds by episodes, as counts: how often a resample draws each row and column.

Data are sorted once, a resample is a row of weights on them, and a trimmed mean is a sum over cumulative weights. The
first row of all counts is the sample itself, everything drawn once.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Literal

import numpy as np
import numpy.typing as npt

from ftac_gym.utils.parameters import FloatArray, require

RESAMPLES = 2000
CONFIDENCE = 0.95

_ROWS = 64
"""Resamples that are worked on at a time."""

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
    is, for each contestant on its own: (1 + RESAMPLES, seeds, episodes), or (1 + RESAMPLES, seeds, 1) if it is as often
    in all episodes. They cannot be written to: the same are returned for other data of the same size.

    Raises
    ------
    ValueError
        If the levels are unknown.
    """
    require(levels in ("both", "seeds"), "levels", "must be 'both' or 'seeds'", levels)
    return _drawn(seed, levels, data[0].shape[1], tuple(map(len, data)))


@lru_cache(maxsize=8)
def _drawn(seed: int, levels: Levels, size: int, runs: tuple[int, ...]) -> tuple[FloatArray, list[FloatArray]]:
    random = np.random.default_rng(seed)
    strata = size if levels == "seeds" else 1
    episodes = np.ones((1 + RESAMPLES, size))
    if levels == "both":
        episodes[1:] = _counts(random, RESAMPLES, size)
    seeds = []
    for count in runs:
        counts = np.ones((1 + RESAMPLES, count, strata))
        drawn = _counts(random, RESAMPLES * strata, count)
        counts[1:] = drawn.reshape(RESAMPLES, strata, count).swapaxes(1, 2)
        seeds.append(counts)
    for item in (episodes, *seeds):
        item.flags.writeable = False
    return episodes, seeds


def weighted(values: FloatArray, seeds: FloatArray, episodes: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the known values (K,) in rising order and their weights (B, K): how often seed and episode are drawn."""
    row, column = np.nonzero(~np.isnan(values))
    order = np.argsort(values[row, column], kind="stable")
    row, column = row[order], column[order]
    weights = np.take(episodes, column, axis=1)
    if len(values) > 1:
        weights *= np.take(seeds[:, :, 0], row, axis=1) if seeds.shape[2] == 1 else seeds[:, row, column]
    return values[row, column], weights


def means(values: FloatArray, seeds: FloatArray, episodes: FloatArray) -> FloatArray:
    """Return the means (B,) of the known among values (seeds, episodes) in resamples: how often each one is drawn."""
    there = ~np.isnan(values)
    parts = np.where(there, values, 0.0), there.astype(float)
    if seeds.shape[2] == 1:
        total, count = (((episodes @ item.T) * seeds[:, :, 0]).sum(axis=1) for item in parts)
    else:
        total, count = ((episodes * over_seeds(item, seeds)).sum(axis=1) for item in parts)
    with np.errstate(invalid="ignore"):
        found: FloatArray = total / count
    return found


def over_seeds(values: FloatArray, seeds: FloatArray) -> FloatArray:
    """Return the sum over seeds of values (seeds, episodes) as often as they are drawn, (B, episodes)."""
    if seeds.shape[2] == 1:
        total: FloatArray = seeds[:, :, 0] @ values
    else:
        total = np.einsum("bsn,sn->bn", seeds, values)
    return total


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
    found = np.empty(len(weights))
    # Some rows at a time: what is in hand stays in the processor's cache.
    for start in range(0, len(weights), _ROWS):
        part = slice(start, start + _ROWS)
        reached = np.cumsum(weights[part], axis=1)
        total = weights[part].sum(axis=1, keepdims=True)
        cut = np.floor(share * total)
        np.clip(reached, cut, total - cut, out=reached)
        # The sum of kept weights times values, by parts.
        kept = total[:, 0] - cut[:, 0], cut[:, 0]
        summed = reached[:, :-1] @ -np.diff(values) + kept[0] * values[-1] - kept[1] * values[0] if values.size else 0.0
        with np.errstate(invalid="ignore"):
            found[part] = summed / (kept[0] - kept[1])
    return found


def interval(draws: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the ends of the percentile interval of the resamples (RESAMPLES, ...), undefined ones left out."""
    tail = 50.0 * (1.0 - CONFIDENCE)
    low, high = np.nanpercentile(draws, [tail, 100.0 - tail], axis=0)
    return low, high
