"""Studies and figures for Li, Xu and Chang 2023."""

from __future__ import annotations

from functools import partial

import numpy as np
from matplotlib.figure import Figure

from ftac_gym.evaluation.tables import Cells
from ftac_gym.reproduction import paper_figures as figures
from ftac_gym.reproduction.li_2023 import measures
from ftac_gym.reproduction.li_2023.inequalities import inequalities
from ftac_gym.reproduction.li_2023.measures import CALM, FIRST, LATE
from ftac_gym.reproduction.li_2023.model import DURATION, MEMBERSHIPS, closed_loops, loop_errors, term_errors
from ftac_gym.reproduction.li_2023.plans import BOUNDS, INTEGRATIONS, NOISES, OTHERS, PERIODS, SCHEMES
from ftac_gym.reproduction.recordings import Recording, Recordings
from ftac_gym.reproduction.wording import each, grid, named, seconds, table

NOISY = tuple(f"FASMC, noise {noise:g}" for noise in NOISES)


def studies(flights: Recordings) -> dict[str, Cells]:
    """Return the tables that settle the claims."""
    return {
        "All schemes": _schemes(flights),
        "Observers: root mean squares of the errors": _observers(flights),
        "Matrix inequalities": _inequalities(),
        "Fuzzy model against the nonlinear one": table("sets", named(loop_errors()), {
            "relative error of w'": lambda name: f"{term_errors()[name]:.1e}",
            "largest difference of the quaternion in closed loop": lambda name: f"{loop_errors()[name]:.1e}",
        }),
        "Sampling the observer: largest |q_ev| and RMS of f^ - f from 160 to 200 s, |u|^2": grid(
            "period [s]", named(PERIODS, "{:g}"), named(INTEGRATIONS),
            lambda period, method: _sampled(flights.get(f"{method}, {period:g} s"))),
        "Vibration: energy of the modes [mJ], and root mean square of their torque on the body": _vibration(flights),
    }  # fmt: skip


def _schemes(flights: Recordings) -> Cells:
    kinds = ("healthy", "sum", "printed start", "fast start")
    more = ("FASMC, weak", "FASMC, aligned", "FASMC, mean gains", "FASMC, from zero", "FASMC, bounded")
    names = [*SCHEMES, *OTHERS, *(f"{name}, {kind}" for kind in kinds for name in SCHEMES), *more]
    names += [*(f"FASMC, half, {bound:g} N m" for bound in BOUNDS), *NOISY]
    return table("flight", flights.chosen(names), {
        "0.01 after, first": lambda flight: seconds(measures.settling(flight, FIRST)),
        "0.01 after, second": lambda flight: seconds(measures.settling(flight, measures.SECOND)),
        "|q_ev| at 35-40 s": lambda flight: f"{measures.largest(flight, (35.0, 40.0)):.1e}",
        "|q_ev| at 160-200 s": lambda flight: f"{measures.final(flight):.1e}",
        "|u|^2 in 40 s": lambda flight: f"{flight.energy(40.0, commanded=True):.0f}",
        "|u|^2 in 200 s [N^2 m^2 s]": lambda flight: f"{flight.energy(commanded=True):.0f}",
        "any wheel at the limit [%]": lambda flight: f"{100.0 * measures.any_at_limit(flight):.1f}",
        "chatter [N m/s]": lambda flight: f"{flight.chatter():.2f}",
    })  # fmt: skip


def _observers(flights: Recordings) -> Cells:
    def vibration(flight: Recording, window: tuple[float, float]) -> str:
        if flight.vibration is None:
            return "-"
        error, size = measures.vibration_error(flight, window)
        return f"{error:.4f} of {size:.3f}"

    kinds = ("weak", "healthy", "undisturbed", "from zero", "from zero, bounded")
    learning = ("FASMC with ILO-class", "FASMC with ILO-class, weak")
    names = ("FASMC", *(f"FASMC, {kind}" for kind in kinds), "FASMC solved", *NOISY, *learning)
    return table("flight", flights.chosen(names), {
        "f^ - f at 15-40 s [N m]": lambda flight: f"{measures.fault_error_norm(flight, CALM):.4f}",
        "f^ - f at 160-200 s [N m], by channel":
            lambda flight: ", ".join(f"{value:.4f}" for value in measures.fault_error(flight, LATE)),
        "d^ - d of d at 15-40 s [N m]": lambda flight: vibration(flight, CALM),
        "d^ - d of d at 160-200 s [N m]": lambda flight: vibration(flight, LATE),
        "largest |w - w^| at 15-40, 160-200 s [rad/s]":
            lambda flight: ", ".join(f"{measures.rate_error(flight, window):.1e}" for window in (CALM, LATE)),
    })  # fmt: skip


def _inequalities() -> Cells:
    return table("problem", inequalities(), {
        "gamma": lambda item: f"{item.gamma:.4f}" if np.isfinite(item.gamma) else "none",
        "proved": lambda item: "yes" if item.holds else "no",
        "rules outside the disc": lambda item: ", ".join(str(rule) for rule in item.outside) or "-",
        "farthest pole": lambda item: f"{item.reach:.3f}",
        "largest F or K": lambda item: f"{item.gain:.4g}",
        "time [s]": lambda item: f"{item.seconds:.1f}",
    })  # fmt: skip


def _sampled(flight: Recording | None) -> str:
    """Return the cell of a flight in the study of sampling."""
    if flight is None:
        return "-"
    error, energy = measures.fault_error_norm(flight, LATE), flight.energy(commanded=True)
    return f"{measures.final(flight):.1e}, {error:.3f} N m, {energy:.0f} N^2 m^2 s"


def _vibration(flights: Recordings) -> Cells:
    moments = (10.0, 30.0, 78.0, 90.0, 120.0, 195.0)
    return table("flight", flights.chosen((*SCHEMES, *OTHERS, "FASMC, healthy")), {
        **each(moments, "{:g} s", lambda flight, moment: f"{1e3 * measures.energy_at(flight, moment):.3g}"),
        "torque at 160-200 s [N m]": lambda flight: f"{measures.shaking(flight, LATE):.3f}",
    })  # fmt: skip


def draw(flights: Recordings) -> dict[str, Figure]:
    """Draw the figures, by file name without ending."""
    compared, own = flights.chosen(SCHEMES), flights["FASMC"]
    loops = closed_loops()
    time = np.linspace(0.0, DURATION, len(loops["nonlinear"]))
    apart = {
        name: (time, np.maximum(np.abs(loops[name] - loops["nonlinear"]).max(axis=1), 1e-17)) for name in MEMBERSHIPS
    }
    return {
        "attitude": figures.attitude(compared),
        "schemes": figures.errors({**compared, "FASMC solved": flights["FASMC solved"]}),
        "torque": figures.torque(compared),
        "energy": figures.histories(
            compared, partial(Recording.spent, commanded=True), "integral of |u|$^2$ [N$^2$ m$^2$ s]"
        ),
        "faults": figures.torques_estimated(
            {"FAFEO": own, "ILO-class": flights["FASMC with ILO-class"]}, measures.fault_torque
        ),
        "vibration": figures.vibration_estimated(own),
        "modes": figures.histories(
            flights.chosen((*SCHEMES, "pd_dob", "pd_shaped")),
            lambda flight: np.maximum(flight.modal_energy[:, 0], 1e-9),
            "energy of the modes [J]",
            logarithmic=True,
        ),
        "model": figures.curves(apart, "largest difference of the quaternion [-]", logarithmic=True),
    }
