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
from ftac_gym.plots.style import FLOOR, INK, MUTED, Stroke, dress, key, sheet, stroke
from ftac_gym.utils.parameters import FloatArray, positive, require

ACROSS = 4
"""Most panels in a row."""

OVERLAID = 6
"""Most bands in one panel: more would be mud."""

PERCENTILES = (5.0, 25.0, 50.0, 75.0, 95.0)


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
        (N,) which episodes count.
    overlay
        Whether all policies share one panel: their medians, and the middle halves of up to six. Otherwise each has a
        panel of its own, in rows of up to four; with several policies the medians of the others are grey lines in it.

    Raises
    ------
    ValueError
        If there is no policy, no episode is chosen, policies have flown different numbers of control periods or
        episodes, or the period or the cone is not positive.
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
    bands = [error_percentiles(evaluation.attitude_error[:, chosen]) for evaluation in evaluations]
    names = [evaluation.policy for evaluation in evaluations]
    time: FloatArray = np.arange(shape[0], dtype=np.float64) * period
    return _together(names, bands, time, limit) if overlay else _side_by_side(names, bands, time, limit)


def error_percentiles(error: npt.NDArray[np.float32] | FloatArray) -> FloatArray:
    """Return the percentiles that are drawn, (5, T + 1), of errors (T + 1, N) [deg], none below what is drawn."""
    found: FloatArray = np.percentile(np.maximum(error, FLOOR), PERCENTILES, axis=1)
    return found


def _side_by_side(names: Sequence[str], bands: Sequence[FloatArray], time: FloatArray, cone: float) -> Figure:
    rows = -(-len(bands) // ACROSS)
    columns = -(-len(bands) // rows)
    figure = sheet(max(3.1 * columns + 0.5, 5.0), 2.7 * rows + 0.8)
    grid = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    panels: list[Axes] = list(grid.ravel())
    for number, (panel, name, band) in enumerate(zip(panels, names, bands, strict=False)):
        low, quarter, middle, three, high = band
        look = stroke(number)
        for other in (*bands[:number], *bands[number + 1 :]):
            panel.plot(time, other[2], color="0.84", linewidth=0.8, zorder=1.0, label="_other")
        panel.fill_between(time, low, high, color=look.color, alpha=0.15, linewidth=0.0)
        panel.fill_between(time, quarter, three, color=look.color, alpha=0.35, linewidth=0.0)
        panel.plot(time, middle, color=look.color, linewidth=1.6, label=name)
        _finish(panel, time, cone)
        dress(panel, title=name)
    for panel in panels[len(bands) :]:
        panel.set_visible(False)
    for number in range(len(bands)):
        if number + columns >= len(bands):
            panels[number].tick_params(labelbottom=True)
            dress(panels[number], xlabel="time [s]")
        if number % columns == 0:
            dress(panels[number], ylabel="pointing error [deg]")
    handles: list[Any] = [
        Line2D([], [], color=MUTED, linewidth=1.6, label="median"),
        Patch(color=MUTED, alpha=0.5, linewidth=0.0, label="25 to 75 %"),
        Patch(color=MUTED, alpha=0.2, linewidth=0.0, label="5 to 95 %"),
        _cone_line(cone),
    ]
    if len(bands) > 1:
        handles.append(Line2D([], [], color="0.84", linewidth=0.8, label="medians of the others"))
    key(figure, handles, columns=5 if columns > 2 else 3 if columns > 1 else 2)
    return figure


def _together(names: Sequence[str], bands: Sequence[FloatArray], time: FloatArray, cone: float) -> Figure:
    figure = sheet(9.5, max(4.2, 1.0 + 0.24 * len(bands)))
    panel = figure.subplots()
    handles: list[Any] = []
    for number, (name, band) in enumerate(zip(names, bands, strict=True)):
        look = stroke(number)
        if len(bands) <= OVERLAID:
            panel.fill_between(time, band[1], band[3], color=look.color, alpha=0.15, linewidth=0.0)
        handles += panel.plot(time, band[2], linewidth=1.6, label=name, **_marked(look, number, len(bands), len(time)))
    if len(bands) <= OVERLAID:
        handles.append(Patch(color=MUTED, alpha=0.3, linewidth=0.0, label="25 to 75 %"))
    handles.append(_cone_line(cone))
    _finish(panel, time, cone)
    dress(panel, xlabel="time [s]", ylabel="pointing error, median [deg]")
    key(figure, handles, "outside right upper", columns=1)
    return figure


def _marked(look: Stroke, number: int, count: int, length: int) -> dict[str, Any]:
    """Return the arguments of a line with a few markers, none of them above those of another line."""
    step = max(1, length // 8)
    start = int(step * (number + 0.5) / count)
    return {**look.of_line, "marker": look.marker, "markersize": 5.0, "markevery": (start, step)}


def _cone_line(cone: float) -> Line2D:
    return Line2D([], [], color=INK, linestyle=":", linewidth=1.2, label=f"success: {cone:.3g} deg")


def _finish(panel: Axes, time: FloatArray, cone: float) -> None:
    panel.axhline(cone, color=INK, linestyle=":", linewidth=1.2)
    panel.set(yscale="log", ylim=(FLOOR, 200.0), xlim=(0.0, time[-1]))
