"""One episode in detail."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ftac_gym.evaluation.metrics import Rollout
from ftac_gym.evaluation.truth import true_effect
from ftac_gym.plots import style
from ftac_gym.utils.parameters import FloatArray

ERRORS = ("pointing error\n[deg]", "rate error\n[deg/s]", "vibration energy\n[J]")
"""Rows of all policies, from top to bottom."""

ROWS = ("wheel torque\n[N m]", "wheel momentum\n[N m s]", "effectiveness\n[-]", "bias\n[N m]")
"""Rows of the wheels, from top to bottom."""


def episode(histories: Mapping[str, Rollout]) -> Figure:
    """Draw one episode in detail: errors of all policies, wheels of each, and the true fault.

    Flexible spacecraft have a further panel for their vibration. Dotted lines mark the limits of success and the onsets
    of faults, and the limits of torque and momentum where the wheels come near them.

    Parameters
    ----------
    histories
        Rollouts of the same single episode, by policy; of several episodes the first is drawn.

    Raises
    ------
    ValueError
        If there are no rollouts, or they do not fit each other.
    """
    first = style.first_of(histories)
    upper = 3 if first.modal_rate.shape[2] else 2
    columns = len(histories)
    heights = [1.35] * upper + [1.25, 1.25, 0.9, 0.9]
    figure = style.figure(max(9.0, 2.7 * columns + 0.8), 1.5 + sum(heights) * 1.25)
    grid = figure.add_gridspec(upper + 4, columns, height_ratios=heights)
    wide = [figure.add_subplot(grid[row, :]) for row in range(upper)]
    _draw_errors(wide, histories)
    description = style.fault_description(first.episodes)
    style.apply(wide[0], title=style.wrapped(description, int(figure.get_figwidth() * 11.0)))
    style.apply(wide[-1], xlabel="time [s]")
    # The panels of a row share their scale, so that policies can be compared.
    rows: list[list[Axes]] = [[], [], [], []]
    letters = int(10.0 * (figure.get_figwidth() - 0.8) / columns)
    for column, (name, history) in enumerate(histories.items()):
        title = style.name_in_lines(name, letters)
        for row, (time, values) in enumerate(_wheels(history)):
            panel = figure.add_subplot(grid[upper + row, column], sharey=rows[row][0] if column else None)
            rows[row].append(panel)
            for wheel in range(values.shape[1]):
                panel.plot(time, values[:, wheel], linewidth=1.0, **style.stroke(wheel).of_line)
            style.apply(panel, title if row == 0 else "", ylabel=ROWS[row] if column == 0 else "")
            style.apply(panel, xlabel="time [s]" if row == 3 else "")
            panel.tick_params(labelbottom=row == 3, labelleft=column == 0)
    _draw_limits(rows, histories)
    rows[2][0].set_ylim(-0.06, 1.1)
    style.mark_onsets(figure.axes, first)
    most = 8 if columns > 3 else 4
    style.legend(figure, style.entries(histories, linewidth=1.4), "outside upper center", columns=most)
    wheels = [f"wheel {wheel}" for wheel in range(first.command.shape[2])]
    style.legend(figure, style.entries(wheels, linewidth=1.4), columns=8)
    return figure


def _draw_errors(panels: Sequence[Axes], histories: Mapping[str, Rollout]) -> None:
    """Draw errors, and the energy of the modes if there is a panel for it, of all policies."""
    for number, history in enumerate(histories.values()):
        errors = np.degrees(history.attitude_error), np.degrees(history.rate_error), history.modal_energy
        for panel, values, floor in zip(panels, errors, (style.FLOOR, style.FLOOR, 1e-12), strict=False):
            panel.plot(history.time, np.maximum(values[:, 0], floor), linewidth=1.4, **style.stroke(number).of_line)
    for panel, label in zip(panels, ERRORS, strict=False):
        panel.set_yscale("log")
        style.apply(panel, ylabel=label)
    success = next(iter(histories.values())).scenario.success
    for panel, limit in zip(panels, (success.angle, success.rate), strict=False):
        panel.axhline(np.degrees(limit), **style.LIMIT)
    if len(panels) > 2:
        most = max(float(history.modal_energy[:, 0].max()) for history in histories.values())
        # Modes at rest have no energy at all, which would take all of a logarithmic scale.
        panels[2].set_ylim(bottom=max(1e-6 * most, 1e-12))


def _wheels(history: Rollout) -> tuple[tuple[FloatArray, FloatArray], ...]:
    """Return times (K,) and values (K, m) of each row of the wheels."""
    effect, time = true_effect(history), history.time
    return (
        (time[1:], history.applied_torque[:, 0]),
        (time, history.wheel_momentum[:, 0]),
        (time, effect.effectiveness),
        (time, effect.bias),
    )


def _draw_limits(rows: Sequence[Sequence[Axes]], histories: Mapping[str, Rollout]) -> None:
    """Draw the limits of torque and momentum where some wheel comes near one: others would only flatten the lines."""
    wheels = next(iter(histories.values())).scenario.spacecraft.wheels
    limits = {"applied_torque": wheels.torque_limits, "wheel_momentum": wheels.momentum_limits}
    for panels, (name, given) in zip(rows, limits.items(), strict=False):
        most = max(float(np.abs(getattr(history, name)[:, 0]).max()) for history in histories.values())
        near = np.unique(given[given < 1.6 * most])
        for panel in panels:
            for edge in (*near, *-near):
                panel.axhline(edge, color=style.MUTED, linestyle=":", linewidth=1.2)
