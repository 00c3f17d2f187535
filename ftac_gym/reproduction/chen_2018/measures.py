"""What the claims of Chen, Chen, He and Sun 2018 are judged by."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from ftac_gym.baselines.components.error_transformation import ErrorTransformation
from ftac_gym.reproduction.chen_2018.plans import bound
from ftac_gym.reproduction.flight import Flight, from_when
from ftac_gym.reproduction.variations import seconds
from ftac_gym.task.prescribed_bound import PrescribedBound
from ftac_gym.utils.parameters import FloatArray

ACCURACY = 1e-3
"""What every |sigma_i| shall come below."""


def changed(**changes: Any) -> PrescribedBound:
    """Return the example's bounds with other fields."""
    return replace(bound(), **changes)


def least(flight: Flight, within: PrescribedBound | None = None) -> float:
    """Return the least margin in units of the bounds' distance; positive where the bounds are kept."""
    return float(flight.margin(within or bound()).min())


def margin(flight: Flight, within: PrescribedBound | None = None) -> str:
    """Say how large the margin is where it is least, and when that is."""
    share = flight.margin(within or bound())
    at = int(np.argmin(share))
    return f"{share[at]:+.2g} at {flight.time[at]:.1f} s"


def outside(flight: Flight, within: PrescribedBound | None = None) -> str:
    """Say from when until when the bounds are not kept."""
    broken = np.flatnonzero(flight.margin(within or bound()) <= 0.0)
    if len(broken) == 0:
        return "-"
    last = "the end" if broken[-1] == len(flight.time) - 1 else f"{flight.time[broken[-1]]:.1f} s"
    return f"{flight.time[broken[0]]:.1f} s to {last}"


def transformed(flight: Flight, within: PrescribedBound | None = None) -> FloatArray:
    """Return |epsilon| (T + 1,), outside the bounds along its tangent, as M1 does."""
    error = ErrorTransformation(within or bound(), 1e-5)(flight.attitude[:, 0], flight.time).error
    size: FloatArray = np.linalg.norm(error, axis=1)
    return size


def accurate(flight: Flight) -> float:
    """Return from when on every |sigma_i| stays below 1e-3 [s]; infinity if they do not."""
    return from_when(flight.time, np.abs(flight.attitude[:, 0]).max(axis=1), ACCURACY)


def overshoot(flight: Flight) -> FloatArray:
    """Return how far each sigma_i goes to the other side of zero, (3,)."""
    sigma = flight.attitude[:, 0]
    across: FloatArray = np.maximum(0.0, (-sigma * np.sign(sigma[0])).max(axis=0))
    return across


def shrinking(flight: Flight, start: float, end: float) -> float:
    """Return the mean of -d ln|sigma| / dt between two shares of the flight [1/s]."""
    at = [round(share * (len(flight.time) - 1)) for share in (start, end)]
    size = np.maximum(np.linalg.norm(flight.attitude[at, 0], axis=1), 1e-300)
    return float(np.log(size[0] / size[1]) / (flight.time[at[1]] - flight.time[at[0]]))


def torque_size(flight: Flight) -> float:
    """Return the root of the mean square of the torques that the wheels apply [N m]."""
    return float(np.sqrt(flight.energy() / (flight.time[-1] * flight.command.shape[2])))


def weight_bound(flight: Flight) -> FloatArray:
    """Return theta (T + 1,) of a flight that kept it."""
    theta: FloatArray = flight.memory["weight_bound"][:, 0, 0]
    return theta


def theorem_radius() -> float:
    """Return how large the small region of Theorem 6 is at least, with Table 1.

    mu and Dm are taken as zero, theta as zero, and b as one, which is the largest that it may be.
    """
    k1, k2, l1, tau1, tau2, h, m1, power = 0.1, 0.8, 0.01, 0.01, 0.5, 0.5, 0.001, 0.3
    half = 0.5 * (power + 1.0)
    left = 1.5 * h**2 + 0.5 * l1 + 0.25
    linear = min(2.0 * k1 - l1, 2.0 * k2, 0.5 * m1)
    powered = min(2.0**half * tau1, 2.0**half * tau2, m1**half)
    return float(max(np.sqrt(2.0 * left / linear), np.sqrt(2.0 * (left / powered) ** (1.0 / half))))


def when(values: Mapping[str, float]) -> str:
    """Return times by name in words."""
    return ", ".join(f"{name} {seconds(value)}" for name, value in values.items())
