"""Can the remaining wheels do the task at all? A label per episode, so that impossible draws count against nobody.

The rule looks at the wheels as they are in the worst moment of each fault, and is the same for every policy:

1. Torque. A wheel that still obeys offers its effectiveness times its torque limit either way; the uncommanded torque
   (bias, hard-over) of the others and the largest disturbance must lie inside the torque envelope of what is offered,
   scaled down to leave ``TORQUE_RESERVE`` of it for control.
2. Momentum. A wheel that runs away ends at its momentum limit, and what it pours into the body must lie inside the
   momentum envelope of the wheels that obey.

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
from ftac_gym.faults.table import FaultKind
from ftac_gym.parameters import FloatArray
from ftac_gym.spacecraft import WheelArray

BoolArray = npt.NDArray[np.bool_]

UNLIMITED = 1e12
"""Stands for the torque or momentum of a wheel without a limit: infinite times zero would be undefined."""

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


def inside_envelope(point: FloatArray, margin: FloatArray, axes: FloatArray, reach: FloatArray) -> BoolArray:
    """Tell whether boxes of vectors lie inside the zonotope of the wheels.

    Parameters
    ----------
    point
        (N, 3) centre of the box: a torque [N m] or a momentum [N m s].
    margin
        (N, 3) half-widths of the box.
    axes
        (3, m) wheel axes.
    reach
        (N, m) what each wheel can give either way, same unit as ``point``.

    Returns
    -------
    Array (N,) of booleans; False where the wheels that can give anything do not span space.
    """
    normals = envelope_normals(axes)
    support = np.minimum(reach, UNLIMITED) @ np.abs(axes.T @ normals.T)
    # The corner of the box that is farthest along a normal, whichever it is.
    farthest = np.abs(point @ normals.T) + margin @ np.abs(normals.T)
    gram = np.einsum("nj,ij,kj->nik", (reach > 0.0).astype(float), axes, axes)
    inside: BoolArray = np.all(farthest <= support, axis=1) & (np.linalg.eigvalsh(gram)[:, 0] > 1e-9)
    return inside


def label(faults: np.ndarray, wheels: WheelArray, largest_disturbance: FloatArray, duration: float) -> np.ndarray:
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
    ramped = faults["bias"] + faults["bias_slope"] * length
    bias = np.where(np.abs(ramped) > np.abs(faults["bias"]), ramped, faults["bias"])
    bias = np.where(acting, bias + np.where(bias < 0.0, -swing, swing), 0.0).sum(axis=2)

    axes = wheels.axis_matrix
    obeys = effectiveness > 0.0
    offered = (1.0 - TORQUE_RESERVE) * effectiveness * np.minimum(wheels.torque_limits, UNLIMITED)
    controllable = inside_envelope(bias @ axes.T, largest_disturbance, axes, offered)

    runs_away = (acting & (faults["kind"] == FaultKind.HARD_OVER)).any(axis=2)
    poured = np.minimum(np.abs(bias) * length.max(axis=2), wheels.momentum_limits)
    poured = np.where(runs_away, np.sign(bias) * poured, 0.0)
    storable = np.where(obeys, wheels.momentum_limits, 0.0)
    return controllable & inside_envelope(poured @ axes.T, np.zeros((1, 3)), axes, storable)
