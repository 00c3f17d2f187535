"""Pointing error of policies over many episodes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from ftac_gym.evaluation.batches import Evaluation
from ftac_gym.plots import style
from ftac_gym.utils.parameters import FloatArray, positive, require

ACROSS = 4
"""Most panels in a row."""

OVERLAID = 6
"""Most bands in one panel: more of them hide each other."""

PERCENTILES = (5.0, 25.0, 50.0, 75.0, 95.0)

Band = tuple[str, FloatArray]
"""A policy and its percentiles (5, T + 1)."""

_OTHERS: dict[str, Any] = {"color": "0.84", "linewidth": 0.8}


def error_bands(
    evaluations: Sequence[Evaluation],
    control_period: float,
    cone: float,
    chosen: npt.NDArray[np.bool_],
    overlay: bool = False,
) -> Figure:
    """Draw the pointing error of policies against time: median, middle half, and 5th to 95th percentile.

    Parameters
    ----------
    evaluations
        The policies, all on the same episodes.
    control_period
        [s].
    cone
        Success cone [deg], drawn as a line.
    chosen
        (N,) True for the episodes that count.
    overlay
        Draw all policies in one panel: their medians, and the middle halves of up to six. Otherwise each has a panel of
        its own, in rows of up to four, with the medians of the others as grey lines.

    Raises
    ------
    ValueError
        If there is no policy, no episode is chosen, or the period or the cone is not positive. Policies must have flown
        the same numbers of control periods and of episodes.
    """
    require(len(evaluations) > 0, "evaluations", "must hold at least one policy", list(evaluations))
    period, limit = positive(control_period, "control_period"), positive(cone, "cone")
    shape = evaluations[0].attitude_error.shape
    for evaluation in evaluations:
        same = evaluation.attitude_error.shape == shape
        require(same, "evaluations", f"must all have an error of shape {shape}", evaluation.attitude_error.shape)
    chosen = np.asarray(chosen)
    valid = chosen.shape == shape[1:] and chosen.dtype == np.bool_
    require(valid, "chosen", f"must be a boolean array of shape ({shape[1]},)", chosen)
    require(bool(chosen.any()), "chosen", "must choose at least one episode", int(chosen.sum()))
    bands = [(item.policy, error_percentiles(item.attitude_error[:, chosen])) for item in evaluations]
    time: FloatArray = np.arange(shape[0], dtype=np.float64) * period
    return _together(bands, time, limit) if overlay else _side_by_side(bands, time, limit)


def error_percentiles(error: npt.NDArray[np.float32] | FloatArray) -> FloatArray:
    """Return the drawn percentiles (5, T + 1) of errors (T + 1, N) [deg], at least the smallest error drawn."""
    found: FloatArray = np.percentile(np.maximum(error, style.FLOOR), PERCENTILES, axis=1)
    return found


def _side_by_side(bands: Sequence[Band], time: FloatArray, cone: float) -> Figure:
    rows = -(-len(bands) // ACROSS)
    columns = -(-len(bands) // rows)
    figure = style.figure(max(3.1 * columns + 0.5, 5.0), 2.7 * rows + 0.8)
    panels: list[Axes] = list(figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False).ravel())
    for number, (panel, (name, band)) in enumerate(zip(panels, bands, strict=False)):
        low, quarter, middle, three, high = band
        color = style.stroke(number).color
        for _, other in bands:
            if other is not band:
                panel.plot(time, other[2], zorder=1.0, **_OTHERS)
        panel.fill_between(time, low, high, color=color, alpha=0.15, linewidth=0.0)
        panel.fill_between(time, quarter, three, color=color, alpha=0.35, linewidth=0.0)
        panel.plot(time, middle, color=color, linewidth=1.6, label=name)
        title = style.name_in_lines(name, 32)
        limit = _finish(panel, time, cone, title=title, ylabel="pointing error [deg]" if number % columns == 0 else "")
        if number + columns >= len(bands):
            panel.tick_params(labelbottom=True)
            style.apply(panel, xlabel="time [s]")
    for panel in panels[len(bands) :]:
        panel.set_visible(False)
    handles: list[Any] = [style.entry("median", color=style.MUTED, linewidth=1.6)]
    handles += [_area("25 to 75 %", 0.5), _area("5 to 95 %", 0.2), limit]
    if len(bands) > 1:
        handles.append(style.entry("medians of the others", **_OTHERS))
    style.legend(figure, handles, columns=5 if columns > 2 else 3 if columns > 1 else 2)
    return figure


def _together(bands: Sequence[Band], time: FloatArray, cone: float) -> Figure:
    figure = style.figure(9.5, max(4.2, 1.0 + 0.24 * len(bands)))
    panel = figure.subplots()
    handles: list[Any] = []
    step = max(1, len(time) // 8)
    for number, (name, band) in enumerate(bands):
        look = style.stroke(number)
        if len(bands) <= OVERLAID:
            panel.fill_between(time, band[1], band[3], color=look.color, alpha=0.15, linewidth=0.0)
        # A few markers, none of them above those of another line.
        every = (int(step * (number + 0.5) / len(bands)), step)
        markers: dict[str, Any] = {"marker": look.marker, "markersize": 5.0, "markevery": every}
        handles += panel.plot(time, band[2], linewidth=1.6, label=name, **look.of_line, **markers)
    if len(bands) <= OVERLAID:
        handles.append(_area("25 to 75 %", 0.3))
    handles.append(_finish(panel, time, cone, xlabel="time [s]", ylabel="pointing error, median [deg]"))
    style.legend(figure, handles, "outside right upper", columns=1)
    return figure


def _area(label: str, alpha: float) -> Patch:
    return Patch(color=style.MUTED, alpha=alpha, linewidth=0.0, label=label)


def _finish(panel: Axes, time: FloatArray, cone: float, **labels: str) -> Line2D:
    """Set scales and labels, and return the line of the success cone."""
    panel.set(yscale="log", ylim=(style.FLOOR, 200.0), xlim=(0.0, time[-1]))
    style.apply(panel, **labels)
    return panel.axhline(cone, label=f"success: {cone:.3g} deg", **style.LIMIT)
