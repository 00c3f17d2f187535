"""Projection of points in space onto the screen."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ftac_gym.utils.parameters import FloatArray

VIEW_FROM = (2.2, -3.6, 1.9)
"""Place of the camera in inertial axes; the sphere of directions has radius 1."""

FIELD = 1.22
"""Half-width at the distance of the origin that fits between centre and edge of the viewport."""


@dataclass(frozen=True, eq=False)
class Camera:
    """Perspective camera, fixed in inertial space, towards the origin and with the third inertial axis up.

    Parameters
    ----------
    center
        (2,) place of the origin [pixels].
    radius
        Length of ``FIELD`` at the origin [pixels].
    """

    center: tuple[float, float]
    radius: float

    @cached_property
    def distance(self) -> float:
        """Distance from the camera to the origin."""
        return float(np.linalg.norm(VIEW_FROM))

    @cached_property
    def axes(self) -> FloatArray:
        """(3, 3) rows: right, up and towards the camera, in inertial axes."""
        toward = np.array(VIEW_FROM) / self.distance
        right = np.cross((0.0, 0.0, 1.0), toward)
        right /= np.linalg.norm(right)
        return np.stack([right, np.cross(toward, right), toward])

    def project(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return pixels (..., 2), rows downwards, and the depth (...) towards the camera of points (..., 3)."""
        seen = points @ self.axes.T
        scale = self.radius / FIELD * self.distance / (self.distance - seen[..., 2])
        pixels = np.stack([self.center[0] + scale * seen[..., 0], self.center[1] - scale * seen[..., 1]], axis=-1)
        return pixels, seen[..., 2]
