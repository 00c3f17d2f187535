"""The numbers of the report."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, product

import numpy as np

from ftac_gym.evaluation import statistics
from ftac_gym.evaluation.benchmark import Benchmark
from ftac_gym.evaluation.entries import Entry
from ftac_gym.evaluation.metrics import HIGHER_IS_BETTER
from ftac_gym.evaluation.profiles import Curve, performance_profile
from ftac_gym.evaluation.rows import RECOVERED, Row, column_difference, column_estimate, headlines
from ftac_gym.evaluation.statistics import Estimate
from ftac_gym.evaluation.tables import episode_classes, judgement, ordered
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, require

METRICS = (
    "availability",
    "success",
    "settling_time",
    RECOVERED,
    "ape_95",
    "integrated_error",
    "energy",
    "chatter",
)
"""Columns of the tables: of shares the mean, of the others the interquartile mean."""

RELATIVE = "settling_time_relative"
"""A difference besides those of the metrics: the interquartile mean of settling times over the reference's, less 1."""

BY_SPLIT = ("availability", "success", "settling_time")
"""Metrics that are shown split by split."""

COMPARED = ("settling_time", "success")
"""Metrics with a probability of improvement."""

BEST, BEST_AGENTS = 10, 6
"""Numbers of the best entries, and of the best agents besides, with a look of their own in crowded figures."""

_MOMENTS = 121
"""Times at which profiles are drawn."""


@dataclass(frozen=True, eq=False)
class FaultClass:
    """The episodes of a split with one kind of fault.

    Attributes
    ----------
    split, kind, episodes
        The split, the kind, and the number of episodes.
    availability, success, settling_time
        Mean availability and success, and median settling time [s], by entry.
    """

    split: str
    kind: str
    episodes: int
    availability: Mapping[str, float]
    success: Mapping[str, float]
    settling_time: Mapping[str, float]


@dataclass(frozen=True, eq=False)
class Results:
    """All numbers of the report except those of single episodes; over feasible episodes unless stated otherwise.

    Attributes
    ----------
    benchmark
        The benchmark.
    main
        The split of the tables and figures that show one: the first that has feasible episodes.
    ranked
        The entries, the best in the main split first.
    shown
        Entries with a look of their own in crowded figures.
    compared
        Those of them that are no oracles: their probabilities of improvement are estimated.
    rows
        By split, then by entry: estimates, and paired differences to the reference.
    faults
        Results by kind of fault.
    improvement
        By metric, then by pair of compared entries: the probability that the first is better than the second in an
        episode of the main split.
    profiles
        By split, then by entry: the share of settled episodes against time [s].
    """

    benchmark: Benchmark
    main: str
    ranked: tuple[Entry, ...]
    shown: tuple[str, ...]
    compared: tuple[str, ...]
    rows: Mapping[str, Mapping[str, Row]]
    faults: tuple[FaultClass, ...]
    improvement: Mapping[str, Mapping[tuple[str, str], Estimate]]
    profiles: Mapping[str, Mapping[str, Curve]]

    def entries(self, *groups: str) -> list[Entry]:
        """Return the entries of some groups, the best first; all if none is given."""
        return [entry for entry in self.ranked if not groups or group(entry) in groups]

    @property
    def order(self) -> list[str]:
        """Names of the entries, the best first."""
        return [entry.name for entry in self.ranked]

    @property
    def scenario(self) -> Scenario:
        """The scenario of the main split."""
        return Scenario.from_json(self.benchmark.episodes[self.main].scenario_json)

    def judgements(self, names: Iterable[str], splits: Iterable[str], metric: str) -> Counter[str]:
        """Count the differences to the reference that are "better", "worse", or neither ("")."""
        pairs = product(names, splits)
        return Counter(judgement(metric, self.rows[split][name].differences[metric]) for name, split in pairs)


def group(entry: Entry) -> str:
    """Return the table in which an entry stands: "oracles", or its tier."""
    return "oracles" if entry.role == "oracle" else entry.tier


def values(benchmark: Benchmark, split: str, entry: str, metric: str) -> FloatArray:
    """Return a metric of an entry, (seeds, N) over all episodes of the split."""
    return np.array([item.metrics[metric] for item in benchmark.evaluations[split][entry]], dtype=np.float64)


def feasible_values(benchmark: Benchmark, split: str, entry: str, metric: str) -> FloatArray:
    """Return a metric of an entry, (seeds, N) over the feasible episodes of the split."""
    return values(benchmark, split, entry, metric)[:, benchmark.episodes[split].feasible]


def gather(benchmark: Benchmark) -> Results:
    """Return all numbers.

    Raises
    ------
    ValueError
        If the reference is not among the entries, or two entries have one name.
    """
    names, reference = [entry.name for entry in benchmark.entries], benchmark.reference
    require(len(set(names)) == len(names), "entries", "must have names that differ", names)
    require(reference in names, "reference", f"must be one of {names}", reference)
    splits = list(benchmark.episodes)
    feasible = [split for split in splits if benchmark.episodes[split].feasible.any()]
    main = (feasible or splits)[0]
    rows = {split: {name: _row(benchmark, split, name) for name in names} for split in splits}
    ranked = sorted(benchmark.entries, key=lambda entry: _rank(rows[main][entry.name]))
    oracles = [entry.name for entry in ranked if entry.role == "oracle"]
    policies = [entry.name for entry in ranked if entry.role != "oracle"]
    agents = [entry.name for entry in ranked if entry.role != "oracle" and entry.kind == "agent"]
    chosen = {*policies[:BEST], *agents[:BEST_AGENTS], *oracles[:1], reference}
    compared = tuple(name for name in policies if name in chosen)
    return Results(
        benchmark=benchmark,
        main=main,
        ranked=tuple(ranked),
        shown=tuple(entry.name for entry in ranked if entry.name in chosen),
        compared=compared,
        rows=rows,
        faults=tuple(item for split in splits for item in _by_fault(benchmark, split, names)),
        improvement={metric: _improvement(benchmark, main, metric, compared) for metric in COMPARED},
        profiles={
            split: {name: _profile(benchmark, split, name, name in chosen) for name in names} for split in feasible
        },
    )


def _row(benchmark: Benchmark, split: str, name: str) -> Row:
    runs, chosen = benchmark.evaluations[split], benchmark.episodes[split].feasible
    estimates, differences = {}, {}
    for metric in METRICS:
        estimates[metric] = column_estimate(runs[name], metric, chosen)
        if name != benchmark.reference:
            differences[metric] = column_difference(runs[name], runs[benchmark.reference], metric, chosen)
    if name != benchmark.reference:
        own, base = (feasible_values(benchmark, split, item, "settling_time") for item in (name, benchmark.reference))
        differences[RELATIVE] = statistics.relative_difference(own, base)
    return Row(name, estimates, differences, headlines(runs[name]))


def _rank(row: Row) -> tuple[float, float]:
    success, settling = row.estimates["success"].value, row.estimates["settling_time"].value
    return (-success, settling) if np.isfinite([success, settling]).all() else (1.0, 0.0)


def _by_fault(benchmark: Benchmark, split: str, names: Sequence[str]) -> Iterator[FaultClass]:
    kinds = episode_classes(benchmark.episodes[split])
    for kind in ordered(kinds):
        chosen = kinds == kind
        availability, success, settling = (
            {name: values(benchmark, split, name, metric)[:, chosen] for name in names}
            for metric in ("availability", "success", "settling_time")
        )
        yield FaultClass(
            split,
            kind,
            int(chosen.sum()),
            {name: float(item.mean()) for name, item in availability.items()},
            {name: float(item.mean()) for name, item in success.items()},
            {name: float(np.median(item)) for name, item in settling.items()},
        )


def _improvement(
    benchmark: Benchmark, split: str, metric: str, names: Sequence[str]
) -> dict[tuple[str, str], Estimate]:
    data = {name: feasible_values(benchmark, split, name, metric) for name in names}
    found = {}
    for first, second in combinations(names, 2):
        item = statistics.probability_of_improvement(data[first], data[second], metric not in HIGHER_IS_BETTER)
        found[first, second] = item
        # A tie counts half: both probabilities add up to one.
        found[second, first] = replace(item, value=1.0 - item.value, low=1.0 - item.high, high=1.0 - item.low)
    return found


def _profile(benchmark: Benchmark, split: str, name: str, band: bool) -> Curve:
    """Return the share of settled episodes against time, without a band if none is drawn."""
    # Without settling, the settling time is the duration: the last moment is before it.
    duration = Scenario.from_json(benchmark.episodes[split].scenario_json).duration
    moments = np.linspace(0.0, duration, _MOMENTS)[:-1]
    times = feasible_values(benchmark, split, name, "settling_time")
    if band:
        return performance_profile(times, moments, smaller_is_better=True)
    share = (times.ravel() <= moments[:, None]).mean(axis=1)
    return Curve(moments, share, share, share, times.shape[1])
