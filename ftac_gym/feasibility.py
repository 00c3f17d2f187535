"""Can the remaining wheels surely do the task? A label per episode, so that impossible draws count against nobody.

The label is careful: an episode without it may still be flown by luck, when faults do not act together or end in time.
The rule looks at the wheels as they are in the worst moment of each fault, and is the same for every policy:

1. Torque. A wheel that still obeys offers its effectiveness times its torque limit either way; any combination of the
   uncommanded torques (bias, hard-over) and of the disturbance must lie inside the torque envelope of what is offered,
   scaled down to leave ``TORQUE_RESERVE`` of it for control.
2. Momentum. A wheel that no longer obeys but has a torque of its own ends at its momentum limit at the latest; what it
   pours into the body must lie inside the momentum envelope of the wheels that obey.

Both envelopes are zonotopes, sum_j [-r_j, r_j] D[:, j], and a torque t lies inside one exactly if
|n.t| <= sum_j r_j |n.D[:, j]| for the normal n of every pair of wheel axes. A locked wheel holds a torque that the
policy chose, which no label can know; it is counted as an outage. Saturation of a healthy wheel within the episode and
the time that the slew takes are not looked at.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np
import numpy.typing as npt

from ftac_gym.attitude import cross
from ftac_gym.parameters import FloatArray
from ftac_gym.spacecraft import WheelArray

BoolArray = npt.NDArray[np.bool_]

UNLIMITED = 1e12
"""Stands for the torque or momentum of a wheel without a limit: infinite times zero would be undefined."""

ROUNDING = 1e-9
"""Relative tolerance: a load exactly on the envelope is inside."""

TORQUE_RESERVE = 0.2
"""Share of the torque envelope that must stay free for control."""


def envelope_normals(axes: FloatArray) -> FloatArray:
    """Return the unit normals of the facets of a wheel array's envelope.

    Parameters
    ----------
    axes
        (3, m) wheel axes.

    Returns
    -------
    Array (facets, 3), one row for each pair of axes that are not parallel.
    """
    first, second = np.array(list(combinations(range(axes.shape[1]), 2)), dtype=int).reshape(-1, 2).T
    normals = cross(axes.T[first], axes.T[second])
    lengths = np.linalg.norm(normals, axis=1)
    distinct = lengths > 1e-9
    units: FloatArray = normals[distinct] / lengths[distinct, None]
    return units


def inside_envelope(
    point: FloatArray, margin: FloatArray, axes: FloatArray, reach: FloatArray, wheel_margin: FloatArray | float = 0.0
) -> BoolArray:
    """Tell whether sets of vectors lie inside the zonotope of the wheels.

    A set is a point, give or take a box in body axes and an interval along each wheel axis.

    Parameters
    ----------
    point
        (N, 3) centre of the set: a torque [N m] or a momentum [N m s].
    margin
        (N, 3) half-widths of the box.
    axes
        (3, m) wheel axes.
    reach
        (N, m) what each wheel can give either way, same unit as ``point``.
    wheel_margin
        (N, m) half-widths along the wheel axes.

    Returns
    -------
    Array (N,) of booleans; False where the wheels that can give anything do not span space.
    """
    normals = envelope_normals(axes)
    across = np.abs(axes.T @ normals.T)
    support = np.minimum(reach, UNLIMITED) @ across
    # The vector of the set that is farthest along a normal, whichever it is.
    farthest = np.abs(point @ normals.T) + margin @ np.abs(normals.T)
    if isinstance(wheel_margin, np.ndarray):
        farthest = farthest + wheel_margin @ across
    gram = np.einsum("nj,ij,kj->nik", (reach > 0.0).astype(float), axes, axes)
    held = np.all(farthest <= support * (1.0 + ROUNDING), axis=1)
    inside: BoolArray = held & (np.linalg.eigvalsh(gram)[:, 0] > 1e-9)
    return inside


def label(faults: np.ndarray, wheels: WheelArray, largest_disturbance: FloatArray, duration: float) -> BoolArray:
    """Label episodes as feasible.

    Parameters
    ----------
    faults
        FAULT records (N, m, layers).
    wheels
        The wheel array.
    largest_disturbance
        (N, 3) largest external torque on each axis [N m].
    duration
        Length of the episode [s]; later onsets do not count.

    Returns
    -------
    Array (N,) of booleans.
    """
    acting = faults["onset"] < duration
    weakest = faults["effectiveness"] - np.abs(faults["effectiveness_amplitude"])
    effectiveness = np.where(acting, np.maximum(weakest, 0.0), 1.0).prod(axis=2)
    length = np.clip(np.minimum(faults["recovery"], duration) - np.minimum(faults["onset"], duration), 0.0, None)
    swing = np.abs(faults["bias_amplitude"]) * length ** faults["bias_exponent"]
    first, last = faults["bias"], faults["bias"] + faults["bias_slope"] * length
    # Faults of one wheel or of several need not act at the same time: each is counted from nothing to its worst.
    highest = np.where(acting, np.maximum(np.maximum(first, last) + swing, 0.0), 0.0).sum(axis=2)
    lowest = np.where(acting, np.minimum(np.minimum(first, last) - swing, 0.0), 0.0).sum(axis=2)

    axes = wheels.axis_matrix
    obeys = effectiveness > 0.0
    offered = (1.0 - TORQUE_RESERVE) * effectiveness * np.minimum(wheels.torque_limits, UNLIMITED)
    load, half = 0.5 * (highest + lowest), 0.5 * (highest - lowest)
    controllable = inside_envelope(load @ axes.T, largest_disturbance, axes, offered, half)

    # A wheel that does not obey pours its uncommanded torque into the body until its momentum limit stops it.
    poured_up = np.where(obeys, 0.0, np.minimum(highest * length.max(axis=2), wheels.momentum_limits))
    poured_down = np.where(obeys, 0.0, np.maximum(lowest * length.max(axis=2), -wheels.momentum_limits))
    load, half = 0.5 * (poured_up + poured_down), 0.5 * (poured_up - poured_down)
    storable = np.where(obeys, wheels.momentum_limits, 0.0)
    return controllable & inside_envelope(load @ axes.T, np.zeros((1, 3)), axes, storable, half)
