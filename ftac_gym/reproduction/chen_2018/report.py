"""Studies and figures for Chen, Chen, He and Sun 2018."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from ftac_gym.evaluation.tables import Cells
from ftac_gym.reproduction import paper_figures as figures
from ftac_gym.reproduction.chen_2018 import plans
from ftac_gym.reproduction.chen_2018.measures import accurate, least, margin, outside, transformed, weight_bound
from ftac_gym.reproduction.chen_2018.plans import SCHEMES, bound
from ftac_gym.reproduction.recordings import Recordings
from ftac_gym.reproduction.wording import each, grid, milliseconds, named, percent, seconds, settled, table


def studies(flights: Recordings) -> dict[str, Cells]:
    """Return the tables that settle the claims."""
    return {
        "All schemes": _schemes(flights),
        "M1 with less torque, and with bounds that require more": _breaches(flights),
        "Factors at the start: least margin in 5 s": grid(
            "delta(0)", named(plans.FACTORS, "{:g}"), plans.FILTER_STARTS,
            lambda factor, where: margin(flights[f"delta(0) = {factor:g}, {where}"])),
        "Signs of the start, in units of the example's: least margin in 6 s": grid(
            "signs", named(plans.SIGNS), {"bounds as printed": "", "bounds mirrored to the start": ", mirrored"},
            lambda signs, kind: margin(flights[f"start {signs}{kind}"])),
        "Step of M1: integral of the squared torques until a time [N^2 m^2 s]": _steps(flights),
        "Sampling: least margin, 1 deg after (60 s flown; 6 s at 1 and 2 ms, -), share of time at the limit": grid(
            "period [ms]", milliseconds(plans.PERIODS), named(plans.HELD),
            lambda period, name: _held(flights, period, name)),
        "Unwinding (8 axes, healthy; short from q, long from -q): median angle turned over the shortest": grid(
            "law and start", named(f"{name}, {way}" for name in plans.COMPARATORS for way in plans.WAYS),
            named(plans.ANGLES, "{:g} deg"),
            lambda kind, angle: f"{np.median(flights[f'turn {angle:g} deg, {kind}'].path_ratio()):.2f}"),
    }  # fmt: skip


def _schemes(flights: Recordings) -> Cells:
    pairs = [name for scheme in SCHEMES for name in (scheme, f"{scheme}, healthy")]
    rows = flights.chosen((*pairs, "M1, -J' w", "M1, lower = upper = 1"))
    rows.update(flights.chosen(("M1, no filter", "M1 sampled", "prescribed performance"), "hold 0.005 s, {}"))
    return table("flight", rows, {
        "least margin": margin,
        "1 deg after": lambda flight: settled(flight, 1.0),
        "0.001 after": lambda flight: seconds(accurate(flight)),
        "last 10 s [deg]": lambda flight: f"{flight.steady():.3f}",
        "energy [N^2 m^2 s]": lambda flight: f"{flight.energy():.0f}",
        "at the limit [%]": lambda flight: f"{100.0 * flight.saturated():.0f}",
        "chatter [N m/s]": lambda flight: f"{flight.chatter():.1f}",
    })  # fmt: skip


def _breaches(flights: Recordings) -> Cells:
    limits = [f"M1, {limit:g} N m" for limit in plans.LIMITS]
    decays = [f"M1, kappa = {decay:g}" for decay in plans.DECAYS]
    return table("flight", flights.chosen(("M1", *limits, *decays, "M1, wide bounds", "M1, wide bounds, 4 N m")), {
        "least margin": margin,
        "outside": outside,
        "1 deg after": lambda flight: settled(flight, 1.0),
        "last 10 s [deg]": lambda flight: f"{flight.steady():.2f}",
    })  # fmt: skip


def _steps(flights: Recordings) -> Cells:
    steps = {name: flights[f"step {step:g} s"] for name, step in milliseconds(plans.STEPS).items()}
    return table("step [ms]", steps, {
        **each((2.0, 4.0, 6.0, 8.0, 10.0), "{:g} s", lambda flight, end: f"{flight.energy(end):.0f}"),
        "least margin": margin,
    })  # fmt: skip


def _held(flights: Recordings, period: float, name: str) -> str:
    """Return the cell of a period [s] and a baseline in the study of sampling."""
    # The example's own period is not flown twice.
    flight = flights.get(f"hold {period:g} s, {name}", flights.get(name) if period == 0.005 else None)
    if flight is None:
        return "-"
    arrival = settled(flight, 1.0) if period >= 0.005 else "-"
    return f"{least(flight):+.2g}, {arrival}, {percent(flight.saturated())}"


def draw(flights: Recordings) -> dict[str, Figure]:
    """Draw the figures, by file name without ending."""
    compared = flights.chosen(SCHEMES)
    sampled = flights.chosen(("M1 sampled", "prescribed performance"), "hold 0.005 s, {}")
    bands = {**compared, "M1 sampled": sampled["M1 sampled"]}
    sizes = {**flights.chosen(("M1", "M1, lower = upper = 1", "M1, 7 N m")), "M1 sampled": sampled["M1 sampled"]}
    return {
        "attitude": figures.attitude(compared),
        "bounds": figures.bounded(compared, bound()),
        "rates": figures.rates(compared),
        "torque": figures.torque_bands(bands),
        "transformed": figures.histories(sizes, transformed, "size of the transformed error [-]", logarithmic=True),
        "theta": figures.histories(flights.chosen(["M1"]), weight_bound, "theta [-]"),
        "schemes": figures.errors({**compared, **sampled}),
    }
