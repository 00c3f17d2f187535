"""Percentile bootstrap of crossed data, training seeds by episodes.

For a single run without seeds the resamples and the interval are those of ``scipy.stats.bootstrap``.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any, Literal

import numpy as np
import numpy.typing as npt
from scipy import stats

from ftac_gym.utils.parameters import FloatArray, require

RESAMPLES = 2000
CONFIDENCE = 0.95

Levels = Literal["both", "seeds"]
"""Parts that are drawn anew: seeds and episodes, or seeds alone, in every episode for itself."""

_BLOCK = 200
"""Resamples that are evaluated at a time: they bound the memory."""

_Indices = npt.NDArray[np.int64]


def aligned(*values: npt.ArrayLike) -> list[FloatArray]:
    """Return data as (seeds, episodes), reduced to the episodes in which every policy has a value.

    Parameters
    ----------
    *values
        (seeds, episodes) or (episodes,), one per policy; NaN is no value.

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


def bootstrap(
    data: Sequence[FloatArray], measure: Callable[..., Any], seed: int, levels: Levels
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return a measure of data with the ends of its percentile interval.

    Episodes are drawn for all policies together, the seeds of each policy on their own.

    Parameters
    ----------
    data
        (seeds, episodes) of each policy, as :func:`aligned` returns them, with at least one episode.
    measure
        Function of resamples (B, seeds, episodes), one array per policy. It returns (B,) or (B, K); undefined values
        are NaN.
    seed
        Seed of the resampling.
    levels
        Parts that are drawn anew.

    Returns
    -------
    Measure of the data and both ends of its interval, each () or (K,).

    Raises
    ------
    ValueError
        If the levels are unknown.
    """
    point, drawn = resampled(data, measure, seed, levels)
    return point, *ends(drawn, point.shape)


def resampled(
    data: Sequence[FloatArray], measure: Callable[..., Any], seed: int, levels: Levels
) -> tuple[FloatArray, FloatArray]:
    """Return a measure of data, () or (K,), and of all resamples, (B,) or (B, K); see :func:`bootstrap`.

    Raises
    ------
    ValueError
        If the levels are unknown.
    """
    require(levels in ("both", "seeds"), "levels", "must be 'both' or 'seeds'", levels)
    episodes, seeds = _draw(seed, levels, data[0].shape[1], tuple(map(len, data)))
    blocks = []
    for start in range(0, RESAMPLES, _BLOCK):
        part = slice(start, start + _BLOCK)
        blocks.append(measure(*(item[rows[part], episodes[part]] for item, rows in zip(data, seeds, strict=True))))
    return np.asarray(measure(*(item[None] for item in data)))[0], np.concatenate(blocks)


def ends(drawn: FloatArray, shape: tuple[int, ...] = ()) -> tuple[FloatArray, FloatArray]:
    """Return both ends of the percentile interval of resamples (B, ...), each of a shape; NaN is left out."""
    tail = (1.0 - CONFIDENCE) / 2.0
    found = stats.quantile(
        drawn.reshape(RESAMPLES, -1), np.array([[tail], [1.0 - tail]]), axis=0, nan_policy="omit"
    ).reshape(2, *shape)
    # Interpolation between equal values can leave them by a rounding error.
    low, high = np.clip(found, np.fmin.reduce(drawn), np.fmax.reduce(drawn))
    return low, high


def draw_counts(
    seed: int, size: int, runs: tuple[int, ...]
) -> tuple[npt.NDArray[np.int64], list[npt.NDArray[np.int64]]]:
    """Return how often each resample has each episode, (B, size), and each seed of each policy, (B, seeds).

    The resamples are those of :func:`bootstrap` with both levels.
    """
    episodes, seeds = _draw(seed, "both", size, runs)
    return _counts(episodes[:, 0], size), [
        _counts(item[:, :, 0], count) for item, count in zip(seeds, runs, strict=True)
    ]


def _counts(indices: _Indices, size: int) -> npt.NDArray[np.int64]:
    """Return how often each row (B, K) has each of the numbers below a size, (B, size)."""
    rows = np.arange(len(indices))[:, None] * size
    return np.bincount((indices + rows).ravel(), minlength=len(indices) * size).reshape(len(indices), size)


@lru_cache(maxsize=8)
def _draw(seed: int, levels: Levels, size: int, runs: tuple[int, ...]) -> tuple[_Indices, list[_Indices]]:
    """Return indices of drawn episodes (B, 1, episodes) and, for each policy, of seeds (B, seeds, 1 or episodes)."""
    random = np.random.default_rng(seed)
    if levels == "both":
        episodes = random.integers(0, size, (RESAMPLES, 1, size))
        return episodes, [random.integers(0, count, (RESAMPLES, count, 1)) for count in runs]
    seeds = [random.integers(0, count, (RESAMPLES, size, count)).swapaxes(1, 2) for count in runs]
    return np.broadcast_to(np.arange(size), (RESAMPLES, 1, size)), seeds
