"""Frames of the spacecraft of an environment, in an array or in a window."""

import math
from typing import Any

import gymnasium as gym
import numpy as np
import numpy.typing as npt

from ftac_gym.envs.batch import SpacecraftBatch
from ftac_gym.envs.rendering.renderer import Renderer, check_size
from ftac_gym.envs.rendering.snapshot import snapshots
from ftac_gym.envs.rendering.window import Window
from ftac_gym.utils.parameters import require

Frame = npt.NDArray[np.uint8]

RENDER_MODES = ("human", "rgb_array")

MOST_TILES = 16
"""Number of spacecraft that a window shows, the first ones."""

MOST_FRAMES_PER_SECOND = 50.0
"""Limit for a window: an environment that steps faster skips frames, which keeps it in step with the clock."""


class Display:
    """Frames of N spacecraft: arrays in mode ``"rgb_array"``, a window in real time in mode ``"human"``.

    Copies and pickles leave window and surfaces out; a copy makes its own when it needs them.

    Parameters
    ----------
    batch
        The spacecraft.
    render_mode
        One of RENDER_MODES, or None for nothing.
    width, height
        Size of the frame of one spacecraft, and of the window [pixels].

    Raises
    ------
    gymnasium.error.DependencyNotInstalled
        If a window is asked for and pygame is missing; for arrays, when the first one is drawn.
    ValueError
        If the render mode is unknown, or the size is not a pair of integers or is too small.
    """

    def __init__(self, batch: SpacecraftBatch, render_mode: str | None, width: int, height: int) -> None:
        rule = f"must be None or one of {list(RENDER_MODES)}"
        require(render_mode is None or render_mode in RENDER_MODES, "render_mode", rule, render_mode)
        self._batch, self._mode, self._size = batch, render_mode, (width, height)
        if render_mode is not None:
            check_size(width, height)
        # Libraries ask for arrays by default and draw none: pygame may be missing until the first frame.
        self._renderers = [Renderer(batch.scenario, width, height)] if render_mode == "human" else []
        self._window: Window | None = None
        self._every = math.ceil(1.0 / (batch.scenario.control_period * MOST_FRAMES_PER_SECOND))

    def __getstate__(self) -> dict[str, Any]:
        """Leave out surfaces and window."""
        return {**self.__dict__, "_renderers": [], "_window": None}

    def render(self, policy: str) -> tuple[Frame, ...] | None:
        """Return a frame (height, width, 3) of each spacecraft; None, with a warning, without a render mode.

        In mode ``"human"`` the present moment is shown and None returned.

        Parameters
        ----------
        policy
            Name of the policy; empty for none.
        """
        if self._mode is None:
            gym.logger.warn('there is nothing to render: make the environment with render_mode="rgb_array" or "human"')
        self.show(policy)
        return self._frames(policy) if self._mode == "rgb_array" else None

    def show(self, policy: str) -> None:
        """Show the present moment and wait until it is over, in mode ``"human"``; nothing in a closed window."""
        simulator, scenario = self._batch.simulator, self._batch.scenario
        if self._mode != "human" or int(simulator.ticks[0]) % self._every:
            return
        if self._window is None:
            self._window = Window(*self._size, title=scenario.name)
        if not self._window.open:
            return
        self._window.show(tiled(self._frames(policy, MOST_TILES)))
        self._window.events()
        self._window.tick(1.0 / (scenario.control_period * self._every))

    def close(self) -> None:
        """Release window and surfaces; a second call does nothing."""
        if self._window is not None:
            self._window.close()
        self._renderers, self._window = [], None

    def _frames(self, policy: str, most: int | None = None) -> tuple[Frame, ...]:
        seen = snapshots(self._batch, policy)[:most]
        while len(self._renderers) < len(seen):
            self._renderers.append(Renderer(self._batch.scenario, *self._size))
        return tuple(renderer.frame(item) for renderer, item in zip(self._renderers, seen, strict=False))


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
