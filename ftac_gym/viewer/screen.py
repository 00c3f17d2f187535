"""Picture of a session: its policies side by side, and a line with its state."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ftac_gym.envs.rendering import Renderer, palette
from ftac_gym.envs.rendering.renderer import pixels_of
from ftac_gym.envs.rendering.toolkit import Lettering, pygame
from ftac_gym.viewer.session import Session

HELP = (
    "Tab kind | 0-9 add fault | Shift+0-9 clear | Back clear all | Space pause | Right step | "
    "Up/Down speed | R again | N next | V film | Q quit"
)
"""Line with the keys."""

STRIP = 44
"""Height of the lines below the views [pixels]."""


class Screen:
    """Drawing of a session.

    Parameters
    ----------
    session
        The session.
    width, height
        Size of the whole picture [pixels].
    strip
        Whether to leave room for a line with the state of the session, and one with the keys.

    Attributes
    ----------
    surface
        The last picture.
    notice
        Text that is shown with the state.

    Raises
    ------
    gymnasium.error.DependencyNotInstalled
        If pygame is missing.
    ValueError
        If there is too little room for the views.
    """

    def __init__(self, session: Session, width: int, height: int, strip: bool = True) -> None:
        self._letters = Lettering()
        self._session = session
        self._strip = STRIP if strip else 0
        self._share = width // len(session.live)
        self._renderers = [Renderer(session.scenario, self._share, height - self._strip) for _ in session.live]
        self.surface: Any = pygame.Surface((width, height))
        self.notice = ""

    def draw(self) -> None:
        """Draw the present state."""
        self.surface.fill(palette.SPACE)
        _, height = self.surface.get_size()
        for index, (renderer, live) in enumerate(zip(self._renderers, self._session.live, strict=True)):
            area = (index * self._share, 0, self._share, height - self._strip)
            renderer.draw(self.surface.subsurface(area), live.snapshot())
            if index:
                pygame.draw.line(self.surface, palette.LINE, (area[0], 0), (area[0], area[3]))
        if self._strip:
            session = self._session
            state = "over" if session.over else "paused" if session.paused else f"x{session.speed:g}"
            line = f"{session.scenario.name}, seed {session.seed}, episode {session.episode} | {state} | "
            line += f"next fault: {session.kind.replace('_', ' ')} {self.notice and '| ' + self.notice}"
            self._write(line, height - self._strip + 4, 19, palette.TEXT)
            self._write(HELP, height - self._strip + 24, 16, palette.FAINT)

    def _write(self, text: str, top: int, size: int, color: palette.Color) -> None:
        drawn = self._letters.text(text, size, color)
        room = self.surface.get_width() - 16
        if drawn.get_width() > room:
            drawn = pygame.transform.smoothscale(drawn, (room, drawn.get_height()))
        self.surface.blit(drawn, (8, top))

    def frame(self) -> npt.NDArray[np.uint8]:
        """Return the pixels of the last picture, (height, width, 3)."""
        return pixels_of(self.surface)
