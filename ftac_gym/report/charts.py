"""Charts of the report. They are drawn inside :func:`ftac_gym.report.svg.drawing`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Colormap, LinearSegmentedColormap
from matplotlib.figure import Figure
from scipy.optimize import isotonic_regression

from ftac_gym.evaluation.profiles import Curve
from ftac_gym.evaluation.statistics import Estimate
from ftac_gym.plots import style
from ftac_gym.plots.style import COLORS, FAINT, INK, MUTED
from ftac_gym.report.svg import PAPER
from ftac_gym.utils.parameters import FloatArray

BETTER, WORSE = COLORS[0], COLORS[1]

WIDTH = 10.0
"""Width of a figure [in], that of the page's column."""

SHARES = LinearSegmentedColormap.from_list("shares", ["#f4efe6", "#a6cbe3", "#3a86c0", "#08306b"])
TIMES = SHARES.reversed()
"""Short times have the colours of large shares."""
CHANCES = LinearSegmentedColormap.from_list("chances", [WORSE, "#f6f3ee", BETTER])

_ROW, _LINE = 0.22, 0.17
"""Height of a row of a map, and of a label beside a line [in]."""
_CHARACTER = 0.065
"""Width of a letter of a label [in]."""

Looks = Mapping[str, Mapping[str, Any]]
"""Arguments of ``Axes.plot``, by entry."""


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
        Entry with a line at its value.
    """
    names = list(next(iter(columns.values())))
    figure = style.figure(WIDTH, 0.9 + 1.15 * _ROW * len(names))
    figure.set_layout_engine("constrained", wspace=0.08)
    panels = figure.subplots(1, len(columns), sharey=True, squeeze=False)[0]
    for panel, (title, estimates) in zip(panels, columns.items(), strict=True):
        style.apply(panel, title=title)
        for row, (name, item) in enumerate(estimates.items()):
            if item.count:
                panel.plot([item.low, item.high], [row, row], color=colors[name], linewidth=2.4, alpha=0.45)
                panel.plot(item.value, row, "o", color=colors[name], markersize=5.5)
                above = {"xytext": (0, 5), "textcoords": "offset points", "ha": "center", "fontsize": 7.5}
                panel.annotate(f"{item.value:.3g}", (item.value, row), color=INK, **above)
        if reference in estimates and estimates[reference].count:
            panel.axvline(estimates[reference].value, color=FAINT, linewidth=1.0, zorder=0)
        panel.grid(visible=False, axis="y")
        panel.spines[["left", "bottom"]].set_visible(False)
        panel.tick_params(length=0.0)
        panel.set_ylim(len(names) - 0.5, -0.7)
        panel.margins(x=0.06)
        panel.locator_params(axis="x", nbins=6)
    _label_rows(panels[0], names, reference)
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
        Colours from the first value to the second; values beyond have the colour of the end.
    reference
        Row with a bold label.
    digits
        Digits after the point of the numbers in the cells; None writes none.
    groups
        (C,) group of each column; columns of one group stand together above its name.
    """
    upright = digits is None or len(columns) > 8
    least, most = (0.26, 0.5) if digits is None else (0.42, 0.5) if upright else (0.95, 1.6)
    margin = _CHARACTER * max(len(short(name)) for name in rows) + 0.3
    width = float(np.clip((WIDTH - margin) / len(columns), least, most))
    head = _CHARACTER * max(len(short(name)) for name in columns) if upright else _ROW
    figure = style.figure(margin + width * len(columns), head + 0.2 + (0.4 if groups else 0.0) + _ROW * len(rows))
    panel = figure.subplots()
    shades = colors.with_extremes(bad=(0.0, 0.0, 0.0, 0.0))
    panel.imshow(values, cmap=shades, vmin=span[0], vmax=span[1], interpolation="none", aspect="auto")
    style.apply(panel)
    panel.grid(visible=False)
    panel.spines[:].set_visible(False)
    panel.hlines(np.arange(1, len(rows)) - 0.5, -0.5, len(columns) - 0.5, color=PAPER, linewidth=1.0)
    panel.vlines(np.arange(1, len(columns)) - 0.5, -0.5, len(rows) - 0.5, color=PAPER, linewidth=1.0)
    panel.set_xticks(range(len(columns)), [short(name) for name in columns])
    panel.tick_params(length=0.0, labelbottom=False, labeltop=True, labelrotation=90.0 * upright)
    panel.tick_params(axis="y", labelrotation=0.0)
    _label_rows(panel, rows, reference)
    names = list(dict.fromkeys(groups))
    edges = np.array([groups.index(name) for name in names] + [len(groups)]) - 0.5
    panel.vlines(edges[1:-1], -0.5, len(rows) - 0.5, color=PAPER, linewidth=5.0)
    for number, name in enumerate(names):
        # Every other name stands lower: groups can be narrower than their names.
        place = (0.5 * (edges[number] + edges[number + 1]), len(rows) - 0.5)
        look: dict[str, Any] = {"ha": "center", "va": "top", "color": INK, "fontweight": "bold", "fontsize": 9}
        panel.annotate(name, place, (0, -3 - 12 * (number % 2)), textcoords="offset points", **look)
    if digits is not None:
        for (row, column), value in np.ndenumerate(values):
            if np.isfinite(value):
                shade = shades(float(np.clip((value - span[0]) / (span[1] - span[0]), 0.0, 1.0)))
                color = "#111111" if np.dot(shade[:3], (0.299, 0.587, 0.114)) > 0.55 else "#ffffff"
                middle: dict[str, Any] = {"ha": "center", "va": "center_baseline", "fontsize": 8}
                panel.text(column, row, f"{value:.{digits}f}", color=color, **middle)
    return figure


def profiles(panels: Mapping[str, Mapping[str, Curve]], styles: Looks, names: Sequence[str], latest: float) -> Figure:
    """Draw the share of settled episodes against time.

    Parameters
    ----------
    panels
        Curves by entry, by the panel's title: the first panel fills a row and has labels, the others are small.
    styles
        Looks by entry.
    names
        Entries with a look of their own; the others are grey lines.
    latest
        Time at which a line is drawn [s].
    """
    small, height = len(panels) - 1, max(4.2, 0.9 + _LINE * len(names))
    across = min(3, max(2, small))
    rows = -(-small // across)
    figure = style.figure(WIDTH, height + 2.4 * rows)
    parts: Any = figure.subfigures(2, 1, height_ratios=[height, 2.4 * rows]) if small else [figure]
    large = parts[0].subplots()
    axes = [large]
    if small:
        axes += list(np.ravel(parts[1].subplots(rows, across, sharex=True, sharey=True, squeeze=False)))
    for panel, (title, curves) in zip(axes, panels.items(), strict=False):
        style.apply(panel, title=title)
        for name, curve in curves.items():
            if name not in names:
                panel.plot(curve.x, curve.y, color=FAINT, linewidth=0.6, alpha=0.8, zorder=1)
        for name in names:
            _draw(panel, curves[name], styles[name], min(0.1, 0.8 / len(names)))
        panel.axvline(latest, color=MUTED, linestyle=":", linewidth=1.0)
        panel.set(ylim=(0.0, 1.0), xlim=(0.0, max((curve.x[-1] for curve in curves.values()), default=1.0)))
        panel.tick_params(labelbottom=True)
    for panel in axes[len(panels) :]:
        panel.set_visible(False)
    style.apply(large, xlabel="time [s]", ylabel="share of settled episodes")
    _label_ends(large, {name: next(iter(panels.values()))[name] for name in names}, styles, height)
    return figure


def training(panels: Mapping[str, Mapping[str, Curve]], styles: Looks) -> Figure:
    """Draw training curves side by side, labelled beside the last panel.

    Parameters
    ----------
    panels
        Curves by agent, by the label of the y axis; all have the same agents.
    styles
        Looks by agent.
    """
    height = max(3.4, 0.9 + _LINE * len(styles))
    figure = style.figure(WIDTH, height)
    for panel, (label, curves) in zip(figure.subplots(1, len(panels), squeeze=False)[0], panels.items(), strict=True):
        style.apply(panel, title=label, xlabel="million steps")
        for name, curve in curves.items():
            _draw(panel, curve, {**styles[name], "marker": "o" if len(curve.x) == 1 else ""}, 0.15)
        panel.set_xlim(right=max(float(curve.x[-1]) for curve in curves.values()))
    _label_ends(panel, curves, styles, height)
    return figure


def _draw(panel: Axes, curve: Curve, look: Mapping[str, Any], alpha: float) -> None:
    panel.fill_between(curve.x, curve.low, curve.high, color=look["color"], alpha=alpha, linewidth=0.0, zorder=2)
    panel.plot(curve.x, curve.y, zorder=3, **look)


def _label_rows(panel: Axes, names: Sequence[str], reference: str) -> None:
    """Label the rows; the reference's label is bold."""
    panel.set_yticks(range(len(names)), [short(name) for name in names])
    for label, name in zip(panel.get_yticklabels(), names, strict=True):
        if name == reference:
            label.set(fontweight="bold", color=INK)


def _label_ends(panel: Axes, curves: Mapping[str, Curve], styles: Looks, height: float) -> None:
    """Write the names of curves at their right ends, pushed apart where they would overlap.

    Parameters
    ----------
    panel
        Its limits must not change any more.
    curves
        By name.
    styles
        Looks by name.
    height
        Of the figure [in].
    """
    low, high = panel.get_ylim()
    panel.set_ylim(low, high)
    ends = {name: float(curve.y[-1]) for name, curve in curves.items() if np.isfinite(curve.y[-1])}
    order = sorted(ends, key=lambda name: ends[name])
    starts = np.clip((np.array([ends[name] for name in order]) - low) / (high - low), 0.0, 1.0)
    for name, start, place in zip(order, starts, spread(starts, 0.16 / (height - 0.8)), strict=True):
        color = styles[name]["color"]
        panel.plot([1.0, 1.02], [start, place], color=color, linewidth=0.8, transform=panel.transAxes, clip_on=False)
        panel.annotate(short(name), (1.025, place), xycoords="axes fraction", color=color, va="center", fontsize=8.5)


def spread(places: FloatArray, gap: float) -> FloatArray:
    """Return ascending places (K,) that are at least a gap apart, nearest to ascending ones by least squares.

    All stay below one, unless there are too many of them.
    """
    steps: FloatArray = gap * np.arange(len(places), dtype=np.float64)
    if not len(places):
        return steps
    apart: FloatArray = np.minimum(isotonic_regression(places - steps).x + steps, max(1.0, steps[-1]) - steps[::-1])
    return apart
