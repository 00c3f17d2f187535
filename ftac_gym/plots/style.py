"""The common style of all figures: colours, strokes, axes and legends.

Matplotlib's settings stay as they are, and no figure is registered with pyplot.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from textwrap import fill
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ftac_gym.evaluation.metrics import Rollout
from ftac_gym.faults.description import drawn_faults
from ftac_gym.task.episodes import Episodes
from ftac_gym.utils.parameters import require

# Okabe and Ito's colours, which the colour-blind can tell apart.
COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
FLOOR = 1e-4
"""Smallest pointing error drawn [deg]."""

INK, MUTED, FAINT, GRID = "#1b1b1d", "#6b6b70", "#c4c4c9", "#e3e3e7"
"""Text; labels of axes; lines in the background; lines of the grid."""

LIMIT: dict[str, Any] = {"color": INK, "linestyle": ":", "linewidth": 1.2}
TRUTH: dict[str, Any] = {"color": INK, "linestyle": ":", "linewidth": 1.8}
"""Arguments of ``Axes.plot`` for limits of success and the like, and for true values."""

LINES: tuple[Any, ...] = ("-", (0, (5.0, 1.6)), (0, (6.0, 1.5, 1.3, 1.5)), (0, (1.3, 1.1)))
"""Line styles: solid, dashed, dash and dot, densely dotted."""

MARKERS = ("o", "s", "^", "D", "v", "P", "X")


class Stroke(NamedTuple):
    """The look of one of several series; the first 28 differ in colour or line, neighbours in both."""

    color: str
    line: Any
    marker: str

    @property
    def of_line(self) -> dict[str, Any]:
        """The arguments of ``Axes.plot``."""
        return {"color": self.color, "linestyle": self.line}


def stroke(number: int) -> Stroke:
    """Return the look of series ``number``, counted from zero."""
    return Stroke(COLORS[number % len(COLORS)], LINES[number % len(LINES)], MARKERS[number % len(MARKERS)])


def figure(width: float, height: float) -> Figure:
    """Return an empty figure of a size [in]."""
    return Figure(figsize=(width, height), layout="constrained", facecolor="white")


def apply(panel: Axes, title: str = "", xlabel: str = "", ylabel: str = "") -> None:
    """Give axes the common look and their labels; an empty label leaves the present one."""
    panel.set_facecolor("none")
    panel.grid(color=GRID, linewidth=0.8)
    panel.set_axisbelow(True)
    panel.spines[["top", "right"]].set_visible(False)
    panel.spines[["left", "bottom"]].set_color(FAINT)
    panel.tick_params(which="both", colors=MUTED, labelsize=8.5, color=FAINT)
    if title:
        panel.set_title(title, fontsize=10.0, color=INK, loc="left", parse_math=False)
    if xlabel:
        panel.set_xlabel(xlabel, fontsize=9.0, color=INK)
    if ylabel:
        panel.set_ylabel(ylabel, fontsize=9.0, color=INK)


def entry(label: str, **look: Any) -> Line2D:
    """Return a line for a legend."""
    return Line2D([], [], label=label, **look)


def entries(labels: Iterable[str], **look: Any) -> list[Line2D]:
    """Return the lines of numbered series for a legend."""
    return [entry(label, **stroke(number).of_line, **look) for number, label in enumerate(labels)]


def legend(chart: Figure, handles: Iterable[Any], place: str = "outside lower center", columns: int = 4) -> None:
    """Add a legend outside all axes, where it covers nothing.

    Parameters
    ----------
    chart
        The figure.
    handles
        Its entries, each with a label.
    place
        One of matplotlib's places; outside the axes if it says so.
    columns
        Most columns of the legend.
    """
    shown = [handle for handle in handles if not str(handle.get_label()).startswith("_")]
    look: dict[str, Any] = {"loc": place, "fontsize": 8.5, "frameon": False, "handlelength": 2.8}
    for text in chart.legend(handles=shown, ncols=max(1, min(columns, len(shown))), **look).get_texts():
        # Names of policies are text, whatever characters they have.
        text.set(parse_math=False, color=INK)


def fault_description(episodes: Episodes, index: int = 0) -> str:
    """Return the faults of an episode with their onsets, or "healthy"."""
    return "; ".join(drawn_faults(episodes.drawn_faults, index)) or "healthy"


def describe_episode(chart: Figure, panels: Iterable[Axes], history: Rollout) -> None:
    """Write the faults of the first episode above a figure, and mark their onsets in panels over time."""
    faults = wrapped(fault_description(history.episodes), int(chart.get_figwidth() * 12.0))
    chart.suptitle(faults, fontsize=10.0, color=INK)
    mark_onsets(panels, history)


def mark_onsets(panels: Iterable[Axes], history: Rollout) -> None:
    """Limit panels to the time of a rollout, and draw a line where a fault of its first episode occurs."""
    end = float(history.time[-1])
    tables = history.episodes.faults[0], history.episodes.sensor_faults[0]
    onsets = np.concatenate([table["onset"][table["kind"] > 0].ravel() for table in tables])
    for panel in panels:
        for onset in np.unique(onsets[onsets < end]):
            panel.axvline(onset, color=MUTED, linestyle=(0, (1.0, 2.0)), linewidth=1.0, zorder=1.5)
        panel.set_xlim(0.0, end)


def wrapped(text: str, width: int, mark: str = "; ") -> str:
    """Return a list in lines of about so many letters, which end at the marks between its entries."""
    # Words that are joined by hard spaces stay together.
    items = mark.join(item.replace(" ", "\N{NO-BREAK SPACE}") for item in text.split(mark))
    lines = fill(items, width, break_long_words=False, break_on_hyphens=False)
    return lines.replace("\N{NO-BREAK SPACE}", " ")


def name_in_lines(name: str, width: int) -> str:
    """Return the name of a policy in lines of about so many letters, which end at blanks and slashes."""
    lines = [""]
    for part in re.findall(r"[^ /]*[ /]|[^ /]+", name):
        if lines[-1] and len(lines[-1]) + len(part.rstrip()) > width:
            lines.append("")
        lines[-1] += part
    return "\n".join(line.rstrip() for line in lines)


def first_of(histories: Mapping[str, Rollout], field: str = "histories") -> Rollout:
    """Return the first of some rollouts of the same episode.

    Raises
    ------
    ValueError
        If there are none, or they differ in their times or in the number of wheels.
    """
    require(len(histories) > 0, field, "must hold at least one rollout", dict(histories))
    first = next(iter(histories.values()))
    for name, history in histories.items():
        same = np.array_equal(history.time, first.time) and history.command.shape[2] == first.command.shape[2]
        require(same, field, "must all have the same times and the same number of wheels", name)
    return first
