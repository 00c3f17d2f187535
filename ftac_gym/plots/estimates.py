"""Estimates of faults against the truth."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from ftac_gym.evaluation.metrics import Rollout
from ftac_gym.evaluation.truth import true_effect, unexplained_torque
from ftac_gym.plots import style
from ftac_gym.plots.recording import EstimateHistory
from ftac_gym.utils.parameters import FloatArray, require

_LABELS = {"effectiveness": "effectiveness [-]", "bias": "bias [N m]"}
_OBSERVABLE: dict[str, Any] = {"color": "0.72", "linewidth": 2.4}
_HATCH = "0.9"


def fault_estimates(estimates: Mapping[str, EstimateHistory]) -> Figure:
    """Draw estimated effectiveness and bias of each wheel against the truth, one row per wheel.

    The truth is that of the first rollout. The effectiveness of a wheel with too little torque cannot be identified:
    there the estimate is a thin line, and with one observer the background is grey. Biases that cancel in the torque on
    the body have no effect on its motion. With more wheels than axes, a grey line shows the rest of the true bias, the
    part that an observer of the body's motion can estimate.

    Parameters
    ----------
    estimates
        Results of :func:`~ftac_gym.plots.estimates_along` for the same single episode, by observer; of several episodes
        the first is drawn.

    Raises
    ------
    ValueError
        If there are no estimates, they do not fit each other, or none is of single wheels.
    """
    first = _first(estimates)
    parts = [part for part in _LABELS if any(getattr(item, part) is not None for item in estimates.values())]
    require(len(parts) > 0, "estimates", "must have effectiveness or bias of wheels", list(estimates))
    wheels = first.scenario.spacecraft.wheels
    figure = style.figure(4.6 * len(parts) + 0.6, 1.3 * wheels.count + 1.3)
    panels = figure.subplots(wheels.count, len(parts), sharex=True, sharey="col", squeeze=False)
    effect = true_effect(first)
    observable = _observable(effect.bias, wheels.axis_matrix) if "bias" in parts else None
    for (wheel, column), panel in np.ndenumerate(panels):
        part = parts[column]
        if part == "bias" and observable is not None:
            panel.plot(first.time, observable[:, wheel], zorder=1.8, **_OBSERVABLE)
        panel.plot(first.time, getattr(effect, part)[:, wheel], zorder=3, **style.TRUTH)
        for number, item in enumerate(estimates.values()):
            _draw(panel, item, part, wheel, number, alone=len(estimates) == 1)
        last = wheel == wheels.count - 1
        style.apply(panel, ylabel=f"wheel {wheel}\n{_LABELS[part]}", xlabel="time [s]" if last else "")
        if part == "effectiveness":
            panel.set_ylim(-0.08, 1.16)
    style.describe_episode(figure, panels.ravel(), first)
    handles: list[Any] = [*style.entries(estimates, linewidth=1.6), style.entry("truth", **style.TRUTH)]
    if observable is not None:
        handles.append(style.entry("part of the truth that turns the body", **_OBSERVABLE))
    if any(item.identifiable is not None for item in estimates.values()):
        label = "too little torque to identify"
        alone = Patch(color=_HATCH, linewidth=0.0, label=label)
        handles.append(alone if len(estimates) == 1 else style.entry(label, color=style.MUTED, linewidth=0.7))
    style.legend(figure, handles, columns=4 if len(handles) <= 4 and len(parts) > 1 else 3 if len(parts) > 1 else 2)
    return figure


def torque_estimates(estimates: Mapping[str, EstimateHistory]) -> Figure:
    """Draw the estimated torque on the body that the commands do not explain against the truth, axis by axis.

    The truth is the excess or lack of the wheels' torque in the first rollout. It leaves out the external disturbance,
    and errors of the model are in the estimates alone. An observer that estimates the torque of the vibration modes
    adds a second row for it.

    Parameters
    ----------
    estimates
        As for :func:`fault_estimates`.

    Raises
    ------
    ValueError
        If there are no estimates, or they do not fit each other.
    """
    first, items = _first(estimates), estimates.values()
    rows: list[tuple[str, list[FloatArray | None], FloatArray]] = [
        ("unexplained torque [N m]", [item.unexplained for item in items], unexplained_torque(first))
    ]
    if any(item.vibration is not None for item in items):
        rows.append(("torque of the modes [N m]", [item.vibration for item in items], first.vibration_torque[:, 0]))
    figure = style.figure(10.5, 2.6 * len(rows) + 0.9)
    panels = figure.subplots(len(rows), 3, sharex=True, sharey="row", squeeze=False)
    for (row, axis), panel in np.ndenumerate(panels):
        label, estimated, truth = rows[row]
        for number, values in enumerate(estimated):
            if values is not None:
                panel.plot(first.time, values[:, 0, axis], linewidth=1.2, **style.stroke(number).of_line)
        panel.plot(first.time, truth[:, axis], **style.TRUTH)
        style.apply(panel, "xyz"[axis] if row == 0 else "", ylabel=label if axis == 0 else "")
        style.apply(panel, xlabel="time [s]" if row == len(rows) - 1 else "")
    style.describe_episode(figure, panels.ravel(), first)
    style.legend(figure, [*style.entries(estimates, linewidth=1.6), style.entry("truth", **style.TRUTH)], columns=5)
    return figure


def _first(estimates: Mapping[str, EstimateHistory]) -> Rollout:
    require(len(estimates) > 0, "estimates", "must hold at least one observer", dict(estimates))
    return style.first_of({name: item.history for name, item in estimates.items()}, "estimates")


def _observable(bias: FloatArray, axes: FloatArray) -> FloatArray | None:
    """Return the part (T + 1, m) of biases that turns the body; None where that is all of them."""
    projection: FloatArray = np.linalg.pinv(axes) @ axes
    return None if np.allclose(projection, np.eye(axes.shape[1])) else bias @ projection


def _draw(panel: Axes, item: EstimateHistory, part: str, wheel: int, number: int, alone: bool) -> None:
    values: FloatArray | None = getattr(item, part)
    if values is None:
        return
    time, line, look = item.history.time, values[:, 0, wheel], style.stroke(number)
    # Without torque the effectiveness of a wheel cannot be identified, but its bias can.
    if part == "effectiveness" and item.identifiable is not None:
        known = item.identifiable[:, 0, wheel]
        if alone:
            across = panel.get_xaxis_transform()
            panel.fill_between(time, 0.0, 1.0, where=~known, transform=across, color=_HATCH, linewidth=0.0)
        panel.plot(time, line, color=look.color, linewidth=0.7, alpha=0.7)
        line = np.where(known, line, np.nan)
    panel.plot(time, line, linewidth=1.6, **look.of_line)
