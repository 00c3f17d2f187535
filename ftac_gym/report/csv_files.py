"""The numbers of the report as CSV files."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ftac_gym.evaluation.files import RECOVERY_COLUMNS, recovery_rows, write_rows
from ftac_gym.evaluation.metrics import UNITS
from ftac_gym.evaluation.rows import fault_classes
from ftac_gym.evaluation.statistics import Estimate
from ftac_gym.report.results import Results

_INTERVAL = ("value", "low", "high", "episodes", "defined", "total")
"""Columns of an estimate; of the last two, see :class:`~ftac_gym.evaluation.statistics.Estimate`."""


def write_csv(results: Results, folder: Path) -> None:
    """Write the CSV files: summary, differences, improvement, by_fault, episodes and recoveries.

    Numbers are written in full, those of single episodes to six digits.
    """
    tables = {
        "summary": _estimates(results, ("estimates", "drawn")),
        "differences": _estimates(results, ("differences",), reference=results.benchmark.reference),
        "improvement": _improvement(results),
        "by_fault": _by_fault(results),
        "episodes": _episodes(results),
        "recoveries": _recoveries(results),
    }
    for name, rows in tables.items():
        write_rows(folder / f"{name}.csv", rows)


def _interval(item: Estimate) -> tuple[float, float, float, int, int, int]:
    return item.value, item.low, item.high, item.count, item.defined, item.total


def _estimates(results: Results, kinds: Sequence[str], **labels: str) -> Iterator[Sequence[Any]]:
    """Yield a heading, and the estimates or the differences of all entries; further columns before the metric."""
    yield "split", "entry", "role", "tier", *labels, "over", "metric", *_INTERVAL, "seeds"
    for split, rows in results.rows.items():
        for entry in results.benchmark.entries:
            described = split, entry.name, entry.role, entry.tier, *labels.values()
            for kind in kinds:
                over = "drawn" if kind == "drawn" else "feasible"
                for metric, item in getattr(rows[entry.name], kind).items():
                    yield *described, over, metric, *_interval(item), len(entry.policies)


def _improvement(results: Results) -> Iterator[Sequence[Any]]:
    yield "split", "metric", "first", "second", *_INTERVAL
    for metric, chances in results.improvement.items():
        for (first, second), item in chances.items():
            yield results.main, metric, first, second, *_interval(item)


def _by_fault(results: Results) -> Iterator[Sequence[Any]]:
    yield "split", "faults", "episodes", "entry", "mean_availability", "mean_success", "median_settling_time"
    for item in results.faults:
        for name, success in item.success.items():
            means = item.availability[name], success
            yield item.split, item.kind, item.episodes, name, *means, item.settling_time[name]


def _episodes(results: Results) -> Iterator[Sequence[Any]]:
    """Yield a heading and one row per episode, with the metrics that some episode has."""
    flown = [item for runs in results.benchmark.evaluations.values() for seeds in runs.values() for item in seeds]
    metrics = [
        name for name in UNITS if any(name in item.metrics and not np.isnan(item.metrics[name]).all() for item in flown)
    ]
    yield "split", "entry", "seed", "episode", "faults", "feasible", *metrics
    for split, episodes in results.benchmark.episodes.items():
        described = list(zip(fault_classes(episodes).tolist(), episodes.feasible.tolist(), strict=True))
        for name, seeds in results.benchmark.evaluations[split].items():
            for seed, item in enumerate(seeds):
                columns = zip(*(item.metrics[metric].tolist() for metric in metrics), strict=True)
                for index, (labels, row) in enumerate(zip(described, columns, strict=True)):
                    yield split, name, seed, index, *labels, *[f"{value:.6g}" for value in row]


def _recoveries(results: Results) -> Iterator[Sequence[Any]]:
    """Yield a heading and one row for each fault that occurs on target."""
    yield "split", "entry", "seed", *RECOVERY_COLUMNS
    for split, runs in results.benchmark.evaluations.items():
        for name, seeds in runs.items():
            for seed, item in enumerate(seeds):
                yield from recovery_rows(item, split, name, seed)
