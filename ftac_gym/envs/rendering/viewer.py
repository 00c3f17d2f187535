"""What an environment's render modes show."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from ftac_gym.envs.batch import SpacecraftBatch
from ftac_gym.envs.rendering.renderer import Renderer
from ftac_gym.envs.rendering.snapshot import snapshots
from ftac_gym.envs.rendering.window import Window

Frame = npt.NDArray[np.uint8]

MOST_TILES = 16
"""A window shows the first so many craft."""

MOST_FRAMES_PER_SECOND = 50.0
"""A window shows no more: an environment that steps faster skips frames, so that it keeps up with the clock."""


class Viewer:
    """Frames of N craft: arrays for ``"rgb_array"``, a window in real time for ``"human"``.

    Parameters
    ----------
    batch
        The craft.
    width, height
        Size of the frame of one craft, and of the window [pixels].

    Raises
    ------
    gymnasium.error.DependencyNotInstalled
        If pygame is missing.
    ValueError
        If the size is not a pair of positive integers, or too small to show anything.
    """

    def __init__(self, batch: SpacecraftBatch, width: int, height: int) -> None:
        self.batch = batch
        self.size = (width, height)
        # The first one now: a wrong size or a missing library shall not wait for the first frame.
        self._renderers = [Renderer(batch.scenario, width, height)]
        self._window: Window | None = None
        self._every = math.ceil(1.0 / (batch.scenario.control_period * MOST_FRAMES_PER_SECOND))

    def frames(self, policy: str = "", most: int | None = None) -> tuple[Frame, ...]:
        """Return a frame (height, width, 3) of each craft, or of the first so many.

        Parameters
        ----------
        policy
            Who flies.
        most
            How many craft; None for all.
        """
        seen = snapshots(self.batch, policy)[:most]
        while len(self._renderers) < len(seen):
            self._renderers.append(Renderer(self.batch.scenario, *self.size))
        return tuple(renderer.frame(item) for renderer, item in zip(self._renderers, seen, strict=False))

    def show(self, policy: str = "") -> None:
        """Show the present moment in a window, side by side if there are several craft, and wait until it is over.

        Once its user has closed the window, nothing is shown any more.
        """
        if int(self.batch.simulator.ticks[0]) % self._every:
            return
        if self._window is None:
            self._window = Window(*self.size, title=self.batch.scenario.name)
        if not self._window.open:
            return
        self._window.show(tiled(self.frames(policy, MOST_TILES)))
        self._window.events()
        self._window.tick(1.0 / (self.batch.scenario.control_period * self._every))

    def close(self) -> None:
        """Let go of window and surfaces; a second call does nothing."""
        for renderer in self._renderers:
            renderer.close()
        if self._window is not None:
            self._window.close()


def tiled(frames: tuple[Frame, ...]) -> Frame:
    """Return the frames (height, width, 3) side by side in a grid that is at most one wider than high."""
    columns = math.ceil(math.sqrt(len(frames)))
    rows = math.ceil(len(frames) / columns)
    height, width, _ = frames[0].shape
    grid = np.zeros((rows * height, columns * width, 3), dtype=np.uint8)
    for index, frame in enumerate(frames):
        row, column = divmod(index, columns)
        grid[row * height : (row + 1) * height, column * width : (column + 1) * width] = frame
    return grid
