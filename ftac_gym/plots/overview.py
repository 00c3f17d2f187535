"""One episode in detail."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ftac_gym.evaluation.metrics import Rollout
from ftac_gym.faults.description import drawn_faults
from ftac_gym.plots.recording import true_effect
from ftac_gym.plots.style import FLOOR, INK, MUTED, check_same_flight, dress, folded, key, mark_onsets, sheet, stroke
from ftac_gym.task.episodes import Episodes
from ftac_gym.utils.parameters import FloatArray

ROWS = ("wheel torque\n[N m]", "wheel momentum\n[N m s]", "effectiveness\n[-]", "bias\n[N m]")
"""What is drawn of the wheels, from top to bottom."""


def episode(histories: Mapping[str, Rollout]) -> Figure:
    """Draw one episode in detail: errors of all policies, wheels of each, and the true fault.

    Flexible craft have a panel of their vibration besides. Dotted lines mark the limits of success, the limits of
    torque and momentum where the wheels come near them, and the moments at which faults strike.

    Parameters
    ----------
    histories
        Rollouts of the same single episode, by policy; of several episodes the first is drawn.

    Raises
    ------
    ValueError
        If there are no rollouts, or they do not fit each other.
    """
    first = check_same_flight(histories)
    flexible = first.modal_rate.shape[2] > 0
    upper = 3 if flexible else 2
    columns = len(histories)
    heights = [1.35] * upper + [1.25, 1.25, 0.9, 0.9]
    figure = sheet(max(9.0, 2.7 * columns + 0.8), 1.5 + sum(heights) * 1.25)
    grid = figure.add_gridspec(upper + 4, columns, height_ratios=heights)
    wide = [figure.add_subplot(grid[row, :]) for row in range(upper)]
    lines = _errors(wide, histories, flexible)
    dress(wide[0], title=folded(fault_description(first.episodes), int(figure.get_figwidth() * 11.0)))
    panels: list[Axes] = list(wide)
    # Policies are compared along a row: its panels share their scale.
    leaders: list[Axes | None] = [None] * 4
    for column, (name, history) in enumerate(histories.items()):
        drawn = _wheels(history)
        for row, (label, (time, values)) in enumerate(zip(ROWS, drawn, strict=True)):
            panel = figure.add_subplot(grid[upper + row, column], sharey=leaders[row])
            for wheel in range(values.shape[1]):
                panel.plot(time, values[:, wheel], linewidth=1.0, **stroke(wheel).of_line)
            dress(
                panel,
                title=name if row == 0 else "",
                xlabel="time [s]" if row == 3 else "",
                ylabel=label if column == 0 else "",
            )
            panel.tick_params(labelbottom=row == 3, labelleft=column == 0)
            if leaders[row] is None:
                leaders[row] = panel
            panels.append(panel)
    _limits(leaders, panels[upper:], histories)
    mark_onsets(panels, first.episodes, float(first.time[-1]))
    for panel in panels:
        panel.set_xlim(0.0, first.time[-1])
    wheels = [
        Line2D([], [], linewidth=1.4, label=f"wheel {wheel}", **stroke(wheel).of_line)
        for wheel in range(first.command.shape[2])
    ]
    key(figure, lines, "outside upper center", columns=8 if columns > 3 else 4)
    key(figure, wheels, "outside lower center", columns=8)
    return figure


def _errors(panels: list[Axes], histories: Mapping[str, Rollout], flexible: bool) -> list[Line2D]:
    """Draw errors, and the energy of the modes, of all policies; return the lines of the first panel."""
    first, lines = next(iter(histories.values())), []
    labels = ("pointing error\n[deg]", "rate error\n[deg/s]", "vibration energy\n[J]")
    for number, (name, history) in enumerate(histories.items()):
        drawn = [np.degrees(history.attitude_error[:, 0]), np.degrees(history.rate_error[:, 0])]
        if flexible:
            drawn.append(history.modal_energy[:, 0])
        for panel, values, floor in zip(panels, drawn, (FLOOR, FLOOR, 1e-12), strict=False):
            added = panel.plot(
                history.time, np.maximum(values, floor), linewidth=1.4, label=name, **stroke(number).of_line
            )
            lines += added if panel is panels[0] else []
    for panel, label in zip(panels, labels, strict=False):
        panel.set_yscale("log")
        dress(panel, ylabel=label)
    success = first.scenario.success
    for panel, limit in zip(panels, (success.angle, success.rate), strict=False):
        panel.axhline(np.degrees(limit), color=INK, linestyle=":", linewidth=1.2)
    if flexible:
        most = max(float(history.modal_energy[:, 0].max()) for history in histories.values())
        # Modes at rest have no energy at all, which would take all of a logarithmic scale.
        panels[2].set_ylim(bottom=max(1e-6 * most, 1e-12))
    dress(panels[-1], xlabel="time [s]")
    return lines


def _wheels(history: Rollout) -> tuple[tuple[FloatArray, FloatArray], ...]:
    """Return times (K,) and values (K, m) of what is drawn of the wheels, in the order of the rows."""
    effect, time = true_effect(history), history.time
    return (
        (time[1:], history.applied_torque[:, 0]),
        (time, history.wheel_momentum[:, 0]),
        (time, effect.effectiveness),
        (time, effect.bias),
    )


def _limits(leaders: list[Axes | None], panels: list[Axes], histories: Mapping[str, Rollout]) -> None:
    """Draw the limits of torque and momentum where some wheel comes near one: others would only flatten the lines."""
    wheels = next(iter(histories.values())).scenario.spacecraft.wheels
    torque = max(float(np.abs(history.applied_torque[:, 0]).max()) for history in histories.values())
    momentum = max(float(np.abs(history.wheel_momentum[:, 0]).max()) for history in histories.values())
    for row, (most, limits) in enumerate(((torque, wheels.torque_limits), (momentum, wheels.momentum_limits))):
        for panel in panels[row::4]:
            for limit in np.unique(limits[limits < 1.6 * most]):
                for edge in (-limit, limit):
                    panel.axhline(edge, color=MUTED, linestyle=":", linewidth=1.2)
    effectiveness = leaders[2]
    assert effectiveness is not None
    effectiveness.set_ylim(-0.06, 1.1)


def fault_description(episodes: Episodes, index: int = 0) -> str:
    """Return the faults of an episode with their onsets, or "healthy"."""
    return "; ".join(drawn_faults(episodes.drawn_faults, index)) or "healthy"
