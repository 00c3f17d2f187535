"""Analytical policies, by name: batched NumPy, one law per file."""

from __future__ import annotations

import inspect
from typing import Any

from ftac_gym.baselines.baseline import Baseline
from ftac_gym.baselines.controllers.pd import PD, PDDisturbanceObserver
from ftac_gym.baselines.estimate import FaultEstimate
from ftac_gym.baselines.policy import BaselinePolicy, as_action, measurement_of
from ftac_gym.parameters import require
from ftac_gym.scenario import Scenario

_BUILDERS: dict[str, type[Baseline]] = {
    "pd": PD,
    "pd_dob": PDDisturbanceObserver,
}


def names() -> list[str]:
    """Return the names of all baselines."""
    return sorted(_BUILDERS)


def make(name: str, scenario: Scenario, num_craft: int = 1, **gains: Any) -> Baseline:
    """Build a baseline.

    Parameters
    ----------
    name
        One of :func:`names`.
    scenario
        The task.
    num_craft
        Number of craft.
    **gains
        Parameters of the law; see its class.

    Raises
    ------
    ValueError
        If the name or a gain is unknown, or a gain breaks a rule.
    """
    require(name in _BUILDERS, "baseline", f"must be one of {names()}", name)
    try:
        return _BUILDERS[name](scenario, num_craft, **gains)
    except TypeError as error:
        raise ValueError(f"gains of {name}: {error}") from None


def defaults(name: str) -> dict[str, Any]:
    """Return the default gains of a baseline, by name.

    Raises
    ------
    ValueError
        If the name is unknown.
    """
    require(name in _BUILDERS, "baseline", f"must be one of {names()}", name)
    gains: dict[str, Any] = {}
    for law in reversed(_BUILDERS[name].__mro__):
        for parameter in inspect.signature(law.__init__).parameters.values():  # type: ignore[misc]
            if parameter.default is not parameter.empty and parameter.name != "num_craft":
                gains[parameter.name] = parameter.default
    return gains


__all__ = [
    "Baseline",
    "BaselinePolicy",
    "FaultEstimate",
    "as_action",
    "defaults",
    "make",
    "measurement_of",
    "names",
]
