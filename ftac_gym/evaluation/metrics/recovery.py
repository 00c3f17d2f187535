"""Recovery from each fault of an episode.

A fault counts if the spacecraft was on target at some moment of the second before its onset. The faults must not change
again for at least a second. Faults that act from the start do not count. Faults with the same onset are one.

The *next change* is the onset of a later fault, or the end of another one; it ends the view on a fault. A later
disaster thus neither lengthens nor shortens an earlier recovery. The end of the fault itself does not end the view.

An *excursion* is a loss of the target for a second or more, until the spacecraft stays on target for a second. A
shorter loss is taken for noise. The recovery time lasts from the onset to the end of the first excursion, and is zero
without one. It is *censored* if the excursion does not end before the next change or the end of the episode: the
recovery takes longer than that. A loss of the target that has just begun there counts as such an excursion. Shares and
medians of such times are in :mod:`ftac_gym.evaluation.recovery`.

===================== ==================================================================================================
``peak_after_fault``  largest pointing error from the onset of a fault to the next change, of all faults that count
                      the largest; NaN where none counts
===================== ==================================================================================================
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from ftac_gym.evaluation.metrics.metric import Metric
from ftac_gym.task.episodes import Episodes
from ftac_gym.utils.parameters import FloatArray

if TYPE_CHECKING:
    from ftac_gym.evaluation.metrics.history import Rollout

METRICS = (Metric("peak_after_fault", "deg", partial=True),)

SUSTAINED = 1.0
"""Time for which a spacecraft is on target again, or has lost it [s]."""


@dataclass(frozen=True, eq=False)
class Recoveries:
    """Recoveries from the faults of N episodes, with a column for each of the F faults that an episode can have.

    The faults stand in the order of their onsets.

    Attributes
    ----------
    kind
        (N, F) number of the fault kind; 0 where there is no fault that counts.
    onset
        (N, F) onset [s]; NaN where there is no fault that counts, as in the arrays below.
    time
        (N, F) recovery time [s], or the time without recovery until the view ends.
    recovered
        (N, F) whether the recovery was seen; False where the time is censored, and where no fault counts.
    peak
        (N, F) largest pointing error from the onset to the next change [deg].
    """

    kind: npt.NDArray[np.int64]
    onset: FloatArray
    time: FloatArray
    recovered: npt.NDArray[np.bool_]
    peak: FloatArray

    @property
    def counted(self) -> npt.NDArray[np.bool_]:
        """(N, F) whether there is a fault that counts."""
        return self.kind > 0


def recoveries(
    on_target: npt.NDArray[np.bool_], attitude_error: FloatArray, episodes: Episodes, control_period: float
) -> Recoveries:
    """Find the recovery from each fault.

    Parameters
    ----------
    on_target
        (T + 1, N) whether each spacecraft is on target.
    attitude_error
        (T + 1, N) pointing error [deg].
    episodes
        The N episodes.
    control_period
        Time between samples [s].
    """
    kind, onset, change = fault_changes(episodes)
    duration = (len(on_target) - 1) * control_period
    least = max(int(np.ceil(SUSTAINED / control_period - 1e-9)), 1)
    found = Recoveries(
        kind=np.zeros(kind.shape, dtype=np.int64),
        onset=np.full(kind.shape, np.nan),
        time=np.full(kind.shape, np.nan),
        recovered=np.zeros(kind.shape, dtype=np.bool_),
        peak=np.full(kind.shape, np.nan),
    )
    for episode, fault in np.argwhere((kind > 0) & (onset > 0.0) & (onset < duration)):
        start, end = onset[episode, fault], min(change[episode, fault], duration)
        before, first = int(np.floor(start / control_period + 1e-9)), int(np.ceil(start / control_period - 1e-9))
        last = len(on_target) if end == duration else int(np.ceil(end / control_period - 1e-9))
        held = on_target[:, episode]
        if last - first < least or not held[max(before + 1 - least, 0) : before + 1].any():
            continue
        back = first_return(held[first:last], least)
        place = episode, fault
        found.kind[place], found.onset[place], found.recovered[place] = kind[place], start, back is not None
        returned = (first + back) * control_period if back else start
        # Rounding must not take a recovery beyond a limit.
        found.time[place] = round((end if back is None else returned) - start, 9)
        found.peak[place] = attitude_error[first:last, episode].max()
    return found


def fault_changes(episodes: Episodes) -> tuple[npt.NDArray[np.int64], FloatArray, FloatArray]:
    """Return kinds, onsets and next changes of the faults of N episodes, each (N, F), in the order of the onsets.

    Kind 0 stands for no fault, and for one with the same onset as the fault before it. An onset without a fault, and a
    change that does not come, are infinite.
    """
    count = len(episodes)
    tables = [table.reshape(count, math.prod(table.shape[1:])) for table in (episodes.faults, episodes.sensor_faults)]
    kind, onset, recovery, fall = (
        np.concatenate([table[name] for table in tables], axis=1) for name in ("kind", "onset", "recovery", "fall")
    )
    onset = np.where(kind > 0, onset, np.inf)
    ends = np.where(kind > 0, recovery - fall, np.inf)
    order = np.argsort(onset, axis=1, kind="stable")
    kind, onset, ends = (np.take_along_axis(values, order, axis=1) for values in (kind, onset, ends))
    kind[:, 1:][onset[:, 1:] == onset[:, :-1]] = 0
    later = onset[:, None, :] > onset[:, :, None]
    ended = (ends[:, None, :] > onset[:, :, None]) & ~np.eye(onset.shape[1], dtype=np.bool_)
    changes = np.minimum(
        np.where(later, onset[:, None, :], np.inf).min(axis=2, initial=np.inf),
        np.where(ended, ends[:, None, :], np.inf).min(axis=2, initial=np.inf),
    )
    return kind, onset, changes


def first_return(on_target: npt.NDArray[np.bool_], least: int) -> int | None:
    """Return the sample at which the first excursion ends: 0 if there is none, None if it does not end.

    Parameters
    ----------
    on_target
        (K,) whether the spacecraft is on target.
    least
        Samples of an excursion, and of a return.
    """
    total = np.concatenate([[0], np.cumsum(on_target)])
    held = np.flatnonzero(total[least:] - total[:-least] == least)
    lost = np.flatnonzero(~on_target)
    start = 0
    while (next_lost := np.searchsorted(lost, start)) < len(lost):
        begin = int(lost[next_lost])
        next_held = np.searchsorted(held, begin)
        if next_held == len(held):
            return None
        start = int(held[next_held])
        if start - begin >= least:
            return start
    return 0


def measure(history: Rollout) -> dict[str, FloatArray]:
    """Return the metrics, arrays (N,) by name."""
    return {"peak_after_fault": _largest(history.recoveries().peak)}


def _largest(values: FloatArray) -> FloatArray:
    """Return the largest of each row (N, F) without NaN; NaN where there is none."""
    largest = np.where(np.isnan(values), -np.inf, values).max(axis=1, initial=-np.inf)
    return np.where(np.isinf(largest), np.nan, largest)
