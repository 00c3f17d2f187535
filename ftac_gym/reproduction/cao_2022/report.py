"""Studies and figures for Cao, Gong and Han 2022."""

from __future__ import annotations

from itertools import product

import numpy as np
from matplotlib.figure import Figure

from ftac_gym.evaluation.tables import Cells
from ftac_gym.reproduction import paper_figures as figures
from ftac_gym.reproduction.cao_2022.measures import FINE, closed_forms, sliding_variable
from ftac_gym.reproduction.cao_2022.plans import EXPONENTS, LAYERS, LIMITS, OBSERVERS, PERIODS, TIMES
from ftac_gym.reproduction.recordings import Recording, Recordings
from ftac_gym.reproduction.wording import grid, milliseconds, named, pairs, seconds, settled, table


def studies(flights: Recordings) -> dict[str, Cells]:
    """Return the tables that settle the claims."""
    return {
        "All schemes and comparators": _schemes(flights),
        "Closed forms of the predefined times (h1 = 0.25, no switching term, unlimited, 1 ms)": _forms(flights),
        "Random starts, 0.1 deg after (h1 = 0.25, T1 + T2 = 20 s)": _starts(flights),
        "Step size (no fault, no disturbance): 1 deg after, steady error, largest torque": grid(
            ("h1", "torque limit"), pairs(map(str, EXPONENTS), LIMITS), {"10 ms": 0.01, "1 ms": 0.001},
            lambda kind, step: _step(flights[f"step: h1 = {kind[0]}, {kind[1]}, {step} s"])),
        "Sampling (faults and disturbance as printed, E^ = I, h1 = 0.25): 1 deg after, steady error": grid(
            "period [ms]", milliseconds(PERIODS), named(map(", ".join, product(LIMITS, LAYERS))),
            lambda period, kind: _hold(flights[f"hold: {period} s, {kind}"])),
    }  # fmt: skip


def _schemes(flights: Recordings) -> Cells:
    schemes = {name: flight for name, flight in flights.items() if name.startswith(("PTC", "TSMC", "turning"))}
    return table("flight", schemes, {
        "0.1 deg after": settled,
        "steady [deg]": lambda flight: f"{flight.steady():.5f}",
        "largest torque [N m]": lambda flight: f"{flight.peak():.1f}",
        "chatter [N m/s]": lambda flight: f"{flight.chatter():.1f}",
    })  # fmt: skip


def _forms(flights: Recordings) -> Cells:
    cells: Cells = [["T1 = T2", "s = 0 by closed form", "measured", f"{FINE} deg by closed form", "measured"]]
    for time in TIMES:
        flight = flights[f"T1 = T2 = {time:g} s"]
        reached, arrived = closed_forms(flight, time)
        small = np.linalg.norm(sliding_variable(flight, time), axis=1) < 1e-6
        first = f"{flight.time[np.argmax(small)]:.3f} s" if small.any() else "never"
        cells.append([f"{time:g} s", f"{reached:.3f} s", first, f"{arrived:.3f} s", f"{flight.settling(FINE):.3f} s"])
    return cells


def _starts(flights: Recordings) -> Cells:
    starts = flights.chosen(("unlimited", "5 N m", "1 N m"), "starts, {}")
    times = starts.measured(lambda flight: np.sort(flight.arrivals()))
    return table("torque limit", times, {
        "starts": lambda sorted_times: f"{len(sorted_times)}",
        "first": lambda sorted_times: seconds(sorted_times[0]),
        "median": lambda sorted_times: seconds(sorted_times[len(sorted_times) // 2]),
        "last": lambda sorted_times: seconds(sorted_times[-1]),
    })  # fmt: skip


def _step(flight: Recording) -> str:
    """Return the cell of a flight in the study of the step size."""
    return f"{settled(flight, 1.0)}, {flight.steady(5.0):.1e} deg, {flight.peak():.3g} N m"


def _hold(flight: Recording) -> str:
    """Return the cell of a flight in the study of sampling."""
    return f"{settled(flight, 1.0)}, {flight.steady():.1e} deg"


def draw(flights: Recordings) -> dict[str, Figure]:
    """Draw the figures, by file name without ending."""
    compared = flights.chosen(("PTC as printed", "PTC", "TSMC-class"))
    observed = flights.chosen(OBSERVERS, "turning, {}")
    return {
        "attitude": figures.attitude(compared),
        "rates": figures.rates(compared),
        "torque": figures.torque(compared),
        "estimates": figures.estimates(Recordings({**observed, "PTC, at rest": flights["PTC"]})),
        "schemes": figures.errors(flights.chosen(("PTC as printed", "PTC", "PTC h1 = 0.5, regularised", "TSMC-class"))),
    }
