"""Drawing library, which is imported when something is drawn, and its text."""

from functools import cache, lru_cache
from importlib import import_module
from typing import Any

from ftac_gym.utils.extras import naming_extra


class _Library:
    """Module ``pygame``, imported with its first attribute."""

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            # Tools that inspect modules ask for these; they must not import the library.
            raise AttributeError(name)
        with naming_extra():
            return getattr(import_module("pygame"), name)


pygame: Any = _Library()
"""Module ``pygame``; a missing one is a ``gymnasium.error.DependencyNotInstalled`` that names the extra."""


class Lettering:
    """Text in pygame's own font, which needs no font of the system.

    Attributes
    ----------
    text
        Function from text, size [pixels] and colour to a surface with the text, which must not be drawn on.
    """

    def __init__(self) -> None:
        # Reading a font file and drawing a text cost more than looking them up.
        self._font = cache(lambda size: pygame.font.Font(None, size))
        self.text = lru_cache(maxsize=512)(self._draw)

    def _draw(self, text: str, size: int, color: tuple[int, int, int]) -> Any:
        return self._font(size).render(text, True, color)
