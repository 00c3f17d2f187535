"""Spacecraft among the directions: sphere, path of the boresight, target, body, panels, wheels and axes."""

from typing import Any

import numpy as np

from ftac_gym.attitude import rotation_matrix
from ftac_gym.envs.rendering import mesh, palette
from ftac_gym.envs.rendering.camera import Camera
from ftac_gym.envs.rendering.snapshot import Snapshot
from ftac_gym.envs.rendering.toolkit import Lettering, pygame
from ftac_gym.spacecraft.spacecraft import Spacecraft
from ftac_gym.utils.directions import circle, graticule
from ftac_gym.utils.parameters import FloatArray

BORESIGHT = 2
"""Index of the body axis whose path is drawn: the third."""

LONGEST_TRAIL = 4000
"""Most points of the path; beyond it every second one is dropped."""

_LIGHT = np.array([0.45, -0.6, 0.66])


class Scene:
    """Drawing of a spacecraft through a camera, with the path of its boresight.

    Parameters
    ----------
    spacecraft
        The spacecraft.
    camera
        The camera.

    Attributes
    ----------
    trail
        Directions of the boresight so far, (3,) each.
    """

    def __init__(self, spacecraft: Spacecraft, camera: Camera) -> None:
        self._camera = camera
        self._appendages = spacecraft.appendages
        self._body = mesh.body_faces()
        self._wheels = mesh.wheel_faces(spacecraft.wheels.axis_matrix)
        self._outline = np.concatenate([self._body, mesh.panel_faces(np.zeros(3))])
        self._letters, self._size = Lettering(), max(14, int(camera.radius * 0.1))
        self.trail: list[FloatArray] = []

    def draw_sphere(self, surface: Any) -> None:
        """Draw the sphere of directions with its graticule, which never changes."""
        for line in graticule(97):
            self._line(surface, line, palette.GRATICULE)
        # The rim of a sphere seen from nearby is a smaller circle, nearer to the camera.
        near, toward = 1.0 / self._camera.distance, self._camera.axes[2]
        self._line(surface, near * toward + np.sqrt(1.0 - near**2) * circle(toward, 97), palette.LINE)

    def draw(self, surface: Any, snapshot: Snapshot) -> None:
        """Draw the present attitude, and lengthen the path of the boresight."""
        attitude = rotation_matrix(snapshot.attitude).T
        target = rotation_matrix(snapshot.reference_attitude).T
        boresight = attitude[:, BORESIGHT]
        if not self.trail or float(np.abs(boresight - self.trail[-1]).max()) > 2e-3:
            self.trail.append(boresight.copy())
            if len(self.trail) > LONGEST_TRAIL:
                self.trail = self.trail[::2]
        self._draw_trail(surface, behind=True)
        self._draw_target(surface, target)
        self._draw_spacecraft(surface, attitude, snapshot)
        self._draw_trail(surface, behind=False)
        for axis, (color, label) in enumerate(zip(palette.AXES, "xyz", strict=True)):
            self._draw_axis(surface, attitude[:, axis] * (1.0 if axis == BORESIGHT else 0.55), color, label)
        place, _ = self._camera.project(target[:, BORESIGHT])
        pygame.draw.aacircle(surface, palette.TARGET, place, max(5, int(self._camera.radius * 0.035)), 2)

    def _draw_spacecraft(self, surface: Any, attitude: FloatArray, snapshot: Snapshot) -> None:
        panels = mesh.panel_faces(mesh.panel_turn(self._appendages, snapshot.modal_displacement))
        faces = [(face, palette.BODY, True) for face in self._body]
        faces += [(face, palette.CELLS, False) for face in panels]
        for disc, share, faulty in zip(self._wheels, snapshot.effectiveness, snapshot.faulty, strict=True):
            faces.append((disc, palette.health(float(share), bool(faulty))[0], False))
        drawn = []
        viewpoint = self._camera.axes[2] * self._camera.distance
        for face, color, solid in faces:
            points = face @ attitude.T
            normal = np.cross(points[1] - points[0], points[2] - points[1])
            normal /= np.linalg.norm(normal)
            middle = points.mean(axis=0)
            facing = float(normal @ (viewpoint - middle))
            if solid and facing <= 0.0:
                continue
            light = float(normal @ _LIGHT) * (1.0 if facing > 0.0 else -1.0)
            shade = 0.45 + 0.55 * max(light, 0.0)
            pixels, _ = self._camera.project(points)
            drawn.append((float(middle @ self._camera.axes[2]), pixels, palette.dimmed(color, shade)))
        for _, pixels, color in sorted(drawn, key=lambda item: item[0]):
            pygame.draw.polygon(surface, color, pixels)
            pygame.draw.aalines(surface, palette.PANEL, True, pixels)

    def _draw_target(self, surface: Any, target: FloatArray) -> None:
        pixels, _ = self._camera.project(self._outline @ target.T)
        color = palette.dimmed(palette.TARGET)
        for outline in pixels:
            pygame.draw.aalines(surface, color, True, outline)
        self._line(surface, np.stack([np.zeros(3), target[:, BORESIGHT]]), palette.TARGET)

    def _draw_trail(self, surface: Any, behind: bool) -> None:
        if len(self.trail) < 2:
            return
        pixels, depth = self._camera.project(np.array(self.trail))
        far = depth < 0.0
        color = palette.dimmed(palette.TRAIL) if behind else palette.TRAIL
        edges = np.flatnonzero(np.diff(far.astype(np.int8))) + 1
        for part in np.split(np.arange(len(far)), edges):
            # Each part reaches to where the next one begins.
            joined = pixels[part[0] : part[-1] + 2]
            if far[part[0]] == behind and len(joined) > 1:
                pygame.draw.aalines(surface, color, False, joined)

    def _draw_axis(self, surface: Any, tip: FloatArray, color: palette.Color, label: str) -> None:
        pixels, _ = self._camera.project(np.stack([np.zeros(3), tip, tip * 1.08]))
        pygame.draw.line(surface, color, pixels[0], pixels[1], max(2, int(self._camera.radius * 0.012)))
        text = self._letters.text(label, self._size, color)
        surface.blit(text, text.get_rect(center=tuple(pixels[2])))

    def _line(self, surface: Any, points: FloatArray, color: palette.Color) -> None:
        pixels, _ = self._camera.project(points)
        pygame.draw.aalines(surface, color, False, pixels)
