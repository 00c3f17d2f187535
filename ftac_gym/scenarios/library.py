"""Scenarios by name: those of the package, and a user's own."""

import re
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
from ftac_gym.task import Scenario
from ftac_gym.utils.parameters import broken, require

BUILDERS: dict[str, Callable[[], Scenario]] = {
    name: entry
    for module in (cao_2022, chen_2018, easy, flagship, flexible, li_2023, ma_2023, shen_2019, splits, zhang_zhou_2019)
    for name, entry in vars(module).items()
    if getattr(entry, "__annotations__", {}).get("return") is Scenario and entry.__module__ == module.__name__
}
"""All functions of these modules that return a scenario."""

_OWN: dict[str, Scenario] = {}
"""Scenarios that a user registered in this process."""


def names() -> list[str]:
    """Return the names of all scenarios, registered ones included."""
    return sorted([*BUILDERS, *_OWN])


def is_shipped(name: object) -> bool:
    """Tell whether an object is the name of a scenario of the package, which every process has."""
    return isinstance(name, str) and name in BUILDERS


def find(name: str) -> Scenario | None:
    """Return the scenario of a name, or None if there is none."""
    return BUILDERS[name]() if name in BUILDERS else _OWN.get(name)


def get(name: str) -> Scenario:
    """Return a scenario by name.

    Raises
    ------
    ValueError
        If the name is unknown; the message lists the known ones.
    """
    found = find(name) if isinstance(name, str) else None
    if found is None:
        raise broken("scenario", f"must be one of {names()}", name)
    return found


def register(name: str, scenario: Scenario | Callable[[], Scenario]) -> Scenario:
    """Give an own scenario a name, under which ``gym.make(..., scenario=name)``, :func:`get` and the rest find it.

    As with Gymnasium's ids, the name holds in processes that register it, and in no others. Scenarios themselves travel
    as data: environments' ``spec``, episodes, agents and the batches of a benchmark hold the scenario and not its name.
    A worker that makes its environment by the name alone needs the registration, or ``"module:function"`` as the name.

    Parameters
    ----------
    name
        The name: letters, digits, ``_`` and ``-``. An own scenario of that name is replaced, so that a notebook's cell
        can run again.
    scenario
        The scenario, or a function without arguments that returns it. Its own name becomes the registered one.

    Returns
    -------
    The registered scenario.

    Raises
    ------
    ValueError
        If the name has another form or belongs to a scenario of the package, or the scenario is none.
    """
    formed = isinstance(name, str) and re.fullmatch(r"[A-Za-z0-9_-]+", name) is not None
    require(formed, "name of a scenario", "must consist of letters, digits, '_' and '-'", name)
    require(name not in BUILDERS, "name of a scenario", "must be new; the package has a scenario of that name", name)
    built = scenario() if callable(scenario) else scenario
    require(isinstance(built, Scenario), "scenario", "must be a Scenario or a function that returns one", built)
    _OWN[name] = built.replace(name=name)
    return _OWN[name]
