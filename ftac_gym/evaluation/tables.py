"""Tables of evaluations as cells of text, for a terminal or for Markdown."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from ftac_gym.evaluation.batches import Evaluation
from ftac_gym.evaluation.metrics import share_of
from ftac_gym.evaluation.metrics.budgets import CONFIDENCES, pointing_budgets
from ftac_gym.evaluation.recovery import LIMIT, recovered_within, recovery_survival
from ftac_gym.evaluation.rows import ALWAYS_ONLY, BETTER_IF_HIGHER, COLUMN_UNITS, HEADLINES, Row, fault_classes
from ftac_gym.evaluation.statistics import Estimate
from ftac_gym.faults import FaultKind, label_of
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
    return "better" if (difference.value > 0.0) == (metric in BETTER_IF_HIGHER) else "worse"


def verdict(metric: str, difference: Estimate) -> str:
    """Format a difference with its judgement."""
    return f"{number(difference)} {judgement(metric, difference)}".rstrip()


def metric_tables(rows: Sequence[Row], reference: str) -> tuple[Cells, Cells]:
    """Return estimates and paired differences to a reference: metrics down, policies across.

    The first row of the estimates is the number of episodes behind them. Availability and success over all drawn
    episodes stand below those over the ones that count, where these are not all.
    """
    metrics = list(rows[0].estimates)
    heading = [f"{metric.replace('_', ' ')} [{COLUMN_UNITS[metric]}]" for metric in metrics]
    counts = {row.policy: (row.estimates["success"].count, row.drawn["success"].count) for row in rows}
    both = any(chosen < drawn for chosen, drawn in counts.values())
    drawn_heading = [f"{metric}, all drawn [{COLUMN_UNITS[metric]}]" for metric in HEADLINES] if both else []
    estimates = [["policy", "episodes", *heading[:2], *drawn_heading, *heading[2:]]]
    differences = [[f"minus {reference}", *heading]]
    for row in rows:
        chosen, drawn = counts[row.policy]
        cells = [number(row.estimates[metric]) for metric in metrics]
        all_drawn = [number(row.drawn[metric]) for metric in HEADLINES] if both else []
        episodes = f"{chosen} of {drawn}" if both else str(chosen)
        estimates.append([row.policy, episodes, *cells[:2], *all_drawn, *cells[2:]])
        if row.differences:
            differences.append([row.policy, *(verdict(metric, row.differences[metric]) for metric in metrics)])
    return transposed(estimates), transposed(differences)


def kind_table(evaluations: Mapping[str, Sequence[Evaluation]], episodes: Mapping[str, Episodes]) -> Cells:
    """Return availability, success and settling time by scenario and fault class, infeasible episodes apart.

    The first two are means, and the last one is a median.

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
    """Return mean availability and success and median settling time over some episodes."""
    availability, success, settling = (
        item.metrics[name][chosen] for name in ("availability", "success", "settling_time")
    )
    return f"{availability.mean():.3f}, {success.mean():.2f}, {np.median(settling):.1f} s"


def split_table(rows: Mapping[str, Sequence[Row]], episodes: Mapping[str, Episodes]) -> Cells:
    """Return availability and success by scenario, over its feasible episodes and over all drawn ones.

    Settling time and integrated error stand beside those of the feasible episodes.

    Parameters
    ----------
    rows
        Estimates of each policy, by scenario.
    episodes
        As for :func:`kind_table`.
    """
    cells = [["scenario", "episodes", *(row.policy for row in next(iter(rows.values())))]]
    for name, items in rows.items():
        feasible, drawn = int(episodes[name].feasible.sum()), len(episodes[name])
        cells.append([name, f"{feasible} feasible", *map(_main_metrics, items)])
        cells.append([name, f"{drawn} drawn", *(_headlines(row.drawn) for row in items)])
    return cells


def _headlines(estimates: Mapping[str, Estimate]) -> str:
    """Return availability and success with their intervals."""
    return ", ".join(number(estimates[metric]) for metric in HEADLINES)


def _main_metrics(row: Row) -> str:
    """Return availability and success with their intervals, settling time and integrated error."""
    settling, integrated = row.estimates["settling_time"].value, row.estimates["integrated_error"].value
    return f"{_headlines(row.estimates)}, {settling:.1f} s, {integrated:.0f} deg s"


def recovery_table(evaluations: Sequence[Evaluation], episodes: Episodes) -> Cells:
    """Return the recovery from faults of feasible episodes, for all faults and by their kind.

    Each cell has the share recovered within ten seconds and the median time. In brackets are the number of faults that
    occur on target, and that of the censored ones. A median beyond all recoveries is "never".

    Parameters
    ----------
    evaluations
        One per policy.
    episodes
        The episodes, feasible where they count.
    """
    kinds = sorted({kind for item in evaluations for kind in item.recoveries.kind[episodes.feasible].ravel().tolist()})
    cells = [["fault", *(item.policy for item in evaluations)]]
    cells.append(["all", *(_recovery(item, episodes.feasible, 0) for item in evaluations)])
    for kind in (kind for kind in kinds if kind):
        cells.append([label_of(kind), *(_recovery(item, episodes.feasible, kind) for item in evaluations)])
    return cells if kinds != [0] and kinds else cells[:1]


def _recovery(item: Evaluation, feasible: npt.NDArray[np.bool_], kind: int) -> str:
    """Return the recovery from faults of a kind, or of all kinds for 0."""
    chosen = feasible[:, None] & ((item.recoveries.kind == kind) if kind else np.ones((1, 1), dtype=np.bool_))
    curve = recovery_survival([item.recoveries], chosen)
    if not curve.total:
        return "-"
    share = recovered_within([item.recoveries], feasible) if not kind else None
    within = number(replace(share, defined=0, total=0)) if share is not None else short(curve.within(LIMIT).value)
    median = curve.median.value
    censored = f", {curve.total - curve.events} censored" if curve.events < curve.total else ""
    time = "never" if np.isinf(median) else f"{short(median)} s"
    return f"{within}, {time} ({curve.total}{censored})"


def budget_table(evaluations: Sequence[Evaluation], chosen: npt.NDArray[np.bool_]) -> Cells:
    """Return the pointing error budgets at 95 and 99.7 % confidence in the mixed interpretation [deg].

    Parameters
    ----------
    evaluations
        One per policy.
    chosen
        (N,) which episodes count.
    """
    cells = [["budget [deg]", *(item.policy for item in evaluations)]]
    budgets = []
    for item in evaluations:
        window = item.attitude_error[-len(item.relative_error) :, chosen]
        budgets.append(pointing_budgets(window, item.metrics["mpe"][chosen], item.relative_error[:, chosen]))
    for name in ("APE", "MPE", "RPE"):
        for column, level in enumerate(CONFIDENCES):
            cells.append([f"{name} {level:g} %", *(short(found[name][column]) for found in budgets)])
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
