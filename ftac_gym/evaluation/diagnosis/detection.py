"""Detection and isolation of each fault, and false alarms, from the alarms along a flight."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ftac_gym.evaluation.diagnosis.alarms import Alarms, BoolArray
from ftac_gym.task.episodes import Episodes
from ftac_gym.utils.parameters import FloatArray

NO_WHEEL = -1
"""Wheel that is named where none is."""

_TOLERANCE = 1e-9
"""Two times closer than this are the same time [s]."""

DETECTION = np.dtype(
    [
        ("episode", "i8"),
        ("kind", "i8"),
        ("wheel", "i8"),
        ("onset", "f8"),
        ("watched", "f8"),
        ("delay", "f8"),
        ("named", "i8"),
    ]
)
"""One fault of a wheel.

``watched`` is the time from its onset to its end or that of the flight [s], and ``delay`` that to the first new alarm
[s], NaN for a missed fault. ``named`` is the wheel that the alarms name.
"""

Detections = npt.NDArray[np.void]


def detections(alarms: Alarms, episodes: Episodes, control_period: float, grace: float) -> Detections:
    """Return the detection of each fault of a wheel that acts before the last command of its flight.

    An alarm counts from the onset on, if it is new: one that stands already announces nothing until it ends. Alarms of
    a wheel with another fault are left out while that one acts, and for the grace period after it. The wheel that is
    named is the one whose alarms have the largest sum of weights while the fault acts; none if two have the same.

    Parameters
    ----------
    alarms
        Alarms at the start of each control period.
    episodes
        The episodes, with the faults.
    control_period, grace
        [s].

    Returns
    -------
    DETECTION records (F,), by episode, wheel and layer.
    """
    steps = len(alarms.body)
    spans = _rows(episodes.faults, steps, control_period)
    ends = _rows(episodes.faults, steps, control_period, grace)[1]
    found = []
    for n, wheel, layer in zip(*np.nonzero(episodes.faults["kind"] > 0), strict=True):
        first, last = spans[0][n, wheel, layer], spans[1][n, wheel, layer]
        if first >= last:
            continue
        raised = np.column_stack([alarms.wheels[:last, n], alarms.body[:last, n]])
        for other, below in zip(*np.nonzero(episodes.faults["kind"][n] > 0), strict=True):
            if other != wheel:
                raised[spans[0][n, other, below] : ends[n, other, below], other] = 0.0
        fresh = _new(raised, first)
        fault = episodes.faults[n, wheel, layer]
        watched = min(fault["recovery"], steps * control_period) - fault["onset"]
        seen = np.flatnonzero((fresh > 0.0).any(axis=1))
        delay = (first + seen[0]) * control_period - fault["onset"] if seen.size else np.nan
        named = _largest(fresh[:, :-1].sum(axis=0))
        found.append((n, fault["kind"], wheel, fault["onset"], watched, max(delay, 0.0), named))
    return np.array(found, dtype=DETECTION)


def false_alarms(
    alarms: Alarms, episodes: Episodes, control_period: float, grace: float
) -> tuple[npt.NDArray[np.int64], FloatArray, FloatArray]:
    """Return the number of false alarms of each episode (N,), its time without faults and that in alarm [s].

    A false alarm begins, or stands at the start of a time without faults: before the first fault, and after the grace
    period of those that end. Faults of sensors are faults here too. One that lasts counts once, and its time shows.
    """
    steps = len(alarms.body)
    healthy = np.ones(alarms.body.shape, dtype=np.bool_)
    index = np.arange(steps)[:, None]
    for table in (episodes.faults.reshape(len(episodes), -1), episodes.sensor_faults):
        first, last = _rows(table, steps, control_period, grace)
        for slot in range(table.shape[1]):
            healthy &= (index < first[:, slot]) | (index >= last[:, slot])
    wrong = healthy & alarms.any
    begun = wrong & ~np.concatenate([np.zeros_like(wrong[:1]), wrong[:-1]])
    return begun.sum(axis=0), healthy.sum(axis=0) * control_period, wrong.sum(axis=0) * control_period


def _rows(
    records: npt.NDArray[np.void], steps: int, control_period: float, grace: float = 0.0
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Return the first control period that starts with each fault, and the first after its end and a time [s]."""
    there = records["kind"] > 0
    found = []
    for times in (np.where(there, records["onset"], np.inf), np.where(there, records["recovery"] + grace, np.inf)):
        rows = np.ceil((times - _TOLERANCE) / control_period)
        found.append(np.clip(rows, 0, steps).astype(np.int64))
    return found[0], found[1]


def _new(raised: FloatArray, first: int) -> FloatArray:
    """Return alarms (T, channels) from a row on, without those that stand there since before."""
    later = raised[first:]
    if not first:
        return later
    ended: BoolArray = np.logical_or.accumulate(later == 0.0, axis=0)
    return np.where(ended | (raised[first - 1] == 0.0), later, 0.0)


def _largest(weights: FloatArray) -> int:
    """Return the wheel with the largest weight; none without an alarm, or if two have the same."""
    best = int(np.argmax(weights))
    alone = np.count_nonzero(weights == weights[best]) == 1
    return best if alone and weights[best] > 0.0 else NO_WHEEL
