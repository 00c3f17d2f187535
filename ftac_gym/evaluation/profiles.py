"""Curves with bands: performance profiles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ftac_gym.evaluation.bootstrap import Levels, aligned, bootstrap
from ftac_gym.utils.parameters import FloatArray


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
        See :func:`~ftac_gym.evaluation.statistics.estimate`.

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
