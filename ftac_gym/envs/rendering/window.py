"""A window on the screen: the only thing here that opens a display."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ftac_gym.envs.rendering.toolkit import drawing_library


class Window:
    """A window that opens when there is something to show.

    Parameters
    ----------
    width, height
        [pixels].
    title
        What its frame says.

    Raises
    ------
    gymnasium.error.DependencyNotInstalled
        If pygame is missing.
    """

    def __init__(self, width: int, height: int, title: str) -> None:
        self._library = drawing_library()
        self.size = (width, height)
        self.title = title
        self.open = True
        """False once its user has closed it."""
        self._screen: Any = None
        self._clock: Any = None

    def show(self, picture: Any) -> None:
        """Show a surface or an array (height, width, 3), scaled to the window; nothing once it is closed.

        Raises
        ------
        RuntimeError
            If there is no screen to open a window on.
        """
        if not self.open:
            return
        pygame = self._library
        if self._screen is None:
            try:
                pygame.display.init()
                self._screen = pygame.display.set_mode(self.size)
            except pygame.error as error:
                text = f'no screen for a window ({error}): take render_mode="rgb_array", or --output for a film'
                raise RuntimeError(text) from error
            pygame.display.set_caption(self.title)
            self._clock = pygame.time.Clock()
        if isinstance(picture, np.ndarray):
            picture = surface_of(pygame, picture)
        if picture.get_size() != self.size:
            picture = pygame.transform.smoothscale(picture, self.size)
        self._screen.blit(picture, (0, 0))
        pygame.display.flip()

    def events(self) -> list[Any]:
        """Return what its user did since the last call."""
        if self._screen is None:
            return []
        events = list(self._library.event.get())
        if any(event.type == self._library.QUIT for event in events):
            self.close()
        return events

    def tick(self, frames_per_second: float) -> None:
        """Wait until the next frame is due."""
        if self._clock is not None:
            self._clock.tick(frames_per_second)

    def close(self) -> None:
        """Close it; a second call does nothing."""
        self.open = False
        if self._screen is not None:
            self._screen = None
            self._library.display.quit()


def surface_of(library: Any, frame: npt.NDArray[np.uint8]) -> Any:
    """Return a surface with the pixels of a frame (height, width, 3)."""
    height, width, _ = frame.shape
    return library.image.frombuffer(np.ascontiguousarray(frame), (width, height), "RGB")
