"""Objects of a user's modules by their path ``"module:name"``."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from importlib import import_module, invalidate_caches
from typing import Any


def is_path(text: str) -> bool:
    """Tell whether a text is a path ``"module:name"``."""
    module, colon, name = text.partition(":")
    # A single letter before the colon may be a drive of Windows.
    return bool(colon) and len(module) > 1 and all(part.isidentifier() for part in (*module.split("."), name))


def imported(path: str, what: str) -> Any:
    """Return the object at a path ``"module:name"``, or None if its module does not define the name.

    The module is looked for in the working directory first, as ``python -m`` does.

    Parameters
    ----------
    path
        The path.
    what
        Name of the argument that holds it, for the message.

    Raises
    ------
    ValueError
        If there is no such module. An import that fails inside the module raises its own error.
    """
    module, _, name = path.partition(":")
    invalidate_caches()  # A notebook may have written the module just now.
    try:
        with _working_directory_first():
            return getattr(import_module(module), name, None)
    except ModuleNotFoundError as error:
        if error.name is None or not f"{module}.".startswith(f"{error.name}."):
            raise  # The module exists, and imports another that does not.
        rule = f"must be in a module that can be imported; there is no {error.name!r} in this folder or on PYTHONPATH"
        raise ValueError(f"{what} {rule}, got {path!r}") from None


@contextmanager
def _working_directory_first() -> Iterator[None]:
    folder = os.getcwd()
    sys.path.insert(0, folder)
    try:
        yield
    finally:
        with suppress(ValueError):  # The module changed the list itself.
            sys.path.remove(folder)
