"""Tables of evaluations as cells of text, for a terminal or for Markdown."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ftac_gym.evaluation.compare import Evaluation, Row, fault_classes
from ftac_gym.evaluation.metrics import HIGHER_IS_BETTER, UNITS
from ftac_gym.evaluation.statistics import Estimate
from ftac_gym.task.episodes import Episodes

Cells = list[list[str]]
"""Rows of a table, the headings first."""


def number(value: Estimate) -> str:
    """Format an estimate with its interval."""
    if not value.count:
        return "-"
    point, low, high = (
        f"{item:.0f}" if abs(item) >= 1000.0 else f"{item:.3g}" for item in (value.value, value.low, value.high)
    )
    return f"{point} [{low}, {high}]"


def verdict(metric: str, difference: Estimate) -> str:
    """Format a difference; one whose interval excludes zero is called better or worse."""
    if not difference.excludes_zero or not difference.count:
        return number(difference)
    better = (difference.value > 0.0) == (metric in HIGHER_IS_BETTER)
    return f"{number(difference)} {'better' if better else 'worse'}"


def metric_tables(rows: Sequence[Row], reference: str) -> tuple[Cells, Cells]:
    """Return the table of estimates and that of paired differences to a reference: metrics down, policies across."""
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
    """Return mean success and median settling time by scenario and by what is wrong, infeasible episodes apart.

    Parameters
    ----------
    evaluations
        One per policy, by scenario.
    episodes
        What they flew, by scenario.
    """
    policies = [item.policy for item in next(iter(evaluations.values()))]
    cells = [["scenario", "faults", "episodes", *policies]]
    for name, items in evaluations.items():
        classes = np.where(episodes[name].feasible, fault_classes(episodes[name]), "infeasible")
        order = sorted(set(classes.tolist()), key=lambda kind: (kind == "infeasible", kind != "healthy", kind))
        for kind in order:
            chosen = classes == kind
            row = [name, kind, str(int(chosen.sum()))]
            for item in items:
                success, settling = item.metrics["success"][chosen].mean(), item.metrics["settling_time"][chosen]
                row.append(f"{success:.2f}, {np.median(settling):.1f} s")
            cells.append(row)
    return cells


def split_table(rows: Mapping[str, Sequence[Row]], episodes: Mapping[str, Episodes]) -> Cells:
    """Return success, settling time and integrated error by scenario, over its feasible episodes.

    Parameters
    ----------
    rows
        One per policy, by scenario.
    episodes
        What they flew, by scenario.
    """
    policies = [row.policy for row in next(iter(rows.values()))]
    cells = [["scenario", "feasible", "infeasible", *policies]]
    for name, items in rows.items():
        feasible = int(episodes[name].feasible.sum())
        row = [name, str(feasible), str(len(episodes[name]) - feasible)]
        for item in items:
            settling, integrated = item.estimates["settling_time"].value, item.estimates["integrated_error"].value
            row.append(f"{number(item.estimates['success'])}, {settling:.1f} s, {integrated:.0f} deg s")
        cells.append(row)
    return cells


def transposed(cells: Cells) -> Cells:
    """Exchange rows and columns."""
    return [list(column) for column in zip(*cells, strict=True)]


def markdown(cells: Cells) -> str:
    """Format cells as a Markdown table."""
    heading, *rows = ([cell.replace("|", "\\|") for cell in row] for row in cells)
    lines = ["| " + " | ".join(heading) + " |", "|" + "---|" * len(heading)]
    lines += ["| " + " | ".join(row) + " |" for row in rows]
    return "\n".join(lines)
