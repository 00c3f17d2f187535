"""What a tuner searches: the gains of a baseline, and how good they are for the agents' objective."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from ftac_gym import baselines
from ftac_gym.baselines.gains import SearchSpace
from ftac_gym.evaluation.metrics import Metrics
from ftac_gym.evaluation.rollout import BaselineContestant, rollout
from ftac_gym.scenarios import frozen
from ftac_gym.task.episodes import Episodes
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import require

DIGITS = 4
"""Significant digits of the gains that are flown and stored."""
FAILED = -math.inf
"""Mean return of gains that the law refuses or that blow up: CMA-ES only ranks, so this is no more than "last"."""


@dataclass(frozen=True)
class Search:
    """What is tuned, and on what.

    Parameters
    ----------
    baseline
        Name of a baseline.
    scenario
        The task.
    episodes
        Episodes that all gains fly, of which the feasible ones count.
    seed
        Seed of those episodes; the next seed is for checking the result. Neither may belong to frozen test episodes.
    sampler_seed
        Seed of CMA-ES.

    Raises
    ------
    ValueError
        If the baseline is unknown, has fewer than two gains to search or does not fit the scenario, or no episode is
        feasible.
    """

    baseline: str
    scenario: Scenario
    episodes: int = 300
    seed: int = 800_000
    sampler_seed: int = 0

    def __post_init__(self) -> None:
        """Check the fields."""
        require(len(self.space) > 1, "baseline", "must have at least two gains to search", self.baseline)
        baselines.make(self.baseline, self.scenario)
        require(self.episodes > 0, "episodes", "must be positive", self.episodes)
        taken = set(frozen.seeds().values())
        free = not taken & {self.seed, self.seed + 1}
        require(free, "seed", f"and the next must not be of the frozen test episodes, {sorted(taken)}", self.seed)
        feasible = bool(_drawn(self.scenario.to_json(), self.seed, self.episodes).feasible.any())
        require(feasible, "episodes", "must have a feasible one among them", self.episodes)

    @property
    def space(self) -> SearchSpace:
        """Where the gains may lie."""
        return baselines.search_space(self.baseline)

    @property
    def population(self) -> int:
        """Candidates of a generation: the usual number for CMA-ES, made even so that two workers share it equally."""
        usual = 4 + int(3.0 * math.log(len(self.space)))
        return usual + usual % 2

    @property
    def setting(self) -> dict[str, Any]:
        """All that a study must have in common with the one that it goes on with."""
        return {
            "baseline": self.baseline,
            "scenario": self.scenario.to_json(),
            "episodes": self.episodes,
            "seed": self.seed,
            "sampler_seed": self.sampler_seed,
            "population": self.population,
            "space": {name: [item.low, item.high, item.log] for name, item in self.space.items()},
        }

    def gains_at(self, point: Mapping[str, float]) -> dict[str, Any]:
        """Return the gains at a point of the space, rounded: what is flown is what is stored."""
        gains: dict[str, Any] = _rounded(baselines.baseline_class(self.baseline).gains_at(point))
        return gains

    def start(self) -> dict[str, float]:
        """Return where to begin: at the law's own gains; amid the range of a gain that they leave open or out of it."""
        known = baselines.baseline_class(self.baseline).point_of(baselines.defaults(self.baseline))
        point = {}
        for name, item in self.space.items():
            middle = math.sqrt(item.low * item.high) if item.log else 0.5 * (item.low + item.high)
            value = known.get(name, middle)
            point[name] = value if item.low <= value <= item.high else middle
        return point


def _rounded(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {name: _rounded(item) for name, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_rounded(item) for item in value]
    return float(f"{value:.{DIGITS}g}") if isinstance(value, float) else value


@lru_cache(maxsize=4)
def _drawn(scenario: str, seed: int, count: int) -> Episodes:
    return Scenario.from_json(scenario).draw(seed, count)


def fly(search: Search, gains: Mapping[str, Any], seed: int | None = None) -> Metrics:
    """Return the metrics of gains over the feasible episodes of a seed, the search's own by default.

    No gains are the law's own.
    """
    episodes = _drawn(search.scenario.to_json(), search.seed if seed is None else seed, search.episodes)
    history = rollout(search.scenario, BaselineContestant(search.baseline, **gains), episodes)
    return {name: values[episodes.feasible] for name, values in history.metrics().items()}


def mean_return(search: Search, gains: Mapping[str, Any]) -> float:
    """Return the mean return of gains over the feasible episodes; :data:`FAILED` if they cannot be flown."""
    try:
        # Gains far from any good ones may overflow: that is an answer, not an accident.
        with np.errstate(all="ignore"):
            value = float(fly(search, gains)["return"].mean())
    except (ValueError, ArithmeticError):
        return FAILED
    return value if math.isfinite(value) else FAILED
