"""Objectives of the tuner: means of a metric over the episodes of a search, by the gains of a baseline."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from ftac_gym import baselines
from ftac_gym.baselines.gains import SearchSpace
from ftac_gym.evaluation.episodes import judging_episodes
from ftac_gym.evaluation.metrics import Metrics
from ftac_gym.evaluation.rollout import rollout
from ftac_gym.policies import DeferredBaseline
from ftac_gym.scenarios import frozen
from ftac_gym.task.episodes import Episodes
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, require, whole

DIGITS = 4
"""Significant digits of the gains that are flown and stored."""
OBJECTIVES = ("availability", "success", "return")
"""Objectives that a search may have: the mean of the metric of that name, which is better if it is larger."""
FAILED = -math.inf
"""Value of gains that the baseline refuses or that blow up. CMA-ES only ranks, so it means "last"."""


@dataclass(frozen=True)
class Search:
    """A baseline to tune, with the objective and the episodes to tune it on.

    Episodes that are labelled infeasible count too. Gains then do not depend on the rule of the label.

    Parameters
    ----------
    baseline
        Name of a baseline.
    scenario
        The task.
    episodes
        Episodes that all gains fly.
    seed
        Seed of those episodes; not one that is reserved for frozen episodes.
    sampler_seed
        Seed of CMA-ES.
    objective
        One of :data:`OBJECTIVES`, whose mean over the episodes is the value of gains.
    first
        Gains of the first trial: ``"default"`` or ``"tuned"``. The search begins in the middle of all ranges, or at the
        tuned gains.

    Raises
    ------
    ValueError
        If the baseline is unknown, has fewer than two gains to search or does not fit the scenario. If the objective is
        unknown, the seed is reserved, or too few episodes are feasible for a validation.
    """

    baseline: str
    scenario: Scenario
    episodes: int = 300
    seed: int = 800_000
    sampler_seed: int = 0
    objective: str = "availability"
    first: str = "default"

    def __post_init__(self) -> None:
        """Check the fields."""
        require(self.objective in OBJECTIVES, "objective", f"must be one of {list(OBJECTIVES)}", self.objective)
        require(self.first in baselines.GAINS, "first", f"must be one of {list(baselines.GAINS)}", self.first)
        require(len(self.space) > 1, "baseline", "must have at least two gains to search", self.baseline)
        baselines.build(self.baseline, self.scenario)
        whole(self.episodes, 1, "episodes")
        whole(self.sampler_seed, 0, "sampler_seed")
        frozen.check_free(whole(self.seed, 0, "seed"))
        self.validation()

    def training(self) -> Episodes:
        """Return the episodes that all gains fly."""
        return _drawn(self.scenario.to_json(), self.seed, self.episodes)

    def validation(self) -> Episodes:
        """Return validation episodes, which check the result: as many feasible ones as the search flies episodes.

        The frozen list of a split ends at its length.
        """
        return _validation(self.scenario.to_json(), min(self.episodes, frozen.FEASIBLE))

    @property
    def space(self) -> SearchSpace:
        """Ranges of the gains."""
        return baselines.search_space(self.baseline)

    @property
    def population(self) -> int:
        """Candidates of a generation: the usual number for CMA-ES, made even so that two workers share it equally."""
        usual = 4 + int(3.0 * math.log(len(self.space)))
        return usual + usual % 2

    @property
    def setting(self) -> dict[str, Any]:
        """Settings that must be the same when a study is resumed."""
        space = {name: [item.low, item.high, item.log] for name, item in self.space.items()}
        return {**vars(self), "scenario": self.scenario.to_json(), "population": self.population, "space": space}

    def gains_at(self, point: Mapping[str, float]) -> dict[str, Any]:
        """Return the gains at a point of the space, rounded: the same numbers are flown and stored."""
        gains: dict[str, Any] = _rounded(baselines.baseline_class(self.baseline).gains_at(point))
        return gains

    def point_at(self, shares: FloatArray) -> dict[str, float]:
        """Return the point of the space at shares (k,) of its ranges, within [0, 1]."""
        point = {}
        for (name, item), share in zip(self.space.items(), shares.tolist(), strict=True):
            linear = item.low + share * (item.high - item.low)
            point[name] = item.low * (item.high / item.low) ** share if item.log else linear
        return point

    def shares_at(self, point: Mapping[str, float]) -> FloatArray:
        """Return the shares (k,) of its ranges at which a point of the space lies: the inverse of :meth:`point_at`."""
        shares = []
        for name, item in self.space.items():
            value = point[name]
            ratio = math.log(value / item.low) / math.log(item.high / item.low) if item.log else math.nan
            shares.append(ratio if item.log else (value - item.low) / (item.high - item.low))
        return np.array(shares)

    def start(self) -> dict[str, float]:
        """Return the first gains as a point; a gain outside its range, or without a value, in the middle."""
        point = self.point_at(np.full(len(self.space), 0.5))
        known = baselines.baseline_class(self.baseline).point_of(
            {**baselines.defaults(self.baseline), **baselines.chosen(self.baseline, self.first, {})}
        )
        inside = {name for name, item in self.space.items() if item.low <= known.get(name, math.nan) <= item.high}
        return {name: known[name] if name in inside else middle for name, middle in point.items()}


def _rounded(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {name: _rounded(item) for name, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_rounded(item) for item in value]
    return float(f"{value:.{DIGITS}g}") if isinstance(value, float) else value


@lru_cache(maxsize=4)
def _drawn(scenario: str, seed: int, count: int) -> Episodes:
    return Scenario.from_json(scenario).draw(seed, count)


@lru_cache(maxsize=4)
def _validation(scenario: str, feasible: int) -> Episodes:
    return judging_episodes(Scenario.from_json(scenario), feasible, "validation")


def fly(search: Search, gains: Mapping[str, Any], episodes: Episodes | None = None) -> Metrics:
    """Return the metrics of gains over the episodes given, by default those of the search.

    Empty gains are the baseline's own.
    """
    episodes = search.training() if episodes is None else episodes
    return rollout(search.scenario, DeferredBaseline(search.baseline, **gains), episodes).metrics()


def value_of(search: Search, gains: Mapping[str, Any]) -> float:
    """Return the mean objective of gains over the episodes; :data:`FAILED` if they cannot be flown."""
    try:
        # Extreme gains may overflow: that is a valid result of a trial.
        with np.errstate(all="ignore"):
            value = float(fly(search, gains)[search.objective].mean())
    except (ValueError, ArithmeticError):
        return FAILED
    return value if math.isfinite(value) else FAILED
