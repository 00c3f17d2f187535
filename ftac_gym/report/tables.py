"""Tables of the report."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from ftac_gym.evaluation.statistics import Estimate
from ftac_gym.report.cells import (
    TIMES,
    UNKNOWN,
    Cell,
    Line,
    Table,
    difference,
    entry_cell,
    estimated,
    heading,
    number,
    seeds,
)
from ftac_gym.report.results import METRICS, RELATIVE, Results
from ftac_gym.report.worst import SHOWN, Worst

if TYPE_CHECKING:
    from ftac_gym.evaluation.benchmark import Entry


def cards(entry: Entry) -> list[Mapping[str, Any]]:
    """Return the cards of an agent, one per seed as far as they are known, or the provenance of tuned gains."""
    found = entry.provenance.get("cards", [entry.provenance] if entry.provenance else [])
    return list(found.values() if isinstance(found, Mapping) else found)


def estimates_table(results: Results, split: str, entries: Sequence[Entry]) -> Table:
    """Return the metrics of entries, with intervals."""
    rows = results.rows[split]
    lines = [
        _line(results, entry, [estimated(rows[entry.name].estimates[item]) for item in METRICS]) for entry in entries
    ]
    return Table([Cell("entry"), *map(heading, METRICS)], lines)


def differences_table(results: Results, split: str, entries: Sequence[Entry]) -> Table:
    """Return the mean paired differences of entries to the reference; better and worse are marked."""
    relative = Cell("settling time, relative", "interquartile mean, %")
    headings = [Cell("minus reference"), heading("success"), relative, *map(heading, METRICS[1:])]
    lines = []
    for entry in entries:
        items = results.rows[split][entry.name].differences
        if items:
            share = items[RELATIVE]
            percent = Estimate(100.0 * share.value, 100.0 * share.low, 100.0 * share.high, share.count)
            cells = [difference(metric, items[metric]) for metric in METRICS]
            lines.append(_line(results, entry, [cells[0], difference(RELATIVE, percent), *cells[1:]]))
    return Table(headings, lines)


def split_table(results: Results, metric: str) -> Table:
    """Return a metric of every entry in every split; what differs from the reference is marked."""
    lines = []
    for entry in results.entries():
        cells = []
        for rows in results.rows.values():
            cell, row = estimated(rows[entry.name].estimates[metric]), rows[entry.name]
            mark = difference(metric, row.differences[metric]).mark if row.differences else ""
            cells.append(Cell(cell.text, cell.note, cell.key, mark))
        lines.append(_line(results, entry, cells))
    episodes = results.benchmark.episodes
    headings = [Cell(split, f"{int(item.feasible.sum())} feasible of {len(item)}") for split, item in episodes.items()]
    return Table([Cell("entry"), *headings], lines)


def fault_table(results: Results, split: str) -> Table:
    """Return mean success and median settling time of every entry by kind of fault."""
    classes = [item for item in results.faults if item.split == split]
    lines = []
    for entry in results.entries():
        cells = []
        for item in classes:
            tally = item.tallies[entry.name]
            cells.append(Cell(f"{tally.success:.2f}", f"{tally.settling_time:.1f} s", tally.success))
        lines.append(_line(results, entry, cells))
    headings = [
        Cell(item.kind, f"{item.episodes} {'episode' if item.episodes == 1 else 'episodes'}") for item in classes
    ]
    return Table([Cell("entry"), *headings], lines)


def improvement_table(results: Results, metric: str) -> Table:
    """Return how likely the entry of the row does better than that of the column."""
    chances = results.improvement[metric]
    names = list(dict.fromkeys(name for pair in chances for name in pair))
    names.sort(key=results.order.index)
    by_name = {entry.name: entry for entry in results.benchmark.entries}
    lines = []
    for first in names:
        cells = []
        for second in names:
            if first == second:
                cells.append(number(float("nan")))
                continue
            item = chances[first, second]
            mark = "better" if item.low > 0.5 else "worse" if item.high < 0.5 else ""
            cell = Cell(f"{item.value:.2f}", f"[{item.low:.2f}, {item.high:.2f}]", item.value, mark)
            cells.append(cell if item.count else number(float("nan")))
        lines.append(_line(results, by_name[first], cells))
    return Table([Cell("entry"), *map(Cell, names)], lines)


def worst_table(results: Results, split: str, worst: Sequence[Worst]) -> Table:
    """Return the worst episodes of a split, with the metrics of both."""
    lines = []
    reference = results.benchmark.reference
    for item in worst:
        if item.split != split:
            continue
        alone = item.entry == reference
        cells = [Cell(item.entry, "" if alone else f"seed {item.seed}"), Cell(item.faults)]
        for metric in SHOWN:
            own = number(item.own[metric])
            other = "" if alone else f"reference {number(item.reference[metric]).text}"
            cells.append(Cell(own.text, other, own.key))
        lines.append(Line([Cell(str(item.index)), *cells]))
    return Table([Cell("episode"), Cell("entry"), Cell("faults"), *map(heading, SHOWN)], lines)


def costs_table(results: Results) -> Table:
    """Return what entries cost to tune or train, and to run."""
    lines = []
    for entry in results.entries():
        step, source = results.benchmark.step_cost.get(entry.name, float("nan")), cards(entry)
        first: Mapping[str, Any] = source[0] if source else {}
        effort, hours = Cell(UNKNOWN, "", float("nan")), float("nan")
        if entry.kind == "agent":
            # An agent that was the best before the end of its run cost the whole run.
            steps = sum(float(card.get("run_steps", card.get("steps", float("nan")))) for card in source)
            seconds = (card.get("run_seconds", card.get("training_seconds", float("nan"))) for card in source)
            hours = sum(map(float, seconds)) / 60.0
            if source and steps == steps:
                effort = Cell(f"{steps / 1e6:.3g} million steps", f"{seeds(len(entry.policies))} in all", steps)
        elif "trials" in first:
            flown = int(first["trials"]) * int(first.get("episodes", 1))
            effort = Cell(
                f"{first['trials']} trials {TIMES} {first.get('episodes', '?')} episodes", f"{flown} flown", flown
            )
        command = str(first.get("command", ""))
        cells = [effort, number(hours), number(step), Cell(command, code=bool(command))]
        lines.append(_line(results, entry, cells))
    headings = [
        Cell("entry"),
        Cell("tuning or training"),
        Cell("training time", "min, all seeds"),
        Cell("control step", "µs"),
        Cell("command"),
    ]
    return Table(headings, lines)


def _line(results: Results, entry: Entry, cells: Sequence[Cell]) -> Line:
    reference = results.benchmark.reference
    return Line([entry_cell(entry, reference), *cells], entry, entry.name == reference)
