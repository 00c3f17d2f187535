"""Laws from outside of the package: given as a class, or as text that says where the class is."""

from __future__ import annotations

from importlib import import_module

from ftac_gym.baselines.baseline import Baseline
from ftac_gym.utils.parameters import require

Law = str | type[Baseline]
"""A baseline: its name, a class of your own, or where that class is, as ``"module:Class"``."""


def is_path(name: str) -> bool:
    """Tell whether a text says where a class is, as ``"module:Class"``."""
    module, colon, law = name.partition(":")
    # What begins with a single letter may be a drive of Windows.
    return bool(colon) and len(module) > 1 and all(part.isidentifier() for part in (*module.split("."), law))


def imported(path: str) -> type[Baseline]:
    """Return the class at a path ``"module:Class"``; its module is imported, as ``gym.make("module:Id-v0")`` does.

    Raises
    ------
    ValueError
        If there is no such module, it has no such class, or the class does not derive from :class:`Baseline`.
    """
    module, _, name = path.partition(":")
    try:
        found = getattr(import_module(module), name, None)
    except ModuleNotFoundError as error:
        if error.name is None or not f"{module}.".startswith(f"{error.name}."):
            raise  # The module is there, and lacks something itself.
        rule = f"must be in a module that can be imported; there is no {error.name!r} in this folder or on PYTHONPATH"
        raise ValueError(f"baseline {rule}, got {path!r}") from None
    law = isinstance(found, type) and issubclass(found, Baseline)
    require(law, "baseline", f"must name a class in {module} that derives from Baseline", path)
    return found  # type: ignore[return-value]


def path_of(law: Law) -> str:
    """Return a law as text that other processes, and later ones, understand; text is left as it is.

    Raises
    ------
    ValueError
        If the class cannot be imported from anywhere: it was defined in a script, a notebook or a function.
    """
    if isinstance(law, str):
        return law
    rule = "must be a class that can be imported, so that it is found again later: write it into a module of its own"
    require(isinstance(law, type) and issubclass(law, Baseline), "baseline", "must be a name or a Baseline class", law)
    importable = law.__module__ != "__main__" and getattr(import_module(law.__module__), law.__name__, None) is law
    require(importable, "baseline", rule, law)
    return f"{law.__module__}:{law.__name__}"


def label(law: Law) -> str:
    """Return what messages and tables call a law."""
    return law if isinstance(law, str) else law.__name__
