"""The render modes that the single and the vector environment share."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import gymnasium as gym
import numpy as np
import numpy.typing as npt

from ftac_gym.envs.batch import BatchAccess
from ftac_gym.utils.parameters import require

if TYPE_CHECKING:
    from ftac_gym.envs.rendering.viewer import Viewer

RENDER_MODES = ("human", "rgb_array")


class Rendered(BatchAccess):
    """An environment of this package that can be looked at."""

    metadata: dict[str, Any]
    render_mode: str | None
    policy_name: str = ""
    """Who flies, for the frames; nobody knows unless it is set."""
    _viewer: Viewer | None = None
    _size: tuple[int, int]

    def __getstate__(self) -> dict[str, Any]:
        """Leave frames and window out of copies and pickles; a copy makes its own when it is asked for one."""
        return {**self.__dict__, "_viewer": None}

    def _prepare_rendering(self, render_mode: str | None, width: int, height: int) -> None:
        """Check what the frames shall be like, and whether they can be drawn at all.

        Raises
        ------
        gymnasium.error.DependencyNotInstalled
            If pygame is missing.
        ValueError
            If the render mode is unknown or the size is wrong.
        """
        rule = f"must be None or one of {list(RENDER_MODES)}"
        require(render_mode is None or render_mode in RENDER_MODES, "render_mode", rule, render_mode)
        self.render_mode = render_mode
        self._size = (width, height)
        frames_per_second = round(1.0 / self.batch.scenario.control_period, 6)
        self.metadata = {**self.metadata, "render_fps": frames_per_second}
        if render_mode is not None:
            self._watch()

    def _watch(self) -> Viewer:
        if self._viewer is None:
            from ftac_gym.envs.rendering.viewer import Viewer

            self._viewer = Viewer(self.batch, *self._size)
        return self._viewer

    def _frames(self) -> tuple[npt.NDArray[np.uint8], ...] | None:
        """Return a frame of each craft, or show them; None where there is nothing to return."""
        if self.render_mode is None:
            gym.logger.warn('there is nothing to render: make the environment with render_mode="rgb_array" or "human"')
            return None
        self._show()
        return None if self.render_mode == "human" else self._watch().frames(self.policy_name)

    def _show(self) -> None:
        """Show what has just happened, if anybody looks."""
        if self.render_mode == "human":
            self._watch().show(self.policy_name)

    def _stop_watching(self) -> None:
        if self._viewer is not None:
            self._viewer.close()
            self._viewer = None
