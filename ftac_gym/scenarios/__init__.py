"""The library of scenarios, by name."""

from __future__ import annotations

from collections.abc import Callable

from ftac_gym.scenarios import chen_2018, li_2023, ma_2023, splits, zhang_zhou_2019
from ftac_gym.scenarios.cao_2022 import cao_2022
from ftac_gym.scenarios.flagship import flagship, flagship_pointing, flagship_tracking
from ftac_gym.scenarios.flexible import flexible
from ftac_gym.scenarios.shen_2019 import shen_2019
from ftac_gym.scenarios.splits import SPLITS
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import require

_BUILDERS: dict[str, Callable[[], Scenario]] = {
    "flagship": flagship,
    "flagship_severe": splits.flagship_severe,
    "flagship_unseen": splits.flagship_unseen,
    "flagship_double": splits.flagship_double,
    "flagship_plant": splits.flagship_plant,
    "flagship_hardware": splits.flagship_hardware,
    "flagship_pointing": flagship_pointing,
    "flagship_tracking": flagship_tracking,
    "flexible": flexible,
    "shen_2019": shen_2019,
    "zhang_zhou_2019": zhang_zhou_2019.zhang_zhou_2019,
    "zhang_zhou_2019_2nm": zhang_zhou_2019.zhang_zhou_2019_2nm,
    "zhang_zhou_2019_feasible": zhang_zhou_2019.zhang_zhou_2019_feasible,
    "zhang_zhou_2019_stabilisation": zhang_zhou_2019.zhang_zhou_2019_stabilisation,
    "cao_2022": cao_2022,
    "li_2023": li_2023.li_2023,
    "li_2023_weak": li_2023.li_2023_weak,
    "li_2023_printed_start": li_2023.li_2023_printed_start,
    "ma_2023_faulty": ma_2023.ma_2023_faulty,
    "ma_2023_unwinding": ma_2023.ma_2023_unwinding,
    "chen_2018": chen_2018.chen_2018,
    "chen_2018_rate_torque": chen_2018.chen_2018_rate_torque,
}

__all__ = ["SPLITS", "get", "names"]


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
