"""The drawing library, imported when somebody looks."""

from __future__ import annotations

from functools import cache, lru_cache
from importlib import import_module
from typing import Any

from gymnasium.error import DependencyNotInstalled


def drawing_library() -> Any:
    """Return the module ``pygame``.

    Raises
    ------
    gymnasium.error.DependencyNotInstalled
        If it is missing; the message names the extra.
    """
    try:
        return import_module("pygame")
    except ImportError as error:
        text = 'pygame is missing, which rendering needs: pip install "ftac-gym[render]"'
        raise DependencyNotInstalled(text) from error


class Lettering:
    """Writes text in pygame's own font, which is there wherever pygame is.

    Parameters
    ----------
    pygame
        The drawing library, with its fonts started.
    """

    def __init__(self, pygame: Any) -> None:
        # A font is a file that is read; a text that stays the same need not be drawn anew in each frame.
        self._font = cache(lambda size: pygame.font.Font(None, size))
        self.text = lru_cache(maxsize=512)(self._draw)
        """Returns a surface with a text, by text, size [pixels] and colour; not to be drawn on."""

    def _draw(self, text: str, size: int, color: tuple[int, int, int]) -> Any:
        return self._font(size).render(text, True, color)
