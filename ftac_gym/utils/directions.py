"""Circles on the sphere of directions, for pictures."""

import numpy as np

from ftac_gym.attitude import cross
from ftac_gym.utils.parameters import FloatArray


def across(axis: FloatArray) -> FloatArray:
    """Return a unit vector (3,) at right angles to a vector (3,) and to the body axis farthest from it."""
    normal = cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    return normal / np.linalg.norm(normal)


def circle(axis: FloatArray, points: int) -> FloatArray:
    """Return the great circle (points, 3) across a unit vector (3,), closed."""
    angle = np.linspace(0.0, 2.0 * np.pi, points)[:, None]
    first = across(axis)
    return np.cos(angle) * first + np.sin(angle) * cross(axis, first)


def graticule(points: int) -> list[FloatArray]:
    """Return every thirtieth circle of latitude and of longitude on the unit sphere, (points, 3) each, closed."""
    turn = np.linspace(0.0, 2.0 * np.pi, points)
    east, north, up = np.cos(turn), np.sin(turn), np.ones_like(turn)
    parallels = [
        np.stack([np.cos(tilt) * east, np.cos(tilt) * north, np.sin(tilt) * up], axis=1)
        for tilt in np.radians(np.arange(-60, 61, 30))
    ]
    meridians = [
        np.stack([np.cos(longitude) * east, np.sin(longitude) * east, north], axis=1)
        for longitude in np.radians(np.arange(0, 180, 30))
    ]
    return parallels + meridians
