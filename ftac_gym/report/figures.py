"""Figures of the report. Draw them inside :func:`ftac_gym.report.vector.drawing`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import cycle
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Colormap, LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from ftac_gym.evaluation.statistics import Estimate
from ftac_gym.plots.style import COLORS, FAINT, INK, MUTED
from ftac_gym.report.vector import PAPER
from ftac_gym.utils.parameters import FloatArray

BETTER, WORSE = COLORS[0], COLORS[1]

WIDTH = 10.0
"""Width of a figure [in], that of the page's column."""

SHARES = LinearSegmentedColormap.from_list("shares", ["#f4efe6", "#a6cbe3", "#3a86c0", "#08306b"])
TIMES = SHARES.reversed()
"""Short times have the colours of large shares."""
CHANCES = LinearSegmentedColormap.from_list("chances", [WORSE, "#f6f3ee", BETTER])

_ROW = 0.22
"""Height of a row with a label [in]."""
_CHARACTER = 0.065
"""Width of a letter of a label [in]."""


@dataclass(frozen=True)
class Look:
    """How an entry is drawn."""

    color: str
    line: str
    width: float


@dataclass(frozen=True, eq=False)
class Curve:
    """A line with a band.

    Attributes
    ----------
    x, y, low, high
        (K,) each.
    """

    x: FloatArray
    y: FloatArray
    low: FloatArray
    high: FloatArray


def looks(agents: Sequence[str], baselines: Sequence[str], bounds: Sequence[str], reference: str) -> dict[str, Look]:
    """Return how entries are drawn: agents solid, baselines dashed, bounds dotted, the reference in the text's colour.

    Colours go round: the first six, agents before baselines, have different ones.
    """
    colors = cycle(COLORS[:-1])  # The last is that of text.
    found: dict[str, Look] = {}
    for names, line, width in ((agents, "-", 2.2), (baselines, "--", 1.4), (bounds, ":", 1.8)):
        found |= {name: Look(next(colors), line, width) for name in names if name != reference}
    return {**found, reference: Look(INK, "-", 2.0)}


def short(name: str, length: int = 34) -> str:
    """Return a name that fits beside a figure."""
    return name if len(name) <= length else f"{name[: length - 1]}…"


def intervals(columns: Mapping[str, Mapping[str, Estimate]], colors: Mapping[str, str], reference: str) -> Figure:
    """Draw estimates with their intervals, one panel per column, entries down; the reference's value is a line.

    Parameters
    ----------
    columns
        Estimates by entry, by the panel's title; all have the same entries, the first on top.
    colors
        By entry.
    reference
        The entry whose value is drawn through.
    """
    names = list(next(iter(columns.values())))
    figure = Figure(figsize=(WIDTH, 0.9 + _ROW * 1.15 * len(names)), layout=ConstrainedLayoutEngine(wspace=0.08))
    panels = figure.subplots(1, len(columns), sharey=True, squeeze=False)[0]
    for panel, (title, estimates) in zip(panels, columns.items(), strict=True):
        for row, name in enumerate(names):
            item, color = estimates[name], colors[name]
            if not item.count:
                continue
            panel.plot([item.low, item.high], [row, row], color=color, linewidth=2.4, alpha=0.45)
            panel.plot([item.value], [row], "o", color=color, markersize=5.5)
            panel.annotate(
                f"{item.value:.3g}", (item.value, row), (0, 5), textcoords="offset points", ha="center", fontsize=7.5
            )
        if reference in estimates and estimates[reference].count:
            panel.axvline(estimates[reference].value, color=FAINT, linewidth=1.0, zorder=0)
        panel.set_title(title)
        panel.grid(axis="x")
        panel.spines[["left", "bottom"]].set_visible(False)
        panel.set_ylim(len(names) - 0.5, -0.7)
        panel.margins(x=0.06)
        panel.locator_params(axis="x", nbins=6)
    panels[0].set_yticks(range(len(names)), [short(name) for name in names])
    _mark_label(panels[0], names, reference)
    return figure


def heat_map(
    values: FloatArray,
    rows: Sequence[str],
    columns: Sequence[str],
    colors: Colormap,
    span: tuple[float, float],
    reference: str,
    digits: int | None = None,
    groups: Sequence[str] = (),
) -> Figure:
    """Draw a table of numbers as colours.

    Parameters
    ----------
    values
        (R, C); NaN is left blank.
    rows, columns
        Labels, R and C of them.
    colors, span
        Colours from the first value to the second; what is beyond has the colour of the end.
    reference
        The row whose label is marked.
    digits
        Digits after the point of the numbers in the cells; None writes none.
    groups
        (C,) to which group each column belongs; columns of one group stand together under its name.
    """
    labels = [short(name) for name in rows]
    margin = _CHARACTER * max(map(len, labels)) + 0.2
    wide = 0.95 if digits is not None and len(columns) <= 8 else 0.42 if digits is not None else 0.26
    upright = digits is None or wide < 0.9
    head = (_CHARACTER * max(len(short(name)) for name in columns) if upright else 0.15) + (0.62 if groups else 0.25)
    # Cells grow until the figure is as wide as the column, within reason.
    wide = float(np.clip((WIDTH - margin - 0.1) / len(columns), wide, max(wide, 1.6 if not upright else 0.5)))
    size = (margin + wide * len(columns) + 0.1, head + _ROW * len(rows) + 0.1)
    figure = Figure(figsize=size)
    box = (margin / size[0], 0.1 / size[1], wide * len(columns) / size[0], _ROW * len(rows) / size[1])
    panel = figure.add_axes(box)
    shades = colors.with_extremes(bad=(0.0, 0.0, 0.0, 0.0))
    panel.imshow(
        np.ma.masked_invalid(values), cmap=shades, vmin=span[0], vmax=span[1], interpolation="none", aspect="auto"
    )
    panel.set_yticks(range(len(rows)), labels)
    panel.set_xticks(range(len(columns)), [short(name) for name in columns])
    panel.tick_params(axis="x", bottom=False, labelbottom=False, labeltop=True, rotation=90 if upright else 0)
    panel.spines[:].set_visible(False)
    for row in range(1, len(rows)):
        panel.axhline(row - 0.5, color=PAPER, linewidth=1.0)
    for column in range(1, len(columns)):
        parted = bool(groups) and groups[column] != groups[column - 1]
        panel.axvline(column - 0.5, color=PAPER, linewidth=5.0 if parted else 1.0)
    raised, end = False, -np.inf
    for group in dict.fromkeys(groups):
        start = (groups.index(group) - 0.5) * wide
        # Above the last name if that is wider than its group.
        raised, end = start < end and not raised, start + _CHARACTER * len(group) + 0.15
        place = (start / wide, 1.0 + (head - (0.28 if raised else 0.45)) / (_ROW * len(rows)))
        panel.text(*place, group, transform=panel.get_xaxis_transform(), fontweight="bold", fontsize=9)
    if digits is not None:
        for (row, column), value in np.ndenumerate(values):
            if np.isfinite(value):
                red, green, blue, _ = shades(float(np.clip((value - span[0]) / (span[1] - span[0]), 0.0, 1.0)))
                light = 0.299 * red + 0.587 * green + 0.114 * blue > 0.55
                color = "#111111" if light else "#ffffff"
                panel.text(
                    column, row, f"{value:.{digits}f}", ha="center", va="center_baseline", color=color, fontsize=8
                )
    _mark_label(panel, rows, reference)
    return figure


def profiles(
    panels: Mapping[str, Mapping[str, Curve]], styles: Mapping[str, Look], names: Sequence[str], latest: float
) -> Figure:
    """Draw the share of episodes that are settled against time.

    Parameters
    ----------
    panels
        Curves by entry, by the panel's title: the first panel fills a row and has labels, the others are small.
    styles
        Looks by entry.
    names
        The entries that are told apart; the others are grey lines.
    latest
        Time at which a line is drawn [s].
    """
    small = len(panels) - 1
    across = min(3, max(2, small))
    rows = -(-small // across)
    height = max(4.2, 0.9 + 0.17 * len(names))
    figure = Figure(figsize=(WIDTH, height + 2.4 * rows), layout="constrained")
    parts: Any = figure.subfigures(2, 1, height_ratios=[height, 2.4 * rows]) if small else [figure]
    large = parts[0].subplots()
    axes = [large]
    if small:
        axes += list(np.ravel(parts[1].subplots(rows, across, sharex=True, sharey=True, squeeze=False)))
    for panel in axes[len(panels) :]:
        panel.set_visible(False)
    for panel, (title, curves) in zip(axes, panels.items(), strict=False):
        for name, curve in curves.items():
            if name not in names:
                panel.plot(curve.x, curve.y, color=FAINT, linewidth=0.6, alpha=0.8, zorder=1)
        for name in names:
            curve, look = curves[name], styles[name]
            panel.plot(curve.x, curve.y, color=look.color, linestyle=look.line, linewidth=look.width, zorder=3)
            panel.fill_between(
                curve.x,
                curve.low,
                curve.high,
                color=look.color,
                alpha=min(0.1, 0.8 / len(names)),
                linewidth=0.0,
                zorder=2,
            )
        panel.set_title(title)
        panel.axvline(latest, color=MUTED, linestyle=":", linewidth=1.0)
        panel.set(ylim=(0.0, 1.0), xlim=(0.0, max((curve.x[-1] for curve in curves.values()), default=1.0)))
        panel.grid()
    for panel in axes[1 : len(panels)]:
        panel.tick_params(labelbottom=True)
    large.set(xlabel="time [s]", ylabel="share of episodes that are settled")
    ends = {name: float(next(iter(panels.values()))[name].y[-1]) for name in names}
    _label_ends(large, ends, styles, height - 0.8)
    return figure


def training(panels: Mapping[str, Mapping[str, Curve]], styles: Mapping[str, Look]) -> Figure:
    """Draw training curves side by side, labelled beside the last panel.

    Parameters
    ----------
    panels
        Curves by agent, by the label of the y axis; all have the same agents.
    styles
        Looks by agent.
    """
    count = len(next(iter(panels.values())))
    height = max(3.4, 0.9 + 0.17 * count)
    figure = Figure(figsize=(WIDTH, height), layout="constrained")
    for panel, (label, curves) in zip(figure.subplots(1, len(panels), squeeze=False)[0], panels.items(), strict=True):
        for name, curve in curves.items():
            color = styles[name].color
            marker = "o" if len(curve.x) == 1 else ""
            panel.fill_between(curve.x / 1e6, curve.low, curve.high, color=color, alpha=0.15, linewidth=0.0)
            panel.plot(curve.x / 1e6, curve.y, color=color, linewidth=1.6, marker=marker)
        panel.set_title(label)
        panel.set_xlabel("million steps")
        panel.grid()
        last = panel
    last.set_xlim(right=max(float(curve.x[-1]) for curve in curves.values()) / 1e6)
    ends = {name: (float(curve.x[-1]) / 1e6, float(curve.y[-1])) for name, curve in curves.items()}
    _label_ends(last, {name: y for name, (_, y) in ends.items()}, styles, height - 0.8)
    return figure


def _mark_label(panel: Axes, names: Sequence[str], reference: str) -> None:
    """Make the reference's label bold."""
    for label, name in zip(panel.get_yticklabels(), names, strict=True):
        if name == reference:
            label.set(fontweight="bold", color=INK)


def _label_ends(panel: Axes, ends: Mapping[str, float], styles: Mapping[str, Look], height: float) -> None:
    """Write the names of lines at their right ends, pushed apart where they would overlap.

    Parameters
    ----------
    panel
        Its limits must not change any more.
    ends
        Last y of each line.
    styles
        Looks by name.
    height
        Of the panel [in], about.
    """
    low, high = panel.get_ylim()
    panel.set_ylim(low, high)
    known = {name: y for name, y in ends.items() if np.isfinite(y)}
    order = sorted(known, key=lambda name: known[name])
    wanted = np.clip((np.array([known[name] for name in order]) - low) / (high - low), 0.0, 1.0)
    for name, start, place in zip(order, wanted, spread(wanted, 0.16 / height), strict=True):
        color = styles[name].color
        panel.plot([1.0, 1.02], [start, place], color=color, linewidth=0.8, transform=panel.transAxes, clip_on=False)
        panel.annotate(short(name), (1.025, place), xycoords="axes fraction", color=color, va="center", fontsize=8.5)


def spread(wanted: FloatArray, gap: float) -> FloatArray:
    """Return ascending positions (K,) near the wanted ascending ones that are at least a gap apart.

    Neighbours that are too near move as one block about the mean of what they want, which is least squares, and all
    stay below one.
    """
    blocks: list[tuple[float, int]] = []  # Mean of what its members want of the first, and their number.
    for place in wanted:
        blocks.append((float(place), 1))
        while len(blocks) > 1 and blocks[-2][0] + blocks[-2][1] * gap > blocks[-1][0]:
            (first, many), (second, more) = blocks[-2:]
            mean = (first * many + (second - many * gap) * more) / (many + more)
            blocks[-2:] = [(mean, many + more)]
    placed = [start + gap * np.arange(count) for start, count in blocks]
    steps = gap * np.arange(len(wanted))
    # None stands above the last that fits, unless there are too many of them.
    lowered: FloatArray = np.minimum(np.concatenate([np.zeros(0), *placed]), np.maximum(1.0, steps[-1:]) - steps[::-1])
    return lowered
