"""Draw one flight of a baseline: errors, wheel torques, and what its observer believes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ftac_gym.evaluation.metrics import Rollout
from ftac_gym.plots import FLOOR, EstimateHistory, faults_in_words, stroke, true_effect
from ftac_gym.plots.recording import unexplained_torque
from ftac_gym.plots.style import INK, MUTED, dress, folded, mark_onsets
from ftac_gym.utils.parameters import FloatArray

Flight = tuple[Rollout, EstimateHistory]

LABELS = {
    "torque": "wheel torque\n[N m]",
    "effectiveness": "effectiveness\n[-]",
    "bias": "bias\n[N m]",
    "unexplained": "unexplained\ntorque [N m]",
    "vibration": "torque of the\nmodes [N m]",
}
"""What is drawn below the errors, with its label."""
WIDTH, PANEL, LINE, BOTTOM, GAP, LEFT, RIGHT, LABEL = 8.6, 1.15, 0.16, 0.78, 0.3, 0.85, 0.15, 0.45
"""Sizes [in] of the figure, of a panel, of a line of the title, of the room about the panels, and of that
between a panel and its label."""

BOX: dict[str, Any] = {"framealpha": 0.8, "edgecolor": "none", "borderpad": 0.2}
"""What is behind a legend within a panel."""


def rows_of(estimates: EstimateHistory, takes_torques: bool) -> list[str]:
    """Return what there is to draw of an observer's estimates, in the order of the rows.

    Parameters
    ----------
    estimates
        What it believed.
    takes_torques
        Whether the law puts a torque on the body to use where nothing is known of the biases of wheels.
    """
    rows = [part for part in ("effectiveness", "bias") if getattr(estimates, part) is not None]
    rows += ["unexplained"] * (takes_torques and estimates.bias is None and estimates.disturbance is not None)
    return rows + ["vibration"] * (estimates.vibration is not None)


def draw(flights: Mapping[str, Flight], rows: list[str]) -> Figure:
    """Draw flights of the same episode.

    Parameters
    ----------
    flights
        By the words that tell them apart.
    rows
        What to draw of the estimates, of :data:`LABELS`.
    """
    first = next(iter(flights.values()))[0]
    rows = ["torque", *rows]
    title = folded(faults_in_words(first.episodes, 0), 105)
    count, columns = 2 + len(rows), len(flights)
    top = 0.2 + LINE * (1 + title.count("\n"))
    height = top + BOTTOM + count * PANEL + (count - 1) * GAP
    figure = Figure(figsize=(WIDTH, height), facecolor="white")
    # Placed by hand: matplotlib's own layouts take longer than the flights.
    room = {"left": LEFT / WIDTH, "right": 1.0 - RIGHT / WIDTH, "bottom": BOTTOM / height, "top": 1.0 - top / height}
    grid = figure.add_gridspec(count, columns, hspace=GAP / PANEL, wspace=0.1, **room)
    panels = [figure.add_subplot(grid[row, :]) for row in range(2)]
    _errors(panels, flights)
    for row, part in enumerate(rows):
        leader: Axes | None = None
        for column, (words, flight) in enumerate(flights.items()):
            panel = figure.add_subplot(grid[2 + row, column], sharey=leader)
            _part(panel, part, flight)
            last = row == len(rows) - 1
            dress(panel, ylabel=LABELS[part] if column == 0 else "", xlabel="time [s]" if last else "")
            panel.tick_params(labelbottom=last, labelleft=column == 0)
            if row == 0 and columns > 1:
                _note(panel, f"{words} gains")
            panels.append(panel)
            leader = leader or panel
        assert leader is not None
        _limits(leader, part, flights)
    mark_onsets(panels, first.episodes, float(first.time[-1]))
    for panel in panels:
        panel.set_xlim(0.0, first.time[-1])
    panels[0].set_title(title, fontsize=9.5, color=INK, loc="left")
    figure.legend(handles=_key(first, rows), loc="lower center", ncols=8, fontsize=8.5, frameon=False, handlelength=2.4)
    for panel in panels:
        # As align_ylabels would, which measures every tick of every panel anew for each of them.
        panel.yaxis.set_label_coords(-LABEL / (WIDTH * panel.get_position().width), 0.5)
    return figure


def _note(panel: Axes, words: str) -> None:
    box = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.5}
    panel.text(0.99, 0.92, words, transform=panel.transAxes, ha="right", va="top", fontsize=8.5, color=INK, bbox=box)


def _errors(panels: list[Axes], flights: Mapping[str, Flight]) -> None:
    labels = ("pointing error\n[deg]", "rate error\n[deg/s]")
    for number, (words, (history, _)) in enumerate(flights.items()):
        for panel, error in zip(panels, (history.attitude_error, history.rate_error), strict=True):
            drawn = np.maximum(np.degrees(error[:, 0]), FLOOR)
            panel.plot(history.time, drawn, linewidth=1.4, label=f"{words} gains", **stroke(number).of_line)
    success = history.scenario.success
    for panel, label, limit in zip(panels, labels, (success.angle, success.rate), strict=True):
        panel.set_yscale("log")
        panel.axhline(np.degrees(limit), color=INK, linestyle=":", linewidth=1.2)
        panel.minorticks_off()
        dress(panel, ylabel=label)
    panels[0].tick_params(labelbottom=False)
    panels[1].tick_params(labelbottom=len(flights) > 1)
    if len(flights) > 1:
        panels[0].legend(loc="upper right", fontsize=8.5, ncols=2, handlelength=2.8, **BOX)


def _part(panel: Axes, part: str, flight: Flight) -> None:
    history, time = flight[0], flight[0].time
    if part == "torque":
        for wheel, torque in enumerate(history.applied_torque[:, 0].T):
            panel.plot(time[1:], torque, linewidth=0.9, color=stroke(wheel).color)
        return
    for index, (values, truth) in enumerate(zip(*_pair(part, flight), strict=True)):
        panel.plot(time, values, linewidth=1.2, color=stroke(index).color)
        panel.plot(time, truth, linewidth=1.6, color=stroke(index).color, linestyle=(0, (1.0, 1.4)), zorder=3)
    if part in ("unexplained", "vibration"):
        # The colours of the first wheels stand for axes here, which the panel has to say itself.
        axes = [Line2D([], [], color=stroke(axis).color, label="xyz"[axis]) for axis in range(3)]
        panel.legend(handles=axes, loc="upper right", fontsize=7.5, ncols=3, handlelength=1.2, **BOX)


def _pair(part: str, flight: Flight) -> tuple[FloatArray, FloatArray]:
    """Return what is believed and what is true of a part, each with one row for each wheel or axis."""
    history, believed = flight
    if part == "unexplained":
        return believed.unexplained[:, 0].T, unexplained_torque(history).T
    if part == "vibration":
        assert believed.vibration is not None
        return believed.vibration[:, 0].T, history.vibration_torque[:, 0].T
    return getattr(believed, part)[:, 0].T, getattr(true_effect(history), part).T


def _limits(panel: Axes, part: str, flights: Mapping[str, Flight]) -> None:
    """Set the scale of a row: a short swing of an estimate must not flatten all the rest."""
    if part == "effectiveness":
        panel.set_ylim(-0.06, 1.12)
    elif part == "torque":
        histories = [history for history, _ in flights.values()]
        most = max(float(np.abs(history.applied_torque[:, 0]).max()) for history in histories)
        limits = histories[0].scenario.spacecraft.wheels.torque_limits
        for limit in np.unique(limits[limits < 1.6 * most]):
            for line in panel.figure.axes:
                if line is panel or line.get_shared_y_axes().joined(line, panel):
                    line.axhline(limit, color=MUTED, linestyle=":", linewidth=1.2)
                    line.axhline(-limit, color=MUTED, linestyle=":", linewidth=1.2)
    else:
        pairs = [values for flight in flights.values() for values in _pair(part, flight)]
        reach = 1.3 * max(float(np.percentile(np.abs(values).max(axis=0), 98.0)) for values in pairs)
        panel.set_ylim(-max(reach, 1e-6), max(reach, 1e-6))


def _key(history: Rollout, rows: list[str]) -> list[Line2D]:
    wheels = history.command.shape[2]
    lines = [Line2D([], [], linewidth=1.4, color=stroke(n).color, label=f"wheel {n}") for n in range(wheels)]
    if len(rows) > 1:
        lines.append(Line2D([], [], linewidth=1.4, color=MUTED, label="believed"))
        lines.append(Line2D([], [], linewidth=1.6, color=MUTED, linestyle=(0, (1.0, 1.4)), label="true"))
    return lines
