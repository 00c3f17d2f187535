"""The drawing library, imported when somebody looks."""

from __future__ import annotations

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
