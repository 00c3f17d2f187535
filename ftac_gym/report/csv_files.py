"""The numbers of the report as CSV files."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ftac_gym.evaluation.compare import fault_classes
from ftac_gym.evaluation.metrics import UNITS
from ftac_gym.evaluation.statistics import Estimate
from ftac_gym.report.results import Results

_INTERVAL = ("value", "low", "high", "episodes")


def write_csv(results: Results, folder: Path) -> None:
    """Write ``summary.csv``, ``differences.csv``, ``improvement.csv``, ``by_fault.csv`` and ``episodes.csv``.

    Numbers are written in full, those of single episodes to six digits.
    """
    entry = ("split", "entry", "role", "tier")
    _write(folder / "summary.csv", (*entry, "metric", *_INTERVAL, "seeds"), _summary(results))
    _write(folder / "differences.csv", (*entry, "reference", "metric", *_INTERVAL, "seeds"), _differences(results))
    _write(folder / "improvement.csv", ("split", "metric", "first", "second", *_INTERVAL), _improvement(results))
    columns = ("split", "faults", "episodes", "entry", "mean_success", "median_settling_time")
    _write(folder / "by_fault.csv", columns, _by_fault(results))
    metrics = _known_metrics(results)
    heading = ("split", "entry", "seed", "episode", "faults", "feasible", *metrics)
    _write(folder / "episodes.csv", heading, _episodes(results, metrics))


def _write(path: Path, heading: Sequence[str], rows: Iterable[Sequence[Any]]) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(heading)
        writer.writerows(rows)


def _interval(item: Estimate) -> tuple[float, float, float, int]:
    return item.value, item.low, item.high, item.count


def _summary(results: Results) -> Iterator[Sequence[Any]]:
    for split, rows in results.rows.items():
        for entry in results.benchmark.entries:
            for metric, item in rows[entry.name].estimates.items():
                seeds = len(entry.policies)
                yield split, entry.name, entry.role, entry.tier, metric, *_interval(item), seeds


def _differences(results: Results) -> Iterator[Sequence[Any]]:
    reference = results.benchmark.reference
    for split, rows in results.rows.items():
        for entry in results.benchmark.entries:
            for metric, item in rows[entry.name].differences.items():
                seeds = len(entry.policies)
                yield split, entry.name, entry.role, entry.tier, reference, metric, *_interval(item), seeds


def _improvement(results: Results) -> Iterator[Sequence[Any]]:
    for metric, chances in results.improvement.items():
        for (first, second), item in chances.items():
            yield results.main, metric, first, second, *_interval(item)


def _by_fault(results: Results) -> Iterator[Sequence[Any]]:
    for item in results.faults:
        for name, tally in item.tallies.items():
            yield item.split, item.kind, item.episodes, name, tally.success, tally.settling_time


def _known_metrics(results: Results) -> list[str]:
    """Return the metrics that some episode has."""
    flown = [item for runs in results.benchmark.evaluations.values() for seeds in runs.values() for item in seeds]
    return [
        name for name in UNITS if any(name in item.metrics and not np.isnan(item.metrics[name]).all() for item in flown)
    ]


def _episodes(results: Results, metrics: Sequence[str]) -> Iterator[Sequence[Any]]:
    for split, episodes in results.benchmark.episodes.items():
        described = list(zip(fault_classes(episodes).tolist(), episodes.feasible.tolist(), strict=True))
        for name, seeds in results.benchmark.evaluations[split].items():
            for seed, item in enumerate(seeds):
                columns = zip(*(item.metrics[metric].tolist() for metric in metrics), strict=True)
                for index, (what, row) in enumerate(zip(described, columns, strict=True)):
                    yield split, name, seed, index, *what, *[f"{value:.6g}" for value in row]
