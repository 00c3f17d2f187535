"""Measures behind the claims of Chen, Chen, He and Sun 2018."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ftac_gym.baselines.components.error_transformation import ErrorTransformation
from ftac_gym.reproduction.chen_2018.plans import START, bound
from ftac_gym.reproduction.recordings import Recording, below_from
from ftac_gym.task.prescribed_bound import PrescribedBound
from ftac_gym.utils.parameters import FloatArray

ACCURACY = 1e-3
"""Accuracy that the paper claims for every ``|sigma_i|``."""


def bound_of(recording: Recording) -> PrescribedBound:
    """Return the example's bounds with the changes that a plan makes to them."""
    gains = recording.plan.gains
    changed = replace(bound(), **gains.get("bound", {}))
    return changed.mirrored(recording.attitude[0, 0] * START < 0.0) if gains.get("mirror") else changed


def least(recording: Recording, within: PrescribedBound | None = None) -> float:
    """Return the least margin in units of the bounds' distance; positive where the bounds are kept."""
    return float(recording.margin(within or bound_of(recording)).min())


def margin(recording: Recording) -> str:
    """Return the least margin and its time as text."""
    share = recording.margin(bound_of(recording))
    at = int(np.argmin(share))
    return f"{share[at]:+.2g} at {recording.time[at]:.1f} s"


def outside(recording: Recording) -> str:
    """Return the first and last time outside the bounds as text."""
    broken = np.flatnonzero(recording.margin(bound_of(recording)) <= 0.0)
    if len(broken) == 0:
        return "-"
    last = "the end" if broken[-1] == len(recording.time) - 1 else f"{recording.time[broken[-1]]:.1f} s"
    return f"{recording.time[broken[0]]:.1f} s to {last}"


def transformed(recording: Recording) -> FloatArray:
    """Return ``|epsilon|`` (T + 1,); outside the bounds it continues along its tangent, as in M1."""
    error = ErrorTransformation(bound_of(recording), 1e-5)(recording.attitude[:, 0], recording.time).error
    return np.asarray(np.linalg.norm(error, axis=1))


def accurate(recording: Recording) -> float:
    """Return the time from which every ``|sigma_i|`` stays below 1e-3 [s]; infinity if never."""
    return below_from(recording.time, np.abs(recording.attitude[:, 0]).max(axis=1), ACCURACY)


def overshoot(recording: Recording) -> float:
    """Return the largest distance of a sigma_i to zero on the side opposite to its start."""
    sigma = recording.attitude[:, 0]
    return float(np.maximum(0.0, (-sigma * np.sign(sigma[0])).max(axis=0)).max())


def shrinking(recording: Recording, start: float, end: float) -> float:
    """Return the mean of -d ln|sigma| / dt between two shares of the flight [1/s]."""
    at = [round(share * (len(recording.time) - 1)) for share in (start, end)]
    size = np.maximum(np.linalg.norm(recording.attitude[at, 0], axis=1), 1e-300)
    return float(np.log(size[0] / size[1]) / (recording.time[at[1]] - recording.time[at[0]]))


def torque_size(recording: Recording) -> float:
    """Return the root mean square of the torques that the wheels apply [N m]."""
    return float(np.sqrt(recording.energy() / (recording.time[-1] * recording.command.shape[2])))


def weight_bound(recording: Recording) -> FloatArray:
    """Return theta (T + 1,) of a flight whose plan records it."""
    return np.asarray(recording.memory["weight_bound"][:, 0, 0])


def theorem_radius() -> float:
    """Return a lower bound of the radius of the small region of Theorem 6, with Table 1.

    mu, Dm and theta are taken as zero, and b as one, its largest value.
    """
    k1, k2, l1, tau1, tau2, h, m1, power = 0.1, 0.8, 0.01, 0.01, 0.5, 0.5, 0.001, 0.3
    half = 0.5 * (power + 1.0)
    left = 1.5 * h**2 + 0.5 * l1 + 0.25
    linear = min(2.0 * k1 - l1, 2.0 * k2, 0.5 * m1)
    powered = min(2.0**half * tau1, 2.0**half * tau2, m1**half)
    return float(max(np.sqrt(2.0 * left / linear), np.sqrt(2.0 * (left / powered) ** (1.0 / half))))
