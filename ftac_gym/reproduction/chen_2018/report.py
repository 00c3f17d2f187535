"""Chen, Chen, He and Sun 2018 reproduced: verdicts, studies, figures."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ftac_gym.evaluation.tables import Cells
from ftac_gym.reproduction import figures
from ftac_gym.reproduction.chen_2018.claims import claims
from ftac_gym.reproduction.chen_2018.measures import (
    accurate,
    changed,
    least,
    margin,
    outside,
    transformed,
    weight_bound,
)
from ftac_gym.reproduction.chen_2018.plans import (
    ANGLES,
    DECAYS,
    FACTORS,
    HELD,
    LIMITS,
    PERIODS,
    SCHEMES,
    SIGNS,
    STEPS,
    SYMMETRIC,
    WIDE,
    bound,
    mirrored,
    start_name,
)
from ftac_gym.reproduction.claims import Reproduction
from ftac_gym.reproduction.flight import Flight
from ftac_gym.reproduction.variations import seconds, settled
from ftac_gym.task.prescribed_bound import PrescribedBound

Flights = Mapping[str, Flight]


def studies(flights: Flights) -> dict[str, Cells]:
    """Return the tables that settle the claims."""
    return {
        "All schemes": _schemes(flights),
        "M1 with less torque and with bounds that ask for more": _breaches(flights),
        "Factors at the start: least margin in 5 s": _factors(flights),
        "Signs of the start, in units of the example's: least margin in 6 s": _starts(flights),
        "Step of M1: integral of the squared torques until a time [N^2 m^2 s]": _steps(flights),
        "Sampling: least margin, 1 deg after (60 s flown; 6 s at 1 and 2 ms, -), share of time at the limit": _holds(
            flights
        ),
        "Unwinding (8 axes, healthy; short from q, long from -q): median angle turned over the shortest": _turns(
            flights
        ),
    }


def _schemes(flights: Flights) -> Cells:
    table: Cells = [
        ["flight", "least margin", "1 deg after", "0.001 after", "last 10 s [deg]", "energy [N^2 m^2 s]",
         "at the limit [%]", "chatter [N m/s]"]
    ]  # fmt: skip
    rows: dict[str, tuple[Flight, PrescribedBound]] = {}
    for name in SCHEMES:
        rows[name], rows[f"{name}, healthy"] = (flights[name], bound()), (flights[f"{name}, healthy"], bound())
    rows["M1, -J' w"] = (flights["M1, -J' w"], bound())
    rows["M1, lower = upper = 1"] = (flights["M1, lower = upper = 1"], changed(**SYMMETRIC))
    for name in ("M1, no filter", "M1 sampled", "prescribed performance"):
        rows[name] = (flights[f"hold 0.005 s, {name}"], bound())
    for name, (flight, within) in rows.items():
        numbers = [f"{flight.steady():.3f}", f"{flight.energy():.0f}", f"{100.0 * flight.saturated():.0f}"]
        times = [settled(flight, 1.0), seconds(accurate(flight))]
        table.append([name, margin(flight, within), *times, *numbers, f"{flight.chatter():.1f}"])
    return table


def _breaches(flights: Flights) -> Cells:
    table: Cells = [["flight", "least margin", "outside", "1 deg after", "last 10 s [deg]"]]
    rows: dict[str, PrescribedBound] = {"M1": bound()}
    rows.update({f"M1, {limit:g} N m": bound() for limit in LIMITS})
    rows.update({f"M1, kappa = {decay:g}": changed(decay=decay) for decay in DECAYS})
    rows.update({name: changed(**WIDE) for name in ("M1, wide bounds", "M1, wide bounds, 4 N m")})
    for name, within in rows.items():
        flight = flights[name]
        cells = [margin(flight, within), outside(flight, within), settled(flight, 1.0), f"{flight.steady():.2f}"]
        table.append([name, *cells])
    return table


def _factors(flights: Flights) -> Cells:
    table: Cells = [["delta(0)", "filter starts at zero", "filter starts at the virtual control"]]
    for factor in FACTORS:
        within = changed(initial_factor=factor)
        pair = [flights[f"delta(0) = {factor:g}, {where}"] for where in ("zero", "virtual")]
        table.append([f"{factor:g}", *(margin(flight, within) for flight in pair)])
    return table


def _starts(flights: Flights) -> Cells:
    table: Cells = [["signs", "bounds as printed", "bounds mirrored to the start"]]
    for signs in SIGNS:
        name = start_name(signs)
        pair = [margin(flights[f"start {name}"]), margin(flights[f"start {name}, mirrored"], mirrored(signs))]
        table.append([name, *pair])
    return table


def _steps(flights: Flights) -> Cells:
    ends = (2.0, 4.0, 6.0, 8.0, 10.0)
    table: Cells = [["step [ms]", *(f"{end:g} s" for end in ends), "least margin"]]
    for step in STEPS:
        flight = flights[f"step {step:g} s"]
        table.append([f"{1000 * step:g}", *(f"{flight.energy(end):.0f}" for end in ends), margin(flight)])
    return table


def _holds(flights: Flights) -> Cells:
    table: Cells = [["period [ms]", *HELD]]
    for period in PERIODS:
        cells = []
        for name in HELD:
            # The example's own period is not flown twice.
            flight = flights.get(f"hold {period:g} s, {name}", flights.get(name) if period == 0.005 else None)
            if flight is None:
                cells.append("-")
                continue
            when = settled(flight, 1.0) if period >= 0.005 else "-"
            cells.append(f"{least(flight):+.2g}, {when}, {100.0 * flight.saturated():.0f} %")
        table.append([f"{1000 * period:g}", *cells])
    return table


def _turns(flights: Flights) -> Cells:
    ways = ("short", "long", "long, switched")
    table: Cells = [["law and start", *(f"{angle:g} deg" for angle in ANGLES)]]
    for name in SCHEMES[1:]:
        for way in ways:
            ratios = [np.median(flights[f"turn {angle:g} deg, {name}, {way}"].path_ratio()) for angle in ANGLES]
            table.append([f"{name}, {way}", *(f"{ratio:.2f}" for ratio in ratios)])
    return table


def evaluate(flights: Mapping[str, Flight]) -> Reproduction:
    """Judge the claims and draw the figures."""
    compared = {name: flights[name] for name in SCHEMES}
    sizes = {
        "M1": (flights["M1"], bound()),
        "M1, lower = upper = 1": (flights["M1, lower = upper = 1"], changed(**SYMMETRIC)),
        "M1 sampled": (flights["hold 0.005 s, M1 sampled"], bound()),
        "M1, 7 N m": (flights["M1, 7 N m"], bound()),
    }
    drawn = {
        "attitude": figures.attitude(compared),
        "bounds": figures.bounded(compared, bound()),
        "rates": figures.rates(compared),
        "torque": figures.torque_bands({**compared, "M1 sampled": flights["hold 0.005 s, M1 sampled"]}),
        "transformed": figures.histories(
            {name: (flight.time, transformed(flight, within)) for name, (flight, within) in sizes.items()},
            "size of the transformed error [-]",
            logarithmic=True,
        ),
        "theta": figures.histories({"M1": (flights["M1"].time, weight_bound(flights["M1"]))}, "theta [-]"),
        "schemes": figures.errors(
            {
                **compared,
                **{name: flights[f"hold 0.005 s, {name}"] for name in ("M1 sampled", "prescribed performance")},
            }
        ),
    }
    return Reproduction(claims(flights), studies(flights), drawn)
