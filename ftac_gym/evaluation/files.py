"""CSV files of comparisons."""

import csv
from collections.abc import Sequence
from pathlib import Path

from ftac_gym.evaluation.batches import Evaluation
from ftac_gym.evaluation.compare import Row, fault_classes
from ftac_gym.evaluation.metrics import UNITS
from ftac_gym.task.episodes import Episodes


def write_episodes(path: Path, evaluations: Sequence[Evaluation], episodes: Episodes) -> None:
    """Write one line per policy and episode."""
    names = fault_classes(episodes)
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["policy", "episode", "faults", "feasible", *UNITS])
        for item in evaluations:
            for index in range(len(episodes)):
                values = [f"{item.metrics[metric][index]:.6g}" for metric in UNITS]
                writer.writerow([item.policy, index, names[index], bool(episodes.feasible[index]), *values])


def write_summary(path: Path, rows: Sequence[Row]) -> None:
    """Write one line per policy, metric and kind of estimate."""
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["policy", "metric", "kind", "value", "low", "high", "episodes"])
        for row in rows:
            for kind, values in (("estimate", row.estimates), ("difference", row.differences)):
                for metric, item in values.items():
                    writer.writerow([row.policy, metric, kind, item.value, item.low, item.high, item.count])
