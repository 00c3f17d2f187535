"""Cao, Gong and Han 2022 reproduced: verdicts, studies, figures."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ftac_gym.attitude import mrp_derivative
from ftac_gym.baselines.components.predefined_time_gain import PredefinedTime
from ftac_gym.evaluation.tables import Cells
from ftac_gym.reproduction import figures
from ftac_gym.reproduction.cao_2022.claims import arrivals, claims
from ftac_gym.reproduction.cao_2022.plans import EXPONENTS, OBSERVERS, PERIODS, TIMES, limit_name
from ftac_gym.reproduction.claims import Reproduction
from ftac_gym.reproduction.flight import Flight
from ftac_gym.reproduction.variations import UNLIMITED, seconds, settled
from ftac_gym.utils.parameters import FloatArray

FINE = 0.01
"""Error at which arrival is timed [deg]: the closed forms say when it is reached, as they do for zero."""


def closed_forms(flight: Flight, time: float) -> tuple[float, float]:
    """Return when s is zero and when the error is 0.01 deg, by the closed forms [s].

    The first from the flight's start, the second from the error where s is zero: T (exp(-V1^h) - exp(-V0^h)) leads from
    V0 to V1.
    """
    position, rate = PredefinedTime(0.25, time), PredefinedTime(0.3, time)
    reached = float(rate.reaching_time(0.5 * _square(_variable(flight, position)[0])))
    start = min(len(flight.time) - 1, round(reached / flight.scenario.control_period))
    there = float(position.reaching_time(0.5 * _square(flight.attitude[start, 0])))
    left = float(position.reaching_time(np.array(0.5 * np.tan(np.radians(FINE) / 4.0) ** 2)))
    return reached, reached + there - left


def _variable(flight: Flight, position: PredefinedTime) -> FloatArray:
    """Return s (T + 1, 3) [1/s] of the first craft."""
    sigma = flight.attitude[:, 0]
    gain = position.gain(0.5 * np.einsum("ti,ti->t", sigma, sigma)[:, None])
    variable: FloatArray = mrp_derivative(sigma, flight.rate[:, 0]) + gain * sigma
    return variable


def _square(vector: FloatArray) -> FloatArray:
    square: FloatArray = np.asarray(vector @ vector)
    return square


def studies(flights: Mapping[str, Flight]) -> dict[str, Cells]:
    """Return the tables that settle the claims."""
    return {
        "All schemes and comparators": _schemes(flights),
        "Closed forms of the predefined times (h1 = 0.25, no switching term, unlimited, 1 ms)": _forms(flights),
        "Random starts, 0.1 deg after (h1 = 0.25, T1 + T2 = 20 s)": _starts(flights),
        "Step size (no fault, no disturbance): 1 deg after, steady error, largest torque": _steps(flights),
        "Sampling (faults and disturbance as printed, E^ = I, h1 = 0.25): 1 deg after, steady error": _holds(flights),
    }


def _schemes(flights: Mapping[str, Flight]) -> Cells:
    table: Cells = [["flight", "0.1 deg after", "steady [deg]", "largest torque [N m]", "chatter [N m/s]"]]
    for name, flight in flights.items():
        if name.startswith(("PTC", "TSMC", "turning")):
            row = [settled(flight), f"{flight.steady():.5f}", f"{np.abs(flight.command).max():.1f}"]
            table.append([name, *row, f"{flight.chatter():.1f}"])
    return table


def _forms(flights: Mapping[str, Flight]) -> Cells:
    table: Cells = [["T1 = T2", "s = 0 by closed form", "measured", f"{FINE} deg by closed form", "measured"]]
    for time in TIMES:
        flight = flights[f"T1 = T2 = {time:g} s"]
        reached, arrived = closed_forms(flight, time)
        small = np.linalg.norm(_variable(flight, PredefinedTime(0.25, time)), axis=1) < 1e-6
        first = f"{flight.time[np.argmax(small)]:.3f} s" if small.any() else "never"
        table.append([f"{time:g} s", f"{reached:.3f} s", first, f"{arrived:.3f} s", f"{flight.settling(FINE):.3f} s"])
    return table


def _starts(flights: Mapping[str, Flight]) -> Cells:
    table: Cells = [["torque limit", "starts", "first", "median", "last"]]
    for name in ("unlimited", "5 N m", "1 N m"):
        times = np.sort(arrivals(flights[f"starts, {name}"]))
        table.append([name, f"{len(times)}", *(seconds(float(times[at])) for at in (0, len(times) // 2, -1))])
    return table


def _steps(flights: Mapping[str, Flight]) -> Cells:
    table: Cells = [["h1", "torque limit", "10 ms", "1 ms"]]
    for exponent in EXPONENTS:
        for limit in (UNLIMITED, 5.0):
            pair = [flights[f"step: h1 = {exponent}, {limit_name(limit)}, {period} s"] for period in (0.01, 0.001)]
            cells = [f"{settled(c, 1.0)}, {c.steady(5.0):.1e} deg, {np.abs(c.command).max():.3g} N m" for c in pair]
            table.append([f"{exponent}", limit_name(limit), *cells])
    return table


def _holds(flights: Mapping[str, Flight]) -> Cells:
    table: Cells = [["period [ms]", "unlimited, sign", "unlimited, layer 0.1", "5 N m, sign", "5 N m, layer 0.1"]]
    for period in PERIODS:
        cells = []
        for limit in (UNLIMITED, 5.0):
            for layer in (0.0, 0.1):
                flight = flights[f"hold: {period} s, {limit_name(limit)}, {layer}"]
                cells.append(f"{settled(flight, 1.0)}, {flight.steady():.1e} deg")
        table.append([f"{1000 * period:g}", *cells])
    return table


def evaluate(flights: Mapping[str, Flight]) -> Reproduction:
    """Judge the claims and draw the figures."""
    compared = {name: flights[name] for name in ("PTC as printed", "PTC", "TSMC-class")}
    observed = {label: flights[f"turning, {label}"] for label in OBSERVERS}
    drawn = {
        "attitude": figures.attitude(compared),
        "rates": figures.rates(compared),
        "torque": figures.torque(compared),
        "estimates": figures.estimates({**observed, "PTC, at rest": flights["PTC"]}),
        "schemes": figures.errors(
            {name: flights[name] for name in ("PTC as printed", "PTC", "PTC h1 = 0.5, regularised", "TSMC-class")}
        ),
    }
    return Reproduction(claims(flights), studies(flights), drawn)
