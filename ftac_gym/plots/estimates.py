"""Estimates of faults against the truth."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from ftac_gym.evaluation.metrics import Rollout
from ftac_gym.plots.overview import fault_description
from ftac_gym.plots.recording import EstimateHistory, true_effect, unexplained_torque
from ftac_gym.plots.style import INK, MUTED, check_same_flight, dress, head, key, mark_onsets, sheet, stroke
from ftac_gym.utils.parameters import FloatArray, require

_LABELS = {"effectiveness": "effectiveness [-]", "bias": "bias [N m]"}
_HATCH = "0.9"


def fault_estimates(estimates: Mapping[str, EstimateHistory]) -> Figure:
    """Draw estimated effectiveness and bias of each wheel against the truth, one row per wheel.

    The truth is that of the first flight. Where a wheel has not been given enough torque to tell its effectiveness, the
    estimate is a thin line, and with one observer the background is grey. Biases that cancel each other in the torque
    on the body cannot be seen by it: with more wheels than axes, a grey line shows the rest of the true bias, which is
    all that an observer of the body's motion can find.

    Parameters
    ----------
    estimates
        What :func:`estimates_along` returns, of the same single episode, by observer; of several episodes the first is
        drawn.

    Raises
    ------
    ValueError
        If there are no estimates, they do not fit each other, or none is of single wheels.
    """
    first = _first(estimates)
    parts = [part for part in _LABELS if any(getattr(item, part) is not None for item in estimates.values())]
    require(len(parts) > 0, "estimates", "must have effectiveness or bias of wheels", list(estimates))
    wheels = first.scenario.spacecraft.wheels
    figure = sheet(4.6 * len(parts) + 0.6, 1.3 * wheels.count + 1.3)
    panels = figure.subplots(wheels.count, len(parts), sharex=True, sharey="col", squeeze=False)
    effect = true_effect(first)
    seen = _seen(effect.bias, wheels.axis_matrix)
    for column, part in enumerate(parts):
        for wheel in range(wheels.count):
            panel: Axes = panels[wheel, column]
            if part == "bias" and seen is not None:
                panel.plot(first.time, seen[:, wheel], color="0.72", linewidth=2.4, label="_seen", zorder=1.8)
            panel.plot(first.time, getattr(effect, part)[:, wheel], color=INK, linestyle=":", linewidth=1.8, zorder=3)
            for number, item in enumerate(estimates.values()):
                _draw(panel, item, part, wheel, number, alone=len(estimates) == 1)
            dress(panel, ylabel=f"wheel {wheel}\n{_LABELS[part]}")
            panel.set_xlim(0.0, first.time[-1])
        dress(panels[-1, column], xlabel="time [s]")
        if part == "effectiveness":
            panels[0, column].set_ylim(-0.08, 1.16)
    mark_onsets(panels.ravel(), first.episodes, float(first.time[-1]))
    head(figure, fault_description(first.episodes))
    handles = _handles(estimates, seen is not None and "bias" in parts)
    key(figure, handles, columns=4 if len(handles) <= 4 and len(parts) > 1 else 3 if len(parts) > 1 else 2)
    return figure


def torque_estimates(estimates: Mapping[str, EstimateHistory]) -> Figure:
    """Draw the torque on the body that the commands do not explain, as believed, against the truth, axis by axis.

    The truth is what the wheels of the first flight gave too little or too much; the external disturbance is no part of
    it, and errors of the model are in the estimates alone. Where an observer estimates the torque of the vibration
    modes, that has a second row.

    Parameters
    ----------
    estimates
        What :func:`estimates_along` returns, of the same single episode, by observer; of several episodes the first is
        drawn.

    Raises
    ------
    ValueError
        If there are no estimates, or they do not fit each other.
    """
    first = _first(estimates)
    wanted = {name: item.unexplained for name, item in estimates.items()}
    rows: list[tuple[str, Mapping[str, FloatArray | None], FloatArray]] = [
        ("unexplained torque [N m]", wanted, unexplained_torque(first))
    ]
    if any(item.vibration is not None for item in estimates.values()):
        swinging = {name: item.vibration for name, item in estimates.items()}
        rows.append(("torque of the modes [N m]", swinging, first.vibration_torque[:, 0]))
    figure = sheet(10.5, 2.6 * len(rows) + 0.9)
    panels = figure.subplots(len(rows), 3, sharex=True, sharey="row", squeeze=False)
    for row, (label, believed, truth) in enumerate(rows):
        for axis in range(3):
            panel: Axes = panels[row, axis]
            for number, values in enumerate(believed.values()):
                if values is not None:
                    panel.plot(first.time, values[:, 0, axis], linewidth=1.2, **stroke(number).of_line)
            panel.plot(first.time, truth[:, axis], color=INK, linestyle=":", linewidth=1.8)
            panel.set_xlim(0.0, first.time[-1])
            dress(panel, title="xyz"[axis] if row == 0 else "", ylabel=label if axis == 0 else "")
            if row == len(rows) - 1:
                dress(panel, xlabel="time [s]")
    mark_onsets(panels.ravel(), first.episodes, float(first.time[-1]))
    head(figure, fault_description(first.episodes))
    handles = [_line(name, number) for number, name in enumerate(estimates)]
    key(figure, [*handles, _truth()], columns=5)
    return figure


def _first(estimates: Mapping[str, EstimateHistory]) -> Rollout:
    require(len(estimates) > 0, "estimates", "must hold at least one observer", dict(estimates))
    return check_same_flight({name: item.history for name, item in estimates.items()}, "estimates")


def _seen(bias: FloatArray, axes: FloatArray) -> FloatArray | None:
    """Return the part (T + 1, m) of biases that turns the body; None where that is all of them."""
    projection: FloatArray = np.linalg.pinv(axes) @ axes
    return None if np.allclose(projection, np.eye(axes.shape[1])) else bias @ projection


def _draw(panel: Axes, item: EstimateHistory, part: str, wheel: int, number: int, alone: bool) -> None:
    values: FloatArray | None = getattr(item, part)
    if values is None:
        return
    time, line, look = item.history.time, values[:, 0, wheel], stroke(number)
    # Without torque a wheel's effectiveness cannot be told; its bias shows all the better.
    if part == "effectiveness" and item.identifiable is not None:
        known = item.identifiable[:, 0, wheel]
        if alone:
            panel.fill_between(
                time, 0.0, 1.0, where=~known, transform=panel.get_xaxis_transform(), color=_HATCH, linewidth=0.0
            )
        panel.plot(time, line, color=look.color, linewidth=0.7, alpha=0.7)
        line = np.where(known, line, np.nan)
    panel.plot(time, line, linewidth=1.6, **look.of_line)


def _handles(estimates: Mapping[str, EstimateHistory], seen: bool) -> list[Any]:
    handles: list[Any] = [_line(name, number) for number, name in enumerate(estimates)]
    handles.append(_truth())
    if seen:
        handles.append(Line2D([], [], color="0.72", linewidth=2.4, label="part of the truth that turns the body"))
    if any(item.identifiable is not None for item in estimates.values()):
        label = "too little torque to tell"
        if len(estimates) == 1:
            handles.append(Patch(color=_HATCH, linewidth=0.0, label=label))
        else:
            handles.append(Line2D([], [], color=MUTED, linewidth=0.7, label=label))
    return handles


def _line(name: str, number: int) -> Line2D:
    return Line2D([], [], linewidth=1.6, label=name, **stroke(number).of_line)


def _truth() -> Line2D:
    return Line2D([], [], color=INK, linestyle=":", linewidth=1.8, label="truth")
