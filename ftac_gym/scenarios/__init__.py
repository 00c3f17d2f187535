"""The library of scenarios, by name."""

from collections.abc import Callable

from ftac_gym.scenarios import (
    cao_2022,
    chen_2018,
    easy,
    flagship,
    flexible,
    li_2023,
    ma_2023,
    shen_2019,
    splits,
    zhang_zhou_2019,
)
from ftac_gym.scenarios.splits import SPLITS
from ftac_gym.task import Scenario
from ftac_gym.utils.parameters import require

__all__ = ["SPLITS", "get", "names"]

_BUILDERS: dict[str, Callable[[], Scenario]] = {
    name: entry
    for module in (cao_2022, chen_2018, easy, flagship, flexible, li_2023, ma_2023, shen_2019, splits, zhang_zhou_2019)
    for name, entry in vars(module).items()
    if getattr(entry, "__annotations__", {}).get("return") is Scenario and entry.__module__ == module.__name__
}
"""All functions of these modules that return a scenario."""


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
    require(isinstance(name, str) and name in _BUILDERS, "scenario", f"must be one of {names()}", name)
    return _BUILDERS[name]()
