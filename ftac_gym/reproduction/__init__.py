"""Reproductions of papers: their claims, beside numbers from flights under their equations.

Each paper is a folder: ``plans()`` returns its flights, ``evaluate(flights)`` the verdicts, studies and figures.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from ftac_gym.reproduction.cao_2022 import plans as cao_2022_plans
from ftac_gym.reproduction.cao_2022 import report as cao_2022
from ftac_gym.reproduction.chen_2018 import plans as chen_2018_plans
from ftac_gym.reproduction.chen_2018 import report as chen_2018
from ftac_gym.reproduction.li_2023 import plans as li_2023_plans
from ftac_gym.reproduction.li_2023 import report as li_2023
from ftac_gym.reproduction.ma_2023 import plans as ma_2023_plans
from ftac_gym.reproduction.ma_2023 import report as ma_2023
from ftac_gym.reproduction.recorder import Plan, Recordings
from ftac_gym.reproduction.verdicts import Reproduction
from ftac_gym.reproduction.zhang_zhou_2019 import plans as zhang_zhou_2019_plans
from ftac_gym.reproduction.zhang_zhou_2019 import report as zhang_zhou_2019


class Paper(NamedTuple):
    """Reproduction of a paper: its flights, and the results from them."""

    plans: Callable[[], dict[str, Plan]]
    evaluate: Callable[[Recordings], Reproduction]


PAPERS: dict[str, Paper] = {
    "cao_2022": Paper(cao_2022_plans.plans, cao_2022.evaluate),
    "chen_2018": Paper(chen_2018_plans.plans, chen_2018.evaluate),
    "li_2023": Paper(li_2023_plans.plans, li_2023.evaluate),
    "ma_2023": Paper(ma_2023_plans.plans, ma_2023.evaluate),
    "zhang_zhou_2019": Paper(zhang_zhou_2019_plans.plans, zhang_zhou_2019.evaluate),
}
"""Papers by name."""

__all__ = ["PAPERS", "Paper"]
