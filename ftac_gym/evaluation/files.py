"""Files of comparisons, each complete or absent."""

import csv
import io
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ftac_gym.evaluation.batches import Evaluation
from ftac_gym.evaluation.metrics import UNITS
from ftac_gym.evaluation.rows import Row, fault_classes
from ftac_gym.faults import label_of
from ftac_gym.task.episodes import Episodes
from ftac_gym.utils.files import replacing, write_text

CsvRows = Iterable[Sequence[Any]]
"""Rows of a CSV file, the headings first."""


RECOVERY_COLUMNS = ("episode", "fault", "onset", "time", "recovered", "peak")
"""Columns of files of recoveries, of the fields of :class:`~ftac_gym.evaluation.metrics.Recoveries`."""


def write_rows(path: Path, rows: CsvRows) -> None:
    """Write a CSV file."""
    text = io.StringIO(newline="")
    csv.writer(text).writerows(rows)
    write_text(path, text.getvalue())


def write_figure(path: Path, figure: Any, dpi: int) -> None:
    """Write a figure of Matplotlib in the format of the path's suffix."""
    with replacing(path) as file:
        figure.savefig(file, format=path.suffix[1:], dpi=dpi)


def write_episodes(path: Path, evaluations: Sequence[Evaluation], episodes: Episodes) -> None:
    """Write one line per policy and episode."""
    names = fault_classes(episodes)
    rows: list[Sequence[Any]] = [["policy", "episode", "faults", "feasible", *UNITS]]
    for item in evaluations:
        for index in range(len(episodes)):
            values = [f"{item.metrics[metric][index]:.6g}" for metric in UNITS]
            rows.append([item.policy, index, names[index], bool(episodes.feasible[index]), *values])
    write_rows(path, rows)


def recovery_rows(evaluation: Evaluation, *labels: object) -> Iterator[list[object]]:
    """Yield a row for each fault that occurs on target, after some labels: see :data:`RECOVERY_COLUMNS`."""
    found = evaluation.recoveries
    for episode, fault in np.argwhere(found.counted).tolist():
        onset, time, peak = (f"{values[episode, fault]:.6g}" for values in (found.onset, found.time, found.peak))
        kind, recovered = label_of(int(found.kind[episode, fault])), bool(found.recovered[episode, fault])
        yield [*labels, episode, kind, onset, time, recovered, peak]


def write_summary(path: Path, rows: Sequence[Row]) -> None:
    """Write one line per policy, metric and kind of estimate."""
    lines: list[Sequence[Any]] = [["policy", "metric", "kind", "value", "low", "high", "episodes", "defined", "total"]]
    for row in rows:
        for kind, values in (("estimate", row.estimates), ("all drawn", row.drawn), ("difference", row.differences)):
            for metric, item in values.items():
                known = item.count, item.defined, item.total
                lines.append([row.policy, metric, kind, item.value, item.low, item.high, *known])
    write_rows(path, lines)
