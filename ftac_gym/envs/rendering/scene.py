"""The craft among the directions: sphere, path of the boresight, target, body, panels, wheels and axes."""

from __future__ import annotations

from typing import Any

import numpy as np

from ftac_gym.attitude import rotation_matrix
from ftac_gym.envs.rendering import mesh, palette
from ftac_gym.envs.rendering.camera import Camera
from ftac_gym.envs.rendering.snapshot import Snapshot
from ftac_gym.envs.rendering.toolkit import Lettering
from ftac_gym.spacecraft.spacecraft import Spacecraft
from ftac_gym.utils.directions import circle, graticule
from ftac_gym.utils.parameters import FloatArray

BORESIGHT = 2
"""Index of the body axis whose path is drawn: the third."""

LONGEST_TRAIL = 4000
"""Points of the path that are kept; then every second one is forgotten."""

_LIGHT = np.array([0.45, -0.6, 0.66])


class Scene:
    """Draws a craft through a camera, and remembers where its boresight has been.

    Parameters
    ----------
    pygame
        The drawing library.
    spacecraft
        What is drawn.
    camera
        Where from.
    """

    def __init__(self, pygame: Any, spacecraft: Spacecraft, camera: Camera) -> None:
        self._pygame = pygame
        self._camera = camera
        self._appendages = spacecraft.appendages
        self._body = mesh.body_faces()
        self._wheels = mesh.wheel_faces(spacecraft.wheels.axis_matrix)
        self._ghost = np.concatenate([self._body, mesh.panel_faces(np.zeros(3))])
        self._trail: list[FloatArray] = []
        self._letters, self._size = Lettering(pygame), max(14, int(camera.radius * 0.1))

    def restart(self) -> None:
        """Forget the path of the boresight."""
        self._trail = []

    def draw_sphere(self, surface: Any) -> None:
        """Draw the sphere of directions with its graticule, which never changes."""
        for line in graticule(97):
            self._line(surface, line, palette.GRATICULE)
        # The rim of a sphere seen from nearby is a smaller circle, nearer to the camera.
        near, toward = 1.0 / self._camera.distance, self._camera.axes[2]
        self._line(surface, near * toward + np.sqrt(1.0 - near**2) * circle(toward, 97), palette.LINE)

    def draw(self, surface: Any, snapshot: Snapshot) -> None:
        """Draw the craft as it is now, and lengthen the path of its boresight."""
        turned = rotation_matrix(snapshot.attitude).T
        wanted = rotation_matrix(snapshot.reference_attitude).T
        boresight = turned[:, BORESIGHT]
        if not self._trail or float(np.abs(boresight - self._trail[-1]).max()) > 2e-3:
            self._trail.append(boresight.copy())
            if len(self._trail) > LONGEST_TRAIL:
                self._trail = self._trail[::2]
        self._draw_trail(surface, behind=True)
        self._draw_ghost(surface, wanted)
        self._draw_craft(surface, turned, snapshot)
        self._draw_trail(surface, behind=False)
        for axis in range(3):
            self._arrow(
                surface, turned[:, axis] * (1.0 if axis == BORESIGHT else 0.55), palette.AXES[axis], "xyz"[axis]
            )
        target, _ = self._camera.project(wanted[:, BORESIGHT])
        self._pygame.draw.aacircle(surface, palette.GHOST, target, max(5, int(self._camera.radius * 0.035)), 2)

    def _draw_craft(self, surface: Any, turned: FloatArray, snapshot: Snapshot) -> None:
        panels = mesh.panel_faces(mesh.panel_turn(self._appendages, snapshot.modal_displacement))
        colors = [
            palette.health(float(share), bool(faulty))[0]
            for share, faulty in zip(snapshot.effectiveness, snapshot.faulty, strict=True)
        ]
        pieces = [(face, palette.BODY, True) for face in self._body]
        pieces += [(face, palette.CELLS, False) for face in panels]
        pieces += [(disc, color, False) for disc, color in zip(self._wheels, colors, strict=True)]
        drawn = []
        viewpoint = self._camera.axes[2] * self._camera.distance
        for face, color, solid in pieces:
            points = face @ turned.T
            normal = np.cross(points[1] - points[0], points[2] - points[1])
            normal /= np.linalg.norm(normal)
            middle = points.mean(axis=0)
            facing = float(normal @ (viewpoint - middle))
            if solid and facing <= 0.0:
                continue
            light = float(normal @ _LIGHT) * (1.0 if facing > 0.0 else -1.0)
            shade = 0.45 + 0.55 * max(light, 0.0)
            pixels, _ = self._camera.project(points)
            depth = float(middle @ self._camera.axes[2])
            drawn.append((depth, pixels, palette.dimmed(color, shade)))
        for _, pixels, color in sorted(drawn, key=lambda item: item[0]):
            self._pygame.draw.polygon(surface, color, pixels)
            self._pygame.draw.aalines(surface, palette.PANEL, True, pixels)

    def _draw_ghost(self, surface: Any, wanted: FloatArray) -> None:
        pixels, _ = self._camera.project(self._ghost @ wanted.T)
        color = palette.dimmed(palette.GHOST)
        for outline in pixels:
            self._pygame.draw.aalines(surface, color, True, outline)
        self._line(surface, np.stack([np.zeros(3), wanted[:, BORESIGHT]]), palette.GHOST)

    def _draw_trail(self, surface: Any, behind: bool) -> None:
        if len(self._trail) < 2:
            return
        points = np.array(self._trail)
        pixels, depth = self._camera.project(points)
        far = depth < 0.0
        color = palette.dimmed(palette.TRAIL) if behind else palette.TRAIL
        edges = np.flatnonzero(np.diff(far.astype(np.int8))) + 1
        for part in np.split(np.arange(len(points)), edges):
            # Each part reaches to where the next one begins.
            joined = pixels[part[0] : part[-1] + 2]
            if far[part[0]] == behind and len(joined) > 1:
                self._pygame.draw.aalines(surface, color, False, joined)

    def _arrow(self, surface: Any, tip: FloatArray, color: palette.Color, label: str) -> None:
        pixels, _ = self._camera.project(np.stack([np.zeros(3), tip, tip * 1.08]))
        self._pygame.draw.line(surface, color, pixels[0], pixels[1], max(2, int(self._camera.radius * 0.012)))
        text = self._letters.text(label, self._size, color)
        surface.blit(text, text.get_rect(center=tuple(pixels[2])))

    def _line(self, surface: Any, points: FloatArray, color: tuple[int, ...]) -> None:
        pixels, _ = self._camera.project(points)
        self._pygame.draw.aalines(surface, color, False, pixels)
