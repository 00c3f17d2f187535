"""A session as a picture: its flights side by side, and a line that says what is going on."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ftac_gym.envs.rendering import Renderer, palette
from ftac_gym.envs.rendering.renderer import pixels_of
from ftac_gym.envs.rendering.toolkit import Lettering, drawing_library
from ftac_gym.viewer.session import Session

HELP = (
    "Tab kind | 0-9 strike wheel | Shift+0-9 mend | Back mend all | Space pause | Right step | "
    "Up/Down speed | R again | N next | V film | Q quit"
)
"""What the keys do."""

STRIP = 44
"""Height of the lines below the flights [pixels]."""


class Screen:
    """Draws a session.

    Parameters
    ----------
    session
        What is drawn.
    width, height
        Of the whole picture [pixels].
    strip
        Whether to leave room for a line with the state of the session, and one with the keys.

    Raises
    ------
    gymnasium.error.DependencyNotInstalled
        If pygame is missing.
    ValueError
        If there is too little room for the flights.
    """

    def __init__(self, session: Session, width: int, height: int, strip: bool = True) -> None:
        self._pygame = drawing_library()
        self._letters = Lettering(self._pygame)
        self._session = session
        self._strip = STRIP if strip else 0
        self._share = width // len(session.flights)
        self._renderers = [Renderer(session.scenario, self._share, height - self._strip) for _ in session.flights]
        self.surface: Any = self._pygame.Surface((width, height))
        """The picture that was drawn last."""
        self.notice = ""
        """Shown with the state: what has just happened."""

    def draw(self) -> None:
        """Draw the session as it is now."""
        self.surface.fill(palette.SPACE)
        _, height = self.surface.get_size()
        for index, (renderer, flight) in enumerate(zip(self._renderers, self._session.flights, strict=True)):
            area = (index * self._share, 0, self._share, height - self._strip)
            renderer.draw(self.surface.subsurface(area), flight.snapshot())
            if index:
                self._pygame.draw.line(self.surface, palette.LINE, (area[0], 0), (area[0], area[3]))
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
            drawn = self._pygame.transform.smoothscale(drawn, (room, drawn.get_height()))
        self.surface.blit(drawn, (8, top))

    def frame(self) -> npt.NDArray[np.uint8]:
        """Return the pixels of the picture that was drawn last, (height, width, 3)."""
        return pixels_of(self._pygame, self.surface)
