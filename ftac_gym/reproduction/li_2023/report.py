"""Li, Xu and Chang 2023 reproduced: verdicts, studies, figures."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ftac_gym.evaluation.tables import Cells
from ftac_gym.reproduction import figures
from ftac_gym.reproduction.claims import Reproduction
from ftac_gym.reproduction.flight import Flight
from ftac_gym.reproduction.li_2023.claims import claims
from ftac_gym.reproduction.li_2023.measures import (
    CALM,
    FIRST,
    LATE,
    SECOND,
    at_limit,
    energy_at,
    fault_error,
    fault_torque,
    inequalities,
    largest,
    rate_error,
    settling,
    shaking,
    vibration_error,
)
from ftac_gym.reproduction.li_2023.model import closed_loops, loop_errors, term_errors
from ftac_gym.reproduction.li_2023.plans import BOUNDS, INTEGRATIONS, NOISES, OTHERS, PERIODS, SCHEMES
from ftac_gym.reproduction.variations import seconds

Flights = Mapping[str, Flight]


def studies(flights: Flights) -> dict[str, Cells]:
    """Return the tables that settle the claims."""
    return {
        "All schemes": _schemes(flights),
        "Observers: root mean squares of the errors": _observers(flights),
        "Matrix inequalities": _inequalities(),
        "Fuzzy model against the nonlinear one": _model(),
        "Sampling the observer: largest |q_ev| and RMS of f^ - f from 160 to 200 s, |u|^2": _sampling(flights),
        "Vibration: energy of the modes [mJ], and root mean square of their torque on the body": _vibration(flights),
    }


def _schemes(flights: Flights) -> Cells:
    table: Cells = [
        ["flight", "0.01 after, first", "0.01 after, second", "|q_ev| at 35-40 s", "|q_ev| at 160-200 s",
         "|u|^2 in 40 s", "|u|^2 in 200 s [N^2 m^2 s]", "any wheel at the limit [%]", "chatter [N m/s]"]
    ]  # fmt: skip
    variants = (
        *SCHEMES,
        *OTHERS,
        *(f"{name}, {what}" for what in ("healthy", "sum", "printed start", "fast start") for name in SCHEMES),
    )
    more = ("FASMC, weak", "FASMC, aligned", "FASMC, mean gains", "FASMC, from zero", "FASMC, bounded")
    halves = tuple(f"FASMC, half, {bound:g} N m" for bound in BOUNDS)
    noisy = tuple(f"FASMC, noise {noise:g}" for noise in NOISES)
    for name in (*variants, *more, *halves, *noisy):
        flight = flights[name]
        times = [seconds(settling(flight, window)) for window in (FIRST, SECOND)]
        ends = [f"{largest(flight, window):.1e}" for window in ((35.0, 40.0), LATE)]
        spent = [f"{flight.energy(until, commanded=True):.0f}" for until in (40.0, np.inf)]
        table.append([name, *times, *ends, *spent, f"{100.0 * at_limit(flight):.1f}", f"{flight.chatter():.2f}"])
    return table


def _observers(flights: Flights) -> Cells:
    table: Cells = [
        ["flight", "f^ - f at 15-40 s [N m]", "f^ - f at 160-200 s [N m], by channel", "d^ - d of d at 15-40 s [N m]",
         "d^ - d of d at 160-200 s [N m]", "largest |w - w^| at 15-40, 160-200 s [rad/s]"]
    ]  # fmt: skip
    names = (
        "FASMC", "FASMC, weak", "FASMC, healthy", "FASMC, undisturbed", "FASMC, from zero", "FASMC, from zero, bounded",
        "FASMC solved", *(f"FASMC, noise {noise:g}" for noise in NOISES), "FASMC with ILO-class",
        "FASMC with ILO-class, weak",
    )  # fmt: skip
    for name in names:
        flight = flights[name]
        calm, late = fault_error(flight, CALM), fault_error(flight, LATE)
        pulls = ["-", "-"]
        if flight.vibration is not None:
            pairs = [vibration_error(flight, window) for window in (CALM, LATE)]
            pulls = [f"{error:.4f} of {size:.3f}" for error, size in pairs]
        rates = ", ".join(f"{rate_error(flight, window):.1e}" for window in (CALM, LATE))
        channels = ", ".join(f"{value:.4f}" for value in late)
        table.append([name, f"{np.linalg.norm(calm):.4f}", channels, *pulls, rates])
    return table


def _inequalities() -> Cells:
    table: Cells = [
        ["problem", "gamma", "proved", "rules outside the disc", "farthest pole", "largest F or K", "time [s]"]
    ]
    for name, item in inequalities().items():
        gamma = f"{item.gamma:.4f}" if np.isfinite(item.gamma) else "none"
        outside = ", ".join(str(rule) for rule in item.outside) or "-"
        cells = [gamma, "yes" if item.holds else "no", outside, f"{item.reach:.3f}", f"{item.gain:.4g}"]
        table.append([name, *cells, f"{item.seconds:.1f}"])
    return table


def _model() -> Cells:
    loops, terms = loop_errors(), term_errors()
    table: Cells = [["sets", "relative error of w'", "largest difference of the quaternion in closed loop"]]
    return [*table, *([name, f"{terms[name]:.1e}", f"{loops[name]:.1e}"] for name in loops)]


def _sampling(flights: Flights) -> Cells:
    table: Cells = [["period [s]", *INTEGRATIONS]]
    for period in PERIODS:
        cells = []
        for name in INTEGRATIONS:
            flight = flights.get(f"{name}, {period:g} s")
            if flight is None:
                cells.append("-")
                continue
            error = np.linalg.norm(fault_error(flight, LATE))
            cells.append(f"{largest(flight, LATE):.1e}, {error:.3f} N m, {flight.energy(commanded=True):.0f} N^2 m^2 s")
        table.append([f"{period:g}", *cells])
    return table


def _vibration(flights: Flights) -> Cells:
    moments = (10.0, 30.0, 78.0, 90.0, 120.0, 195.0)
    table: Cells = [["flight", *(f"{moment:g} s" for moment in moments), "torque at 160-200 s [N m]"]]
    for name in (*SCHEMES, *OTHERS, "FASMC, healthy"):
        flight = flights[name]
        energies = [f"{1e3 * energy_at(flight, moment):.3g}" for moment in moments]
        table.append([name, *energies, f"{shaking(flight, LATE):.3f}"])
    return table


def evaluate(flights: Flights) -> Reproduction:
    """Judge the claims and draw the figures."""
    compared = {name: flights[name] for name in SCHEMES}
    own, learning = flights["FASMC"], flights["FASMC with ILO-class"]
    shaken = {name: flights[name] for name in (*SCHEMES, "pd_dob", "pd_shaped")}
    loops = closed_loops()
    time = np.linspace(0.0, 40.0, len(loops["nonlinear"]))
    return Reproduction(
        claims(flights),
        studies(flights),
        {
            "attitude": figures.attitude(compared),
            "schemes": figures.errors({**compared, "FASMC solved": flights["FASMC solved"]}),
            "torque": figures.torque(compared),
            "energy": figures.histories(
                {name: (flight.time, flight.spent(commanded=True)) for name, flight in compared.items()},
                "integral of |u|$^2$ [N$^2$ m$^2$ s]",
            ),
            "faults": figures.torques_estimated(
                {"FAFEO": (own, fault_torque(own)), "ILO-class": (learning, fault_torque(learning))}
            ),
            "vibration": figures.vibration_estimated(own),
            "modes": figures.histories(
                {name: (flight.time, np.maximum(flight.modal_energy[:, 0], 1e-9)) for name, flight in shaken.items()},
                "energy of the modes [J]",
                logarithmic=True,
            ),
            "model": figures.histories(
                {name: (time, np.maximum(np.abs(loop - loops["nonlinear"]).max(axis=1), 1e-17))
                 for name, loop in loops.items() if name != "nonlinear"},
                "largest difference of the quaternion [-]",
                logarithmic=True,
            ),
        },
    )  # fmt: skip
