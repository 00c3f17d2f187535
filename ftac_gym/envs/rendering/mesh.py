"""Shape of the spacecraft: a box, two panels that bend, and the wheels."""

import numpy as np

from ftac_gym.spacecraft.appendages import FlexibleAppendages
from ftac_gym.utils.directions import circle
from ftac_gym.utils.parameters import FloatArray

HALF = np.array([0.17, 0.17, 0.22])
"""Half-sizes of the body; the sphere of directions has radius 1."""

REACH, WIDTH, SEGMENTS = 0.82, 0.15, 5
"""Length of a panel along the first body axis, its half-width, and the number of its parts."""

EXAGGERATION = 30.0
"""Factor on the bending of the panels."""

_CORNERS = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
_SIDES = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))


def body_faces() -> FloatArray:
    """Return the six sides of the body (6, 4, 3), corners counted counter-clockwise from outside, body axes."""
    corners = _CORNERS * HALF
    return np.stack([corners[list(side)] for side in _SIDES])


def panel_turn(appendages: FlexibleAppendages | None, displacement: FloatArray) -> FloatArray:
    """Return the angle (3,) [rad] about each body axis by which the panels lead the body.

    It is that of a rigid panel with the same momentum: about axis i, sum_k delta_ki eta_k over the inertia
    (delta' delta)_ii of the modes.

    Parameters
    ----------
    appendages
        The appendages; None for a rigid spacecraft.
    displacement
        (k,) displacement of the modes [kg^1/2 m].
    """
    if appendages is None:
        return np.zeros(3)
    carried = np.diag(appendages.carried_inertia)
    turn: FloatArray = appendages.coupling_matrix.T @ displacement / np.maximum(carried, 1e-9)
    return turn


def panel_faces(turn: FloatArray) -> FloatArray:
    """Return the parts of both panels (2 * SEGMENTS, 4, 3), body axes, bent EXAGGERATION times a turn (3,).

    A turn about the second or third axis bends them like a beam that is clamped to the body; one about the first twists
    them.
    """
    share = np.linspace(0.0, 1.0, SEGMENTS + 1)
    angle = EXAGGERATION * turn
    edges = np.empty((2, 2, SEGMENTS + 1, 3))
    for side, sign in enumerate((-1.0, 1.0)):
        twist = angle[0] * share
        along = sign * (HALF[0] + REACH * share)
        for edge, across in enumerate((-WIDTH, WIDTH)):
            # (0, angle_y, angle_z) x (x, 0, 0), growing with the square of the way along the panel.
            edges[side, edge, :, 0] = along
            edges[side, edge, :, 1] = across * np.cos(twist) + angle[2] * sign * REACH * share**2
            edges[side, edge, :, 2] = across * np.sin(twist) - angle[1] * sign * REACH * share**2
    faces = [
        [edges[side, 0, part], edges[side, 1, part], edges[side, 1, part + 1], edges[side, 0, part + 1]]
        for side in range(2)
        for part in range(SEGMENTS)
    ]
    return np.array(faces)


def wheel_faces(axes: FloatArray) -> FloatArray:
    """Return a disc (12 corners) for each wheel, (m, 12, 3) body axes, at the point at which its axis leaves the body.

    Parameters
    ----------
    axes
        (3, m) wheel axes.
    """
    discs = np.empty((axes.shape[1], 12, 3))
    for wheel, axis in enumerate(axes.T):
        center = axis * (float(np.min(HALF / np.maximum(np.abs(axis), 1e-9))) + 0.04)
        discs[wheel] = center + 0.075 * circle(axis, 13)[:-1]
    return discs
