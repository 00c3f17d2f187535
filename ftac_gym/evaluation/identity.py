"""Identity of results: stored ones are used again only if nothing has changed that their numbers depend on."""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Iterator
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from ftac_gym.policies import Policy
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.serialization import TYPE_KEY, classes, to_plain

PACKAGE = Path(__file__).parents[1]

LIBRARIES = ("numpy", "scipy", "numba", "llvmlite", "torch", "stable-baselines3", "sb3-contrib")
"""Libraries that compute numbers of a flight: another version may compute other last digits."""

_APART = {"agents", "tuned_gains", "report", "reproduction", "__pycache__"}
"""Folders whose data are left out: agents and tuned gains are in fingerprints, and flights need no texts."""


@cache
def package_digest() -> str:
    """Return a hash of the package's code and data, and of the versions of :data:`LIBRARIES`."""
    state = hashlib.sha256()
    for path in sorted(PACKAGE.rglob("*")):
        name = path.relative_to(PACKAGE)
        if path.is_file() and (path.suffix == ".py" or not _APART & set(name.parts)):
            content = path.read_bytes()
            state.update(f"{name.as_posix()} {len(content)} ".encode() + content)
    state.update(" ".join(map(_version, LIBRARIES)).encode())
    return state.hexdigest()


def identity(scenario: Scenario, policy: Policy) -> str | None:
    """Return a text that is equal for equal policies, tasks, code and data.

    Returns
    -------
    The text; None if results of other code could not be told apart. Then the policy has no fingerprint, or a class of
    the scenario was defined in no file.
    """
    fingerprint, sources = getattr(policy, "fingerprint", None), _outside_sources(scenario)
    if fingerprint is None or sources is None:
        return None
    return " ".join([package_digest(), sources, fingerprint, scenario.to_json()])


def outside_classes(scenario: Scenario) -> list[type]:
    """Return the classes in a scenario that are not of this package, such as custom kinds of faults."""
    found = {name: classes()[name] for name in _class_names(to_plain(scenario))}
    return [cls for _, cls in sorted(found.items()) if cls.__module__.partition(".")[0] != PACKAGE.name]


def _outside_sources(scenario: Scenario) -> str | None:
    """Return a hash of the modules of a scenario's classes that are not of this package; None if one has no file."""
    used = {base.__module__ for cls in outside_classes(scenario) for base in cls.__mro__}
    own = {PACKAGE.name, *sys.stdlib_module_names} - {"__main__"}
    state = hashlib.sha256()
    for module in sorted(name for name in used if name.partition(".")[0] not in own):
        file = getattr(sys.modules.get(module), "__file__", None)
        if file is None or not Path(file).is_file():
            return None
        state.update(Path(file).read_bytes())
    return state.hexdigest()


def _class_names(plain: Any) -> Iterator[str]:
    if isinstance(plain, dict):
        yield plain[TYPE_KEY]
        plain = list(plain.values())
    for item in plain if isinstance(plain, list) else ():
        yield from _class_names(item)


def _version(library: str) -> str:
    try:
        return version(library)
    except PackageNotFoundError:
        return ""
