"""Recovery from faults over many episodes, with censored times: Kaplan and Meier 1958 (J. Am. Stat. Assoc. 53).

The intervals draw episodes anew, and training seeds, with all their faults: faults of one episode belong together.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from ftac_gym.evaluation.bootstrap import draw_counts, ends
from ftac_gym.evaluation.intervals import Survival, survival
from ftac_gym.evaluation.metrics import Recoveries
from ftac_gym.evaluation.shares import effective_count, newcombe_ends, share_ends
from ftac_gym.evaluation.statistics import Estimate
from ftac_gym.utils.parameters import FloatArray

LIMIT = 10.0
"""Time within which tables ask for a recovery [s]."""

_Mask = npt.NDArray[np.bool_]


def recovery_survival(runs: Sequence[Recoveries], chosen: _Mask) -> Survival:
    """Return the Kaplan-Meier estimate of the recovery times of all seeds and of some of the episodes.

    Parameters
    ----------
    runs
        Recoveries of each training seed; one of a policy without seeds.
    chosen
        (N, F) or (N, 1): which faults or episodes count.
    """
    parts = [(item, item.counted & chosen) for item in runs]
    times, recovered = (
        np.concatenate([getattr(item, name)[mask] for item, mask in parts]) for name in ("time", "recovered")
    )
    return survival(times, recovered)


def recovered_within(runs: Sequence[Recoveries], chosen: _Mask, limit: float = LIMIT, seed: int = 0) -> Estimate:
    """Estimate the share of the faults that are recovered within a time.

    Parameters
    ----------
    runs
        Recoveries of each training seed; one of a policy without seeds.
    chosen
        (N,) which episodes count.
    limit
        The time [s].
    seed
        Seed of the resampling.

    Returns
    -------
    The estimate: ``count`` is the number of episodes with a fault, and ``total`` that of all faults over all seeds. Of
    these ``defined`` were recovered in view, or not recovered within the limit.
    """
    faults = _Faults(runs, chosen)
    count = len(np.unique(faults.episode))
    counts = count, int((faults.recovered | (faults.time >= limit)).sum()), len(faults.time)
    if not count:
        return Estimate(np.nan, np.nan, np.nan, *counts)
    episodes, (weights,) = draw_counts(seed, int(chosen.sum()), (len(runs),))
    drawn = faults.within(limit, weights, episodes)
    value = faults.within(limit, np.ones_like(weights[:1]), np.ones_like(episodes[:1]))[0]
    low, high = share_ends(value, effective_count(value * (1.0 - value), float(np.nanvar(drawn)), count))
    return Estimate(float(value), low, high, *counts)


def recovered_difference(
    first: Sequence[Recoveries], second: Sequence[Recoveries], chosen: _Mask, limit: float = LIMIT, seed: int = 0
) -> Estimate:
    """Estimate the difference of the shares of two policies over the same episodes.

    The policies are on target at the onset of different faults, so that the faults are no pairs; the episodes are.
    Where all resamples are equal, the interval is that of Newcombe for independent episodes.

    Parameters
    ----------
    first, second
        Recoveries of each training seed, in the same episodes.
    chosen, limit, seed
        See :func:`recovered_within`.
    """
    both = [_Faults(runs, chosen) for runs in (first, second)]
    if not all(len(item.time) for item in both):
        return Estimate(np.nan, np.nan, np.nan, 0, 0, 0)
    episodes, weights = draw_counts(seed, int(chosen.sum()), (len(first), len(second)))
    drawn = np.subtract(*(item.within(limit, own, episodes) for item, own in zip(both, weights, strict=True)))
    ones = np.ones_like(episodes[:1])
    values = [item.within(limit, np.ones_like(own[:1]), ones)[0] for item, own in zip(both, weights, strict=True)]
    count = len(np.intersect1d(*(item.episode for item in both)))
    counts = count, *(min(len(item.time) for item in both),) * 2
    low, high = map(float, ends(drawn))
    if low == high:
        low, high = newcombe_ends(values[0], values[1], min(len(np.unique(item.episode)) for item in both))
    return Estimate(float(values[0] - values[1]), low, high, *counts)


class _Faults:
    """Faults of all seeds in the chosen episodes, ordered by their times.

    Parameters
    ----------
    runs
        Recoveries of each seed.
    chosen
        (N,) which episodes count.
    """

    def __init__(self, runs: Sequence[Recoveries], chosen: _Mask) -> None:
        places = [np.argwhere(item.counted[chosen]) for item in runs]
        time, recovered = (
            np.concatenate([getattr(item, name)[chosen][item.counted[chosen]] for item in runs])
            for name in ("time", "recovered")
        )
        seed = np.repeat(np.arange(len(runs)), list(map(len, places)))
        # A recovery comes before a censored time of the same length.
        order = np.lexsort([~recovered, time])
        self.seed, self.episode = seed[order], np.concatenate(places)[order, 0]
        self.time, self.recovered = time[order], recovered[order]

    def within(self, limit: float, seeds: npt.NDArray[np.int64], episodes: npt.NDArray[np.int64]) -> FloatArray:
        """Return the share recovered within a time, (B,), for numbers of each seed (B, S) and each episode (B, N)."""
        shares = []
        for own, drawn in zip(np.array_split(seeds, 20), np.array_split(episodes, 20), strict=True):
            weight = own[:, self.seed] * drawn[:, self.episode]
            total = weight.sum(axis=1, keepdims=True)
            last = int(np.searchsorted(self.time, limit, side="right"))
            at_risk = total - np.cumsum(weight[:, :last], axis=1) + weight[:, :last]
            lost = np.where(self.recovered[:last], weight[:, :last], 0) / np.maximum(at_risk, 1)
            shares.append(np.where(total[:, 0] > 0, 1.0 - np.prod(1.0 - lost, axis=1), np.nan))
        return np.concatenate(shares)
