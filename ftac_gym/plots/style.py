"""The one style of all figures: colours, strokes and axes, given to matplotlib piece by piece.

Nothing here changes matplotlib's settings, and no figure belongs to pyplot: a figure is drawn by whoever has it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from textwrap import fill
from typing import Any, Literal, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ftac_gym.evaluation.metrics import Rollout
from ftac_gym.task.episodes import Episodes
from ftac_gym.utils.parameters import require

# Okabe and Ito's colours, which the colour-blind can tell apart.
COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
FLOOR = 1e-4
"""Smallest pointing error drawn [deg]."""

INK, MUTED, FAINT, GRID = "#1b1b1d", "#6b6b70", "#c4c4c9", "#e3e3e7"
"""Text; labels of axes; what stands back; lines of the grid."""

LINES: tuple[Any, ...] = ("-", (0, (5.0, 1.6)), (0, (6.0, 1.5, 1.3, 1.5)), (0, (1.3, 1.1)))
"""Line styles: solid, dashed, dash and dot, densely dotted."""

MARKERS = ("o", "s", "^", "D", "v", "P", "X")

Place = Literal["outside lower center", "outside upper center", "outside right upper", "lower center"]
"""Where a legend can be."""


class Stroke(NamedTuple):
    """How one of several series is drawn; the first 28 differ in colour or line, neighbours in both."""

    color: str
    line: Any
    marker: str

    @property
    def of_line(self) -> dict[str, Any]:
        """The arguments of ``Axes.plot``."""
        return {"color": self.color, "linestyle": self.line}


def stroke(number: int) -> Stroke:
    """Return how series ``number``, counted from zero, is drawn."""
    return Stroke(COLORS[number % len(COLORS)], LINES[number % len(LINES)], MARKERS[number % len(MARKERS)])


def sheet(width: float, height: float) -> Figure:
    """Return an empty figure of a size [in]."""
    return Figure(figsize=(width, height), layout="constrained", facecolor="white")


def dress(panel: Axes, title: str = "", xlabel: str = "", ylabel: str = "") -> None:
    """Give axes the common look and their words; an empty word leaves what there is."""
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


def key(figure: Figure, handles: Iterable[Any], place: Place = "outside lower center", columns: int = 4) -> None:
    """Put a legend outside all axes, where it covers nothing.

    Parameters
    ----------
    figure
        Whose legend.
    handles
        What it explains, each with a label.
    place
        One of matplotlib's; outside the axes if it says so.
    columns
        Of the legend, at most.
    """
    shown = [handle for handle in handles if not str(handle.get_label()).startswith("_")]
    look: dict[str, Any] = {"fontsize": 8.5, "frameon": False, "handlelength": 2.8}
    legend = figure.legend(handles=shown, loc=place, ncols=max(1, min(columns, len(shown))), **look)
    for text in legend.get_texts():
        # Names of policies are text, whatever characters they have.
        text.set(parse_math=False, color=INK)


def head(figure: Figure, words: str) -> None:
    """Write what is wrong in an episode above a figure, in as many lines as that takes."""
    figure.suptitle(folded(words, int(figure.get_figwidth() * 12.0)), fontsize=10.0, color=INK)


def folded(words: str, width: int, mark: str = "; ") -> str:
    """Return a list in lines of about so many letters, which end at the marks between its entries."""
    # What is joined by hard spaces stays together.
    entries = mark.join(entry.replace(" ", "\N{NO-BREAK SPACE}") for entry in words.split(mark))
    lines = fill(entries, width, break_long_words=False, break_on_hyphens=False)
    return lines.replace("\N{NO-BREAK SPACE}", " ")


def mark_onsets(panels: Iterable[Axes], episodes: Episodes, duration: float) -> None:
    """Draw a line in each panel where a fault of the first episode strikes within the duration [s]."""
    wheels, sensors = episodes.faults[0], episodes.sensor_faults[0]
    onsets = np.concatenate([table["onset"][table["kind"] > 0].ravel() for table in (wheels, sensors)])
    shown = np.unique(onsets[onsets < duration])
    for panel in panels:
        for onset in shown:
            panel.axvline(onset, color=MUTED, linestyle=(0, (1.0, 2.0)), linewidth=1.0, zorder=1.5)


def check_same_flight(histories: Mapping[str, Rollout], field: str = "histories") -> Rollout:
    """Return the first of some rollouts.

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
