"""Objects of a user's modules by their path ``"module:name"``."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from importlib import import_module, invalidate_caches
from inspect import Parameter, signature
from typing import Any

from ftac_gym.utils.parameters import broken


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


def called(function: Callable[..., Any], path: str, what: str) -> Any:
    """Return what a function or class of a user's module returns without arguments.

    Parameters
    ----------
    function
        The function.
    path
        Its path.
    what
        Name of the argument that holds the path, for the message.

    Raises
    ------
    ValueError
        If it needs arguments. An error inside the function is its own.
    """
    parameters: list[Parameter] = []
    with suppress(ValueError):  # Some built-in functions have none.
        parameters = list(signature(function).parameters.values())
    needed = [
        item.name
        for item in parameters
        if item.default is item.empty and item.kind not in (item.VAR_POSITIONAL, item.VAR_KEYWORD)
    ]
    if needed:
        raise broken(what, f"must be a function without arguments (this has {', '.join(needed)})", path)
    return function()


@contextmanager
def _working_directory_first() -> Iterator[None]:
    folder = os.getcwd()
    sys.path.insert(0, folder)
    try:
        yield
    finally:
        with suppress(ValueError):  # The module changed the list itself.
            sys.path.remove(folder)
