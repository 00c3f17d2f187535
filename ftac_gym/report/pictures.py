"""The figures of the report, drawn from its numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import cycle

import numpy as np
from matplotlib.figure import Figure

from ftac_gym.evaluation.entries import Entry
from ftac_gym.evaluation.metrics import SHARES, UNITS
from ftac_gym.evaluation.profiles import Curve
from ftac_gym.evaluation.tables import INFEASIBLE
from ftac_gym.plots.style import COLORS, INK, MUTED
from ftac_gym.report import charts
from ftac_gym.report.results import BY_SPLIT, COMPARED, Results
from ftac_gym.report.svg import drawing, svg
from ftac_gym.utils.parameters import FloatArray

TRAINING = {"success": "success on the evaluation's episodes", "mean_return": "mean return"}
"""Columns of training curves that are drawn, and their titles."""

_KINDS = {"agent": ("-", 2.2, COLORS[0]), "baseline": ("--", 1.4, MUTED), "oracle": (":", 1.8, COLORS[2])}
"""Line style, line width, and the colour where names stand beside."""


def draw(results: Results) -> dict[str, str]:
    """Return all figures that have something to show as SVG documents, by the names of their files."""
    agents = [entry for entry in results.entries() if any(entry.curves)]
    with drawing():
        found = {"success_by_fault": _by_fault(results)}
        if results.profiles:
            found |= {"main": _main(results), "profiles": _profiles(results)}
            found |= {f"{metric}_by_split": _by_split(results, metric) for metric in BY_SPLIT}
            if len(results.compared) > 1:
                found |= {f"improvement_{metric}": _improvement(results, metric) for metric in COMPARED}
        if agents:
            found["training"] = _training(agents, results.benchmark.reference)
        return {name: svg(figure) for name, figure in found.items()}


def _main(results: Results) -> Figure:
    rows, reference = results.rows[results.main], results.benchmark.reference
    columns = {
        f"{metric.replace('_', ' ')} [{UNITS[metric]}]": {name: rows[name].estimates[metric] for name in results.shown}
        for metric in ("availability", "success", "settling_time")
    }
    colors = {entry.name: _KINDS[_kind(entry)][2] for entry in results.entries()}
    return charts.intervals(columns, {**colors, reference: INK}, reference)


def _by_split(results: Results, metric: str) -> Figure:
    splits, share = list(results.rows), metric in SHARES
    values = np.array(
        [[rows[name].estimates[metric].value for rows in results.rows.values()] for name in results.order]
    )
    return charts.heat_map(
        values,
        results.order,
        [_without_prefix(split, splits) for split in splits],
        charts.SHARES if share else charts.TIMES,
        (0.0, 1.0) if share else _span(values),
        results.benchmark.reference,
        digits=2 if share else 1,
    )


def _by_fault(results: Results) -> Figure:
    classes = [item for item in results.faults if item.kind != INFEASIBLE] or list(results.faults)
    return charts.heat_map(
        np.array([[item.success[name] for item in classes] for name in results.order]),
        results.order,
        [f"{item.kind} ({item.episodes})" for item in classes],
        charts.SHARES,
        (0.0, 1.0),
        results.benchmark.reference,
        groups=[_without_prefix(item.split, list(results.rows)) for item in classes],
    )


def _improvement(results: Results, metric: str) -> Figure:
    chances, names = results.improvement[metric], results.compared
    values = np.array([[chances[a, b].value if a != b else np.nan for b in names] for a in names])
    return charts.heat_map(values, names, names, charts.CHANCES, (0.0, 1.0), results.benchmark.reference, digits=2)


def _profiles(results: Results) -> Figure:
    styles = looks([entry for entry in results.entries() if entry.name in results.shown], results.benchmark.reference)
    latest = results.scenario.duration - results.scenario.success.hold
    return charts.profiles(results.profiles, styles, results.shown, latest)


def _training(agents: Sequence[Entry], reference: str) -> Figure:
    panels: dict[str, dict[str, Curve]] = {}
    for column, title in TRAINING.items():
        for agent in agents:
            curve = training_curve(agent, column)
            if curve is not None:
                panels.setdefault(title, {})[agent.name] = replace(curve, x=curve.x / 1e6)
    return charts.training(panels, looks(agents, reference))


def _kind(entry: Entry) -> str:
    return "oracle" if entry.role == "oracle" else entry.kind


def looks(entries: Sequence[Entry], reference: str) -> charts.Looks:
    """Return the looks of entries: agents solid, baselines dashed, oracles dotted, the reference in the text's colour.

    The first six, agents before baselines, have different colours.
    """
    colors = cycle(COLORS[:-1])  # The last is that of text.
    found = {reference: {"color": INK, "linestyle": "-", "linewidth": 2.0}}
    for entry in sorted(entries, key=lambda entry: list(_KINDS).index(_kind(entry))):
        if entry.name != reference:
            line, width, _ = _KINDS[_kind(entry)]
            found[entry.name] = {"color": next(colors), "linestyle": line, "linewidth": width}
    return found


def training_curve(agent: Entry, column: str) -> Curve | None:
    """Return mean and range over an agent's seeds of a column of its evaluations; None if none has it.

    Seeds that were evaluated at other steps than the first are interpolated, as far as all of them go.
    """
    runs = []
    for rows in agent.curves:
        known = [(row["steps"], row[column]) for row in rows if np.isfinite(row.get(column, np.nan))]
        if known:
            runs.append(np.array(sorted(known), dtype=np.float64).T)
    if not runs:
        return None
    start, end = max(run[0, 0] for run in runs), min(run[0, -1] for run in runs)
    steps: FloatArray = runs[0][0][(runs[0][0] >= start) & (runs[0][0] <= end)]
    if not steps.size:
        steps = np.array([end])
    values = np.array([np.interp(steps, *run) for run in runs])
    return Curve(steps, values.mean(axis=0), values.min(axis=0), values.max(axis=0), len(runs))


def _span(values: FloatArray) -> tuple[float, float]:
    """Return the least and the largest of some numbers, of which some are known; they differ."""
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    return low, max(high, low + 1.0)


def _without_prefix(split: str, splits: Sequence[str]) -> str:
    """Return the name of a split without the common prefix of the first one."""
    return split.removeprefix(f"{splits[0]}_")
