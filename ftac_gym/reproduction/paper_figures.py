"""Figures that correspond to the papers': attitude, rates, torque, estimates, and schemes side by side."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ftac_gym.plots import style
from ftac_gym.plots.style import COLORS, INK, stroke
from ftac_gym.reproduction.recordings import Recording
from ftac_gym.task.prescribed_bound import PrescribedBound
from ftac_gym.utils.parameters import FloatArray

POINTS = 1500
"""Most points of a line; more are not visible."""

Recordings = Mapping[str, Recording]
Draw = Callable[[Axes, Recording], None]
Measure = Callable[[Recording], FloatArray]


def _line(panel: Axes, time: FloatArray, values: FloatArray, **look: Any) -> None:
    """Draw values (T,) or (T + 1,) at the first of the times (T + 1,)."""
    # The times determine the stride, so that lines with and without the last sample share their points.
    every = slice(None, None, max(1, len(time) // POINTS) | 1)
    thinned = values[every]
    panel.plot(time[every][: len(thinned)], thinned, **look)


def _lines(panel: Axes, time: FloatArray, values: FloatArray, labels: Sequence[str] = (), **look: Any) -> None:
    """Draw values (T, 3) or (T + 1, 3), one axis a colour."""
    for axis in range(values.shape[1]):
        label = labels[axis] if labels else None
        _line(panel, time, values[:, axis], **{"color": COLORS[axis], "label": label, **look})


def _sheet(flights: Recordings, label: str, height: float = 3.6) -> tuple[Figure, list[Axes]]:
    """Return a figure with one empty panel per flight."""
    figure = Figure(figsize=(3.4 * len(flights), height), layout="constrained")
    panels = figure.subplots(1, len(flights), squeeze=False)[0]
    for panel, (name, flight) in zip(panels, flights.items(), strict=True):
        panel.set(title=name, xlabel="time [s]", xlim=(0.0, flight.time[-1]))
        style.apply(panel)
    panels[0].set_ylabel(label)
    return figure, list(panels)


def _per_flight(flights: Recordings, label: str, draw: Draw) -> Figure:
    """Return one panel per flight, filled by a function, and a legend of the first below them."""
    figure, panels = _sheet(flights, label)
    for panel, flight in zip(panels, flights.values(), strict=True):
        draw(panel, flight)
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=4, fontsize=8)
    return figure


def attitude(flights: Recordings) -> Figure:
    """Draw the attitude in MRPs against the reference, dotted, one panel per flight."""

    def draw(panel: Axes, flight: Recording) -> None:
        _lines(panel, flight.time, flight.attitude[:, 0], [rf"$\sigma_{axis}$" for axis in (1, 2, 3)])
        _lines(panel, flight.time, flight.reference[:, 0], linestyle=":", linewidth=1.0)
        panel.set_ylim(-1.0, 1.0)

    return _per_flight(flights, "attitude, MRP [-]", draw)


def rates(flights: Recordings) -> Figure:
    """Draw the body rates, one panel per flight."""

    def draw(panel: Axes, flight: Recording) -> None:
        _lines(panel, flight.time, np.degrees(flight.rate[:, 0]), "xyz")

    return _per_flight(flights, "body rate [deg/s]", draw)


def torque(flights: Recordings) -> Figure:
    """Draw the commanded wheel torques, one panel per flight."""

    def draw(panel: Axes, flight: Recording) -> None:
        for wheel, command in enumerate(flight.command[:, 0].T):
            _line(panel, flight.time, command, linewidth=0.7, label=f"wheel {wheel}", **stroke(wheel).of_line)

    return _per_flight(flights, "commanded torque [N m]", draw)


def torque_bands(flights: Recordings) -> Figure:
    """Draw the range of the commanded wheel torques in short intervals, pale, with its mean.

    A torque that alternates every period shows as a band; thinned, it shows as a constant line.
    """

    def draw(panel: Axes, flight: Recording) -> None:
        command = flight.command[:, 0]
        starts = np.arange(0, len(command), max(1, len(command) // POINTS))
        counts = np.diff(np.append(starts, len(command)))
        least, most, total = (ufunc.reduceat(command, starts) for ufunc in (np.minimum, np.maximum, np.add))
        time = flight.time[starts]
        for wheel in range(command.shape[1]):
            color = stroke(wheel).color
            panel.fill_between(time, least[:, wheel], most[:, wheel], color=color, alpha=0.25, linewidth=0.0)
            panel.plot(time, total[:, wheel] / counts, color=color, linewidth=0.9, label=f"wheel {wheel}")

    return _per_flight(flights, "commanded torque [N m]", draw)


def torques_estimated(flights: Recordings, truth: Callable[[Recording], FloatArray]) -> Figure:
    """Draw the estimated torque of the faults against the truth (T, 3), dotted, one panel per flight."""

    def draw(panel: Axes, flight: Recording) -> None:
        assert flight.disturbance is not None
        _lines(panel, flight.time, flight.disturbance[:, 0], "xyz", linewidth=1.0)
        _lines(panel, flight.time, truth(flight), color=INK, linestyle=":", linewidth=1.2)

    return _per_flight(flights, "torque of the faults [N m]", draw)


def vibration_estimated(flight: Recording) -> Figure:
    """Draw the estimated torque of the modes against the truth, dotted, one panel per axis."""
    assert flight.vibration is not None
    figure, panels = _sheet(dict.fromkeys("xyz", flight), "torque of the modes [N m]", height=3.0)
    for axis, panel in enumerate(panels):
        _line(panel, flight.time, flight.vibration[:, 0, axis], color=COLORS[axis], linewidth=0.9)
        _line(panel, flight.time, flight.true_vibration[:-1, 0, axis], color=INK, linestyle=":", linewidth=1.0)
    return figure


def estimates(flights: Recordings) -> Figure:
    """Draw estimated effectiveness and bias against the truth, dotted, one column per flight.

    The line of a wheel is pale as long as its torque is too small for an estimate.
    """
    quantities = {"effectiveness": "effectiveness [-]"}
    if any(flight.bias is not None for flight in flights.values()):
        quantities["bias"] = "bias [N m]"
    figure = Figure(figsize=(3.6 * len(flights), 0.4 + 2.7 * len(quantities)), layout="constrained")
    panels = figure.subplots(len(quantities), len(flights), squeeze=False, sharex="col")
    for column, (name, flight) in zip(panels.T, flights.items(), strict=True):
        for panel, quantity in zip(column, quantities, strict=True):
            style.apply(panel)
            _estimate(panel, flight, getattr(flight, quantity), getattr(flight, f"true_{quantity}"))
        column[0].set(title=name, ylim=(-0.05, 1.1))
        column[-1].set(xlabel="time [s]")
    for panel, label in zip(panels[:, 0], quantities.values(), strict=True):
        panel.set_ylabel(label)
    figure.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=4, fontsize=8)
    return figure


def _estimate(panel: Axes, flight: Recording, estimate: FloatArray | None, truth: FloatArray) -> None:
    for wheel in range(truth.shape[2]):
        color = stroke(wheel).color
        _line(panel, flight.time, truth[:, 0, wheel], color=color, linestyle=":", linewidth=1.2)
        if estimate is not None:
            line = estimate[:, 0, wheel]
            _line(panel, flight.time, line, color=color, alpha=0.3, linewidth=1.0)
            if flight.identifiable is not None:
                line = np.where(flight.identifiable[:, 0, wheel], line, np.nan)
            _line(panel, flight.time, line, color=color, linewidth=1.2, label=f"wheel {wheel}")
    if estimate is None:
        panel.text(0.5, 0.6, "not estimated", transform=panel.transAxes, ha="center")


def bounded(flights: Recordings, bound: PrescribedBound) -> Figure:
    """Draw each MRP in units of rho(t) with its bounds, dotted: one row per axis, one column per flight."""
    figure = Figure(figsize=(3.4 * len(flights), 6.4), layout="constrained")
    rows = figure.subplots(3, len(flights), squeeze=False, sharex="col")
    for panels, (name, flight) in zip(rows.T, flights.items(), strict=True):
        time = flight.time
        rho = bound.rho(time)
        limits = bound.bound(time)
        for axis, panel in enumerate(panels):
            _line(panel, time, flight.attitude[:, 0, axis] / rho, color=COLORS[axis])
            for limit in limits:
                _line(panel, time, limit[:, axis] / rho, color=INK, linestyle=":", linewidth=1.2)
            panel.set(xlim=(0.0, time[-1]), ylim=(-1.6, 1.6))
            style.apply(panel)
            rows[axis, 0].set_ylabel(rf"$\sigma_{axis + 1} / \rho$ [-]")
        panels[0].set_title(name)
        panels[-1].set_xlabel("time [s]")
    return figure


def curves(lines: Mapping[str, tuple[FloatArray, FloatArray]], label: str, logarithmic: bool = False) -> Figure:
    """Draw curves over time in one panel.

    Parameters
    ----------
    lines
        Times [s] and values, by name.
    label
        Name of the quantity with its unit.
    logarithmic
        Whether the scale of the values is logarithmic.
    """
    figure = Figure(figsize=(8.0, 3.6), layout="constrained")
    panel = figure.subplots()
    for number, (name, (time, values)) in enumerate(lines.items()):
        _line(panel, time, values, label=name, **stroke(number).of_line)
    panel.set(yscale="log" if logarithmic else "linear", xlabel="time [s]", ylabel=label)
    style.apply(panel)
    if len(lines) > 5:
        figure.legend(loc="outside right upper", fontsize=8)
    else:
        panel.legend(fontsize=8)
    return figure


def histories(flights: Recordings, measure: Measure, label: str, logarithmic: bool = False) -> Figure:
    """Draw a measure of all flights in one panel, from its values at the first of their times; see :func:`curves`."""
    return curves({name: (flight.time, measure(flight)) for name, flight in flights.items()}, label, logarithmic)


def errors(flights: Recordings) -> Figure:
    """Draw the pointing errors of all flights in one panel, on a logarithmic scale."""
    return histories(flights, lambda flight: np.maximum(flight.error[:, 0], 1e-7), "pointing error [deg]", True)
