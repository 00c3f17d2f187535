"""Window on the screen: only this module opens a display."""

from typing import Any

import numpy as np

from ftac_gym.envs.rendering.toolkit import pygame


class Window:
    """Window that opens with the first picture.

    Parameters
    ----------
    width, height
        Size [pixels].
    title
        Title of the window.

    Attributes
    ----------
    open
        False once the window has been closed.
    """

    def __init__(self, width: int, height: int, title: str) -> None:
        self.size = (width, height)
        self.title = title
        self.open = True
        self._screen: Any = None
        self._clock: Any = None

    def show(self, picture: Any) -> None:
        """Show a surface or an array (height, width, 3), scaled to the window; nothing once it is closed.

        Raises
        ------
        gymnasium.error.DependencyNotInstalled
            If pygame is missing.
        RuntimeError
            If there is no screen to open a window on.
        """
        if not self.open:
            return
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
            picture = pygame.surfarray.make_surface(picture.swapaxes(0, 1))
        if picture.get_size() != self.size:
            picture = pygame.transform.smoothscale(picture, self.size)
        self._screen.blit(picture, (0, 0))
        pygame.display.flip()

    def events(self) -> list[Any]:
        """Return the events since the last call; that of the close button closes the window."""
        events = [] if self._screen is None else list(pygame.event.get())
        if any(event.type == pygame.QUIT for event in events):
            self.close()
        return events

    def tick(self, frames_per_second: float) -> None:
        """Wait until the next frame is due."""
        if self._clock is not None:
            self._clock.tick(frames_per_second)

    def close(self) -> None:
        """Close the window; a second call does nothing."""
        self.open = False
        if self._screen is not None:
            self._screen = None
            pygame.display.quit()
