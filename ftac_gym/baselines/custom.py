"""Custom baselines: given as a class, or as the text ``"module:Class"``."""

from __future__ import annotations

from importlib import import_module

from ftac_gym.baselines.baseline import Baseline
from ftac_gym.utils.importing import imported
from ftac_gym.utils.parameters import require

BaselineLike = str | type[Baseline]
"""A baseline: its name, the class of a custom one, or the path ``"module:Class"`` of that class."""


def baseline_at(path: str) -> type[Baseline]:
    """Return the class at a path ``"module:Class"``; see :func:`~ftac_gym.utils.importing.imported`.

    Raises
    ------
    ValueError
        If there is no such module, it has no such class, or the class does not derive from
        :class:`~ftac_gym.baselines.Baseline`.
    """
    found = imported(path, "baseline")
    valid = isinstance(found, type) and issubclass(found, Baseline)
    require(valid, "baseline", f"must name a class in {path.partition(':')[0]} that derives from Baseline", path)
    return found


def path_of(baseline: BaselineLike) -> str:
    """Return a baseline as text from which another process can build it; text is returned unchanged.

    Raises
    ------
    ValueError
        If the class cannot be imported: it was defined in a script, a notebook or a function.
    """
    if isinstance(baseline, str):
        return baseline
    valid = isinstance(baseline, type) and issubclass(baseline, Baseline)
    require(valid, "baseline", "must be a name or a Baseline class", baseline)
    module, name = baseline.__module__, baseline.__name__
    importable = module != "__main__" and getattr(import_module(module), name, None) is baseline
    rule = "must be a class that can be imported, so that it is found again later: write it into a module of its own"
    require(importable, "baseline", rule, baseline)
    return f"{module}:{name}"


def label(baseline: BaselineLike) -> str:
    """Return the name of a baseline in messages and tables."""
    return baseline if isinstance(baseline, str) else baseline.__name__
