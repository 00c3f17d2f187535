"""Tables of evaluations as cells of text, for a terminal or for Markdown."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt

from ftac_gym.evaluation.batches import Evaluation
from ftac_gym.evaluation.metrics import HIGHER_IS_BETTER, UNITS, share_of
from ftac_gym.evaluation.rows import ALWAYS_ONLY, Row, fault_classes
from ftac_gym.evaluation.statistics import Estimate
from ftac_gym.faults import FaultKind
from ftac_gym.task.episodes import Episodes

INFEASIBLE = "infeasible"

Cells = list[list[str]]
"""Rows of a table, the headings first."""


def short(value: float) -> str:
    """Format a number with three digits, or all digits before the point."""
    return f"{value:.0f}" if abs(value) >= 1000.0 else f"{value:.3g}"


def number(value: Estimate) -> str:
    """Format an estimate with its interval, and the number of its values if the metric is not defined for all."""
    known = share_of(value.defined, value.total)
    return f"{short(value.value)} [{short(value.low)}, {short(value.high)}]{known}" if value.count else "-"


def judgement(metric: str, difference: Estimate) -> str:
    """Return "better" or "worse" for a difference whose interval excludes zero, else nothing."""
    if not difference.excludes_zero or not difference.count:
        return ""
    return "better" if (difference.value > 0.0) == (metric in HIGHER_IS_BETTER) else "worse"


def verdict(metric: str, difference: Estimate) -> str:
    """Format a difference with its judgement."""
    return f"{number(difference)} {judgement(metric, difference)}".rstrip()


def metric_tables(rows: Sequence[Row], reference: str) -> tuple[Cells, Cells]:
    """Return estimates and paired differences to a reference: metrics down, policies across."""
    metrics = list(rows[0].estimates)
    heading = [f"{metric.replace('_', ' ')} [{UNITS.get(metric, '-')}]" for metric in metrics]
    estimates = [["policy", *heading]]
    differences = [[f"minus {reference}", *heading]]
    for row in rows:
        estimates.append([row.policy, *(number(row.estimates[metric]) for metric in metrics)])
        if row.differences:
            differences.append([row.policy, *(verdict(metric, row.differences[metric]) for metric in metrics)])
    return transposed(estimates), transposed(differences)


def kind_table(evaluations: Mapping[str, Sequence[Evaluation]], episodes: Mapping[str, Episodes]) -> Cells:
    """Return mean success and median settling time by scenario and fault class, infeasible episodes apart.

    Parameters
    ----------
    evaluations
        One per policy, by scenario.
    episodes
        The episodes of each scenario.
    """
    cells = [["scenario", "faults", "episodes", *(item.policy for item in next(iter(evaluations.values())))]]
    for name, items in evaluations.items():
        classes = episode_classes(episodes[name])
        for kind in ordered(classes):
            chosen = classes == kind
            cells.append([name, kind, str(int(chosen.sum())), *(_at_a_glance(item, chosen) for item in items)])
    return cells


def episode_classes(episodes: Episodes) -> npt.NDArray[np.str_]:
    """Return the fault class of each episode (N,); "infeasible" where the remaining wheels cannot do the task."""
    return np.where(episodes.feasible, fault_classes(episodes), INFEASIBLE)


def ordered(labels: npt.NDArray[np.str_]) -> list[str]:
    """Return the distinct labels: episodes without a random fault first, infeasible ones last."""
    first = (FaultKind.NONE.label, ALWAYS_ONLY)
    return sorted(set(labels.tolist()), key=lambda kind: (kind == INFEASIBLE, kind not in first, kind))


def _at_a_glance(item: Evaluation, chosen: npt.NDArray[np.bool_]) -> str:
    """Return mean success and median settling time over some episodes."""
    success, settling = item.metrics["success"][chosen].mean(), item.metrics["settling_time"][chosen]
    return f"{success:.2f}, {np.median(settling):.1f} s"


def split_table(rows: Mapping[str, Sequence[Row]], episodes: Mapping[str, Episodes]) -> Cells:
    """Return success, settling time and integrated error by scenario, over its feasible episodes.

    Parameters
    ----------
    rows
        Estimates of each policy, by scenario.
    episodes
        As for :func:`kind_table`.
    """
    cells = [["scenario", "feasible", "infeasible", *(row.policy for row in next(iter(rows.values())))]]
    for name, items in rows.items():
        feasible = int(episodes[name].feasible.sum())
        cells.append([name, str(feasible), str(len(episodes[name]) - feasible), *map(_main_metrics, items)])
    return cells


def _main_metrics(row: Row) -> str:
    """Return success with its interval, settling time and integrated error."""
    settling, integrated = row.estimates["settling_time"].value, row.estimates["integrated_error"].value
    return f"{number(row.estimates['success'])}, {settling:.1f} s, {integrated:.0f} deg s"


def transposed(cells: Cells) -> Cells:
    """Exchange rows and columns."""
    return [list(column) for column in zip(*cells, strict=True)]


def markdown(cells: Cells) -> str:
    """Format cells as a Markdown table."""
    heading, *rows = ([cell.replace("|", "\\|") for cell in row] for row in cells)
    lines = ["| " + " | ".join(heading) + " |", "|" + "---|" * len(heading)]
    lines += ["| " + " | ".join(row) + " |" for row in rows]
    return "\n".join(lines)
