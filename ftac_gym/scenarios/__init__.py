"""The library of scenarios, by name."""

from __future__ import annotations

from collections.abc import Callable

from ftac_gym.parameters import require
from ftac_gym.scenario import Scenario
from ftac_gym.scenarios.flagship import flagship, flagship_tracking

_BUILDERS: dict[str, Callable[[], Scenario]] = {
    "flagship": flagship,
    "flagship_tracking": flagship_tracking,
}


def names() -> list[str]:
    """Return the names of all scenarios."""
    return sorted(_BUILDERS)


def get(name: str) -> Scenario:
    """Return a scenario by name.

    Raises
    ------
    ValueError
        If the name is unknown; the message lists the known ones.
    """
    require(name in _BUILDERS, "scenario", f"must be one of {names()}", name)
    return _BUILDERS[name]()
