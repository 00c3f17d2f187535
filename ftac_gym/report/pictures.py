"""The figures of the report, drawn from its numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ftac_gym.evaluation.metrics import UNITS
from ftac_gym.evaluation.tables import INFEASIBLE
from ftac_gym.plots.style import COLORS, INK, MUTED
from ftac_gym.report import figures
from ftac_gym.report.figures import Curve, Look
from ftac_gym.report.results import COMPARED, Results
from ftac_gym.report.vector import drawing, svg
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray

if TYPE_CHECKING:
    from ftac_gym.evaluation.benchmark import Entry

TRAINING = {"success": "success on the evaluation's episodes", "mean_return": "mean return"}
"""Columns of training curves that are drawn, and what they are."""


_KINDS = {"agent": COLORS[0], "baseline": MUTED, "bound": COLORS[2]}
"""Colours where names stand beside."""


@dataclass(frozen=True)
class Picture:
    """An SVG document and what it shows."""

    document: str
    caption: str


def draw(results: Results) -> dict[str, Picture]:
    """Draw all figures that there is something to show in, by the names of their files."""
    reference = results.benchmark.reference
    with drawing():
        found = {}
        if results.profiles:
            found["main"] = _main(results)
            found["success_by_split"] = _by_split(results, "success")
            found["settling_time_by_split"] = _by_split(results, "settling_time")
        found["success_by_fault"] = _by_fault(results)
        for metric in COMPARED:
            chances = results.improvement[metric]
            if results.profiles and chances:
                names = sorted({first for first, _ in chances}, key=results.order.index)
                values = np.array([[chances[a, b].value if a != b else np.nan for b in names] for a in names])
                figure = figures.heat_map(values, names, names, figures.CHANCES, (0.0, 1.0), reference, digits=2)
                caption = (
                    f"Probability that the entry of the row has a better {metric.replace('_', ' ')} than that of the "
                    f"column in an episode of {results.main}; a tie counts half. Blue is better, orange worse."
                )
                found[f"improvement_{metric}"] = Picture(svg(figure), caption)
        if results.profiles:
            found["profiles"] = _profiles(results)
        if agents := [entry for entry in results.entries() if any(entry.curves)]:
            found["training"] = _training(agents, reference)
    return found


def _styles(results: Results) -> dict[str, Look]:
    """Return how those entries are drawn that are told apart."""
    told = [entry for entry in results.entries() if entry.name in results.shown]
    bounds = [entry.name for entry in told if entry.role == "bound"]
    agents, baselines = (
        [entry.name for entry in told if entry.kind == kind and entry.name not in bounds]
        for kind in ("agent", "baseline")
    )
    return figures.looks(agents, baselines, bounds, results.benchmark.reference)


def _main(results: Results) -> Picture:
    rows = results.rows[results.main]
    columns = {
        f"{title} [{UNITS[metric]}]": {name: rows[name].estimates[metric] for name in results.shown}
        for metric, title in (("success", "success"), ("settling_time", "settling time"))
    }
    colors = {entry.name: _KINDS["bound" if entry.role == "bound" else entry.kind] for entry in results.entries()}
    reference = results.benchmark.reference
    figure = figures.intervals(columns, {**colors, reference: INK}, reference)
    several = "the best entries" if len(results.shown) < len(results.order) else "all entries"
    caption = (
        f"Success (mean) and settling time (interquartile mean) of {several} on {results.main}, with 95 % intervals. "
        f"Agents are blue, baselines grey, bounds green; the line is {reference}."
    )
    return Picture(svg(figure), caption)


def _by_split(results: Results, metric: str) -> Picture:
    splits = list(results.rows)
    values = np.array(
        [[results.rows[split][name].estimates[metric].value for split in splits] for name in results.order]
    )
    share = metric == "success"
    figure = figures.heat_map(
        values,
        results.order,
        [_without_prefix(split, splits) for split in splits],
        figures.SHARES if share else figures.TIMES,
        (0.0, 1.0) if share else _span(values),
        results.benchmark.reference,
        digits=2 if share else 1,
    )
    what = "Success, from none (pale) to all" if share else "Settling time [s], interquartile mean, from slowest (pale)"
    return Picture(svg(figure), f"{what} to quickest (dark)." if not share else f"{what} feasible episodes (dark).")


def _by_fault(results: Results) -> Picture:
    classes = [item for item in results.faults if item.kind != INFEASIBLE] or list(results.faults)
    values = np.array([[item.tallies[name].success for item in classes] for name in results.order])
    splits = list(results.rows)
    figure = figures.heat_map(
        values,
        results.order,
        [f"{item.kind} ({item.episodes})" for item in classes],
        figures.SHARES,
        (0.0, 1.0),
        results.benchmark.reference,
        groups=[_without_prefix(item.split, splits) for item in classes],
    )
    caption = (
        "Success by what is wrong, split by split, from none (pale) to all episodes (dark). The number of episodes is "
        "in brackets: where it is small, colours are mostly chance."
    )
    return Picture(svg(figure), caption)


def _profiles(results: Results) -> Picture:
    scenario = Scenario.from_json(results.benchmark.episodes[results.main].scenario_json)
    hold, latest = scenario.success.hold, scenario.duration - scenario.success.hold
    figure = figures.profiles(results.profiles, _styles(results), results.shown, latest)
    rest = len(results.order) - len(results.shown)
    grey = f" The other {rest} entries are grey." if rest else ""
    caption = (
        "Share of feasible episodes in which the craft is on target to stay after so many seconds, with 95 % bands. "
        f"Agents are solid, baselines dashed, bounds dotted, {results.benchmark.reference} in the "
        f"colour of text.{grey} Success takes {hold:g} s on target: who settles after the dotted line is too late."
    )
    return Picture(svg(figure), caption)


def _training(agents: Sequence[Entry], reference: str) -> Picture:
    panels = {
        title: {agent.name: curve for agent in agents if (curve := training_curve(agent, column)) is not None}
        for column, title in TRAINING.items()
    }
    styles = figures.looks([agent.name for agent in agents], [], [], reference)
    figure = figures.training({title: curves for title, curves in panels.items() if curves}, styles)
    caption = (
        "Evaluations during training, on episodes that neither training nor this report uses: mean over seeds, and "
        "range from the worst to the best of them."
    )
    return Picture(svg(figure), caption)


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
    return Curve(steps, values.mean(axis=0), values.min(axis=0), values.max(axis=0))


def _span(values: FloatArray) -> tuple[float, float]:
    """Return the least and the largest of some numbers, of which some are known; they differ."""
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    return low, max(high, low + 1.0)


def _without_prefix(split: str, splits: Sequence[str]) -> str:
    """Return the name of a split without what it has in common with the first one."""
    return split.removeprefix(f"{splits[0]}_")
