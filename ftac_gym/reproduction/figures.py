"""Figures that correspond to the papers': attitude, torque, estimates, and schemes side by side."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ftac_gym.plots.style import COLORS, INK, dress, stroke
from ftac_gym.reproduction.flight import Flight
from ftac_gym.task.prescribed_bound import PrescribedBound
from ftac_gym.utils.parameters import FloatArray

POINTS = 1500
"""Most points of a line; the rest would not be seen."""


def _thinned(flight: Flight) -> tuple[slice, FloatArray]:
    # An odd stride: every second sample of a torque that chatters from step to step would show it at rest.
    every = slice(None, None, max(1, len(flight.time) // POINTS) | 1)
    return every, flight.time[every]


def _panels(flights: Mapping[str, Flight], height: float) -> tuple[Figure, list[Axes]]:
    figure = Figure(figsize=(3.4 * len(flights), height), layout="constrained")
    panels = figure.subplots(1, len(flights), squeeze=False)[0]
    for panel, (name, flight) in zip(panels, flights.items(), strict=True):
        panel.set(title=name, xlabel="time [s]", xlim=(0.0, flight.time[-1]))
        dress(panel)
    return figure, list(panels)


def attitude(flights: Mapping[str, Flight]) -> Figure:
    """Draw the attitude in MRPs against the reference, dotted, one panel per flight."""
    figure, panels = _panels(flights, 3.4)
    for panel, flight in zip(panels, flights.values(), strict=True):
        every, time = _thinned(flight)
        for axis, color in zip(range(3), COLORS, strict=False):
            panel.plot(time, flight.attitude[every, 0, axis], color=color, label=rf"$\sigma_{axis + 1}$")
            panel.plot(time, flight.reference[every, 0, axis], color=color, linestyle=":", linewidth=1.0)
        panel.set_ylim(-1.0, 1.0)
    panels[0].set_ylabel("attitude, MRP [-]")
    panels[0].legend(loc="upper right", fontsize=8)
    return figure


def bounded(flights: Mapping[str, Flight], bound: PrescribedBound) -> Figure:
    """Draw each MRP in units of rho(t) with its bounds, dotted: one row per axis, one column per flight."""
    figure = Figure(figsize=(3.4 * len(flights), 6.4), layout="constrained")
    rows = figure.subplots(3, len(flights), squeeze=False, sharex="col")
    for panels, (name, flight) in zip(rows.T, flights.items(), strict=True):
        every, time = _thinned(flight)
        rho = bound.rho(time)
        low, high = bound.bound(time)
        for axis, (panel, color) in enumerate(zip(panels, COLORS, strict=False)):
            panel.plot(time, flight.attitude[every, 0, axis] / rho, color=color)
            for limit in (low, high):
                panel.plot(time, limit[:, axis] / rho, color=INK, linestyle=":", linewidth=1.2)
            panel.set(xlim=(0.0, flight.time[-1]), ylim=(-1.6, 1.6))
            dress(panel)
            rows[axis, 0].set_ylabel(rf"$\sigma_{axis + 1} / \rho$ [-]")
        panels[0].set_title(name)
        panels[-1].set_xlabel("time [s]")
    return figure


def rates(flights: Mapping[str, Flight]) -> Figure:
    """Draw the body rates, one panel per flight."""
    figure, panels = _panels(flights, 3.4)
    for panel, flight in zip(panels, flights.values(), strict=True):
        every, time = _thinned(flight)
        for axis, color in zip(range(3), COLORS, strict=False):
            panel.plot(time, np.degrees(flight.rate[every, 0, axis]), color=color, label="xyz"[axis])
    panels[0].set_ylabel("body rate [deg/s]")
    panels[0].legend(loc="upper right", fontsize=8)
    return figure


def torque(flights: Mapping[str, Flight]) -> Figure:
    """Draw the commanded wheel torques, one panel per flight."""
    figure, panels = _panels(flights, 3.4)
    for panel, flight in zip(panels, flights.values(), strict=True):
        every, time = _thinned(flight)
        command = flight.command[every, 0]
        for wheel in range(command.shape[1]):
            look = stroke(wheel).of_line
            panel.plot(time[: len(command)], command[:, wheel], linewidth=0.7, label=f"wheel {wheel}", **look)
    panels[0].set_ylabel("commanded torque [N m]")
    panels[0].legend(loc="upper right", fontsize=8)
    return figure


def torque_bands(flights: Mapping[str, Flight]) -> Figure:
    """Draw the range of the commanded wheel torques in short intervals, pale, with its mean: chatter is a band.

    Thinned, a torque that changes its sign every period would be drawn as a constant one.
    """
    figure, panels = _panels(flights, 3.4)
    for panel, flight in zip(panels, flights.values(), strict=True):
        command = flight.command[:, 0]
        starts = np.arange(0, len(command), max(1, len(command) // POINTS))
        counts = np.diff(np.append(starts, len(command)))
        least, most, total = (ufunc.reduceat(command, starts) for ufunc in (np.minimum, np.maximum, np.add))
        for wheel in range(command.shape[1]):
            color = stroke(wheel).color
            panel.fill_between(
                flight.time[starts], least[:, wheel], most[:, wheel], color=color, alpha=0.25, linewidth=0.0
            )
            panel.plot(
                flight.time[starts], total[:, wheel] / counts, color=color, linewidth=0.9, label=f"wheel {wheel}"
            )
    panels[0].set_ylabel("commanded torque [N m]")
    panels[0].legend(loc="upper right", fontsize=8)
    return figure


def errors(flights: Mapping[str, Flight]) -> Figure:
    """Draw the pointing errors of all flights in one panel, on a logarithmic scale."""
    figure = Figure(figsize=(8.0, 3.6), layout="constrained")
    panel = figure.subplots()
    for number, (name, flight) in enumerate(flights.items()):
        every, time = _thinned(flight)
        panel.plot(time, np.maximum(flight.error[every, 0], 1e-7), label=name, **stroke(number).of_line)
    panel.set(yscale="log", xlabel="time [s]", ylabel="pointing error [deg]")
    dress(panel)
    panel.legend(loc="upper right", fontsize=8)
    return figure


def histories(lines: Mapping[str, tuple[FloatArray, FloatArray]], label: str, logarithmic: bool = False) -> Figure:
    """Draw one number of all flights in one panel.

    Parameters
    ----------
    lines
        Times [s] and values, by name.
    label
        What the values are.
    logarithmic
        Whether their scale is.
    """
    figure = Figure(figsize=(8.0, 3.6), layout="constrained")
    panel = figure.subplots()
    for number, (name, (time, values)) in enumerate(lines.items()):
        every = slice(None, None, max(1, len(time) // POINTS) | 1)
        panel.plot(time[every], values[every], label=name, **stroke(number).of_line)
    panel.set(yscale="log" if logarithmic else "linear", xlabel="time [s]", ylabel=label)
    dress(panel)
    if len(lines) > 5:
        figure.legend(loc="outside right upper", fontsize=8)
    else:
        panel.legend(fontsize=8)
    return figure


def estimates(flights: Mapping[str, Flight]) -> Figure:
    """Draw estimated effectiveness and bias against the truth, dotted, one column per flight.

    Where a wheel has not had enough torque to be told, its line is pale.
    """
    rows = [("effectiveness", "effectiveness [-]")]
    if any(flight.bias is not None for flight in flights.values()):
        rows.append(("bias", "bias [N m]"))
    figure = Figure(figsize=(3.6 * len(flights), 0.4 + 2.7 * len(rows)), layout="constrained")
    panels = figure.subplots(len(rows), len(flights), squeeze=False, sharex="col")
    for column, (name, flight) in enumerate(flights.items()):
        every, time = _thinned(flight)
        time = time[: len(flight.command[every])]
        for panel, (quantity, label) in zip(panels[:, column], rows, strict=True):
            estimate, truth = getattr(flight, quantity), getattr(flight, f"true_{quantity}")
            dress(panel)
            if column == 0:
                panel.set_ylabel(label)
            for wheel in range(truth.shape[2]):
                color = stroke(wheel).color
                panel.plot(time, truth[every, 0, wheel], color=color, linestyle=":", linewidth=1.2)
                if estimate is None:
                    continue
                line = estimate[every, 0, wheel]
                panel.plot(time, line, color=color, alpha=0.3, linewidth=1.0)
                if flight.identifiable is not None:
                    line = np.where(flight.identifiable[every, 0, wheel], line, np.nan)
                panel.plot(time, line, color=color, linewidth=1.2, label=f"wheel {wheel}")
            if estimate is None:
                panel.text(0.5, 0.6, "not estimated", transform=panel.transAxes, ha="center")
        panels[0, column].set(title=name, ylim=(-0.05, 1.1))
        panels[-1, column].set(xlabel="time [s]")
    figure.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=4, fontsize=8)
    return figure


def torques_estimated(flights: Mapping[str, tuple[Flight, FloatArray]]) -> Figure:
    """Draw the estimated torque of the faults against the truth (T, 3), dotted, one panel per flight."""
    figure, panels = _panels({name: flight for name, (flight, _) in flights.items()}, 3.4)
    for panel, (flight, truth) in zip(panels, flights.values(), strict=True):
        every, time = _thinned(flight)
        time = time[: len(truth[every])]
        assert flight.disturbance is not None
        for axis, color in zip(range(3), COLORS, strict=False):
            panel.plot(time, flight.disturbance[every, 0, axis], color=color, linewidth=1.0, label="xyz"[axis])
            panel.plot(time, truth[every, axis], color=INK, linestyle=":", linewidth=1.2)
    panels[0].set_ylabel("torque of the faults [N m]")
    panels[0].legend(loc="upper left", fontsize=8)
    return figure


def vibration_estimated(flight: Flight) -> Figure:
    """Draw the estimated torque of the modes against the truth, dotted, one panel per axis."""
    figure, panels = _panels(dict.fromkeys("xyz", flight), 3.0)
    every, time = _thinned(flight)
    assert flight.vibration is not None
    estimate = flight.vibration[every, 0]
    for axis, (panel, color) in enumerate(zip(panels, COLORS, strict=False)):
        panel.plot(time[: len(estimate)], estimate[:, axis], color=color, linewidth=0.9)
        panel.plot(time, flight.true_vibration[every, 0, axis], color=INK, linestyle=":", linewidth=1.0)
    panels[0].set_ylabel("torque of the modes [N m]")
    return figure
