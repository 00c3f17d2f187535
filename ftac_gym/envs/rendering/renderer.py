"""Frames of one spacecraft."""

from typing import Any

import numpy as np
import numpy.typing as npt

from ftac_gym.envs.rendering import palette
from ftac_gym.envs.rendering.camera import Camera
from ftac_gym.envs.rendering.readouts import Readouts
from ftac_gym.envs.rendering.scene import Scene
from ftac_gym.envs.rendering.snapshot import Snapshot
from ftac_gym.envs.rendering.toolkit import pygame
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import is_whole, require

SMALLEST = (320, 240)
"""Least width and height of a frame that can be read [pixels]."""


def check_size(width: int, height: int) -> None:
    """Check the size of a frame [pixels].

    Raises
    ------
    ValueError
        If a size is not an integer, or too small to read anything.
    """
    for name, value, least in zip(("width", "height"), (width, height), SMALLEST, strict=True):
        require(is_whole(value) and value >= least, name, f"must be an integer, {least} or more [pixels]", value)


class Renderer:
    """Drawing of one spacecraft, without a screen: the same snapshots give the same pixels.

    The camera is fixed in inertial space. The spacecraft stands in the sphere of directions, on which its boresight,
    the third body axis, leaves a path; the target is an outline of the spacecraft. Panels bend with the modal
    displacement, exaggerated ``mesh.EXAGGERATION`` times.

    Parameters
    ----------
    scenario
        The spacecraft, its limits and the limits of success.
    width, height
        Size of a frame [pixels].

    Raises
    ------
    gymnasium.error.DependencyNotInstalled
        If pygame is missing.
    ValueError
        If a size is not an integer, or too small to read anything.
    """

    def __init__(self, scenario: Scenario, width: int = 640, height: int = 480) -> None:
        check_size(width, height)
        pygame.font.init()
        self.size = (int(width), int(height))
        self._readouts = Readouts(scenario, *self.size)
        room = self.size[1] - self._readouts.bar_height
        radius = 0.5 * min(room, self.size[0]) - 4.0
        self._scene = Scene(scenario.spacecraft, Camera((0.5 * self.size[0], 0.5 * room), radius))
        self._background: Any = None
        self._surface: Any = None
        self._time = -np.inf

    def draw(self, surface: Any, snapshot: Snapshot) -> None:
        """Draw a spacecraft on a surface, or a part of one, of the renderer's size."""
        if snapshot.time < self._time:
            self._scene.trail.clear()
        self._time = snapshot.time
        if self._background is None:
            self._background = pygame.Surface(self.size)
            self._background.fill(palette.SPACE)
            self._scene.draw_sphere(self._background)
        surface.blit(self._background, (0, 0))
        self._scene.draw(surface, snapshot)
        self._readouts.draw(surface, snapshot)

    def frame(self, snapshot: Snapshot) -> npt.NDArray[np.uint8]:
        """Return a frame (height, width, 3) in an array of its own."""
        if self._surface is None:
            self._surface = pygame.Surface(self.size)
        self.draw(self._surface, snapshot)
        return pixels_of(self._surface)

    def close(self) -> None:
        """Release the surfaces; a second call does nothing."""
        self._background = None
        self._surface = None


def pixels_of(surface: Any) -> npt.NDArray[np.uint8]:
    """Return the pixels of a surface, (height, width, 3), in an array of its own."""
    return np.ascontiguousarray(pygame.surfarray.array3d(surface).swapaxes(0, 1))
