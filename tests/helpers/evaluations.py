"""Evaluations without flights."""

import numpy as np

from ftac_gym.evaluation import Evaluation
from ftac_gym.evaluation.metrics import Recoveries
from ftac_gym.faults import FaultKind

KINDS = (FaultKind.BIAS, FaultKind.OUTAGE)


def recoveries(time, recovered=True):
    """Return recoveries from one fault of each episode at 10 s, of two kinds in turn; a NaN of (N,) is no fault."""
    times = np.asarray(time, dtype=float)[:, None]
    there = ~np.isnan(times)
    kinds = np.resize([int(kind) for kind in KINDS], len(times))[:, None]
    seen = np.broadcast_to(np.reshape(recovered, (-1, 1)), times.shape) & there
    onset = np.where(there, 10.0, np.nan)
    return Recoveries(np.where(there, kinds, 0), onset, times, seen, np.where(there, 5.0, np.nan))


def evaluation(policy, metrics, attitude_error, times=None):
    """Return an evaluation with recoveries after some times (N,), at once if none are given."""
    count = np.shape(attitude_error)[1]
    found = recoveries(np.zeros(count) if times is None else times)
    error = np.asarray(attitude_error, dtype=np.float32)
    return Evaluation(policy, metrics, error, np.zeros((len(error), count), dtype=np.float32), found)
