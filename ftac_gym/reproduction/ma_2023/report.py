"""Verdicts, studies and figures for Ma, Wang and Wang 2023."""

from __future__ import annotations

import numpy as np

from ftac_gym import baselines
from ftac_gym.baselines.controllers.hsfc import HSFC
from ftac_gym.evaluation.tables import Cells
from ftac_gym.reproduction import paper_figures as figures
from ftac_gym.reproduction.ma_2023.claims import claims
from ftac_gym.reproduction.ma_2023.measures import (
    ACCELERATION,
    RATE,
    arrived,
    largest_torque,
    left_off,
    margins,
    printed_bound,
    resonance,
    signed_error,
    small,
    went_round,
)
from ftac_gym.reproduction.ma_2023.plans import (
    ADAPTING,
    ANGLES,
    BOUNDED,
    HELD,
    PACES,
    PERIODS,
    PRINTED_HEALTHY,
    SIGNS,
    STEPS,
    WAYS,
)
from ftac_gym.reproduction.recorder import Recording, Recordings
from ftac_gym.reproduction.verdicts import Reproduction
from ftac_gym.reproduction.wording import grid, named, percent, table
from ftac_gym.utils.parameters import FloatArray

SMALLEST = 1e-6
"""Smallest adaptive gain in a figure."""

TURNED = 20.0
"""End of the figure of e_4 [s]."""


def studies(flights: Recordings) -> dict[str, Cells]:
    """Return the tables that settle the claims."""
    low, high = resonance(flights["5.1, without u2"])
    return {
        "All schemes (10 ms; HSFC where no other is named)": _schemes(flights),
        "Largest torque [N m] (c1 and c2 of (44), f = J_M (c1^2 + c2))": _bounds(flights),
        "Random attitudes at rest, no fault, no disturbance, gains of 5.2 (2 ms, 40 s)": _starts(flights),
        "Way round at rest, no disturbance (50 ms, 40 s, 12 axes): median path over shortest path, and number of long "
        "ways (from 175 deg |e4| is within eta)":
            _ways(flights),
        f"Speed of the disturbance, 5.1 without u2 (resonance with faults at {low:.2f} to {high:.2f} rad/s)":
            _paces(flights),
        "Step size, 5.2 as printed: error [deg] (the step is the control period)": _steps(flights),
        "Sampling, 5.1 (20 s): 1 deg after, steady error of the last 5 s [deg], chatter [N m/s], at the limit": grid(
            "period [ms]", {f"{1000 * period:g}": period for period in PERIODS}, named(HELD),
            lambda period, name: _held(flights[f"hold: {name}, {period} s"])),
    }  # fmt: skip


def _schemes(flights: Recordings) -> Cells:
    schemes = {name: flight for name, flight in flights.items() if name.startswith(("5.1", "5.2"))}
    return table("flight", schemes, {
        "5 deg after": lambda flight: arrived(flight, 5.0),
        "1 deg after": lambda flight: arrived(flight, 1.0),
        "steady [deg]": lambda flight: f"{flight.steady():.4f}",
        "largest torque [N m]": lambda flight: f"{flight.peak():.1f}",
        "chatter [N m/s]": lambda flight: f"{flight.chatter():.1f}",
        "at the limit": lambda flight: percent(flight.saturated(), 1),
        "energy [N^2 m^2 s]": lambda flight: f"{flight.energy():.0f}",
    })  # fmt: skip


def _bounds(flights: Recordings) -> Cells:
    cells: Cells = [["law", "(21)", "corrected", "20000 random states", "in the example"]]
    for name in BOUNDED:
        plan = flights[f"5.1, {name}"].plan
        baseline = baselines.make(plan.baseline, plan.scenario, **plan.gains)
        assert isinstance(baseline, HSFC)
        stated = printed_bound(plan.scenario, 0.6 if name.endswith("0.6") else 0.2)
        found = largest_torque(plan), flights[f"5.1, {name}, unlimited"].peak()
        cells.append([name, *(f"{value:.2f}" for value in (stated, baseline.torque_bound(RATE, ACCELERATION), *found))])
    return cells


def _starts(flights: Recordings) -> Cells:
    flight = flights["starts, printed"]
    gamma = flight.memory["gamma"][flight.time < 15.0, :, 0]
    kept = margins(flight, gamma, PRINTED_HEALTHY["adaptation"], PRINTED_HEALTHY["smoothing"]) > 0.0
    ends, last, start = ~left_off(flight), gamma[-1], flight.error[0]
    cells: Cells = [["angle [deg]", "starts", "g^2 > 2 alpha k |e_v|^2 / delta", "end within 0.1 deg", "both alike",
                     "largest error left", "g left at 15 s"]]  # fmt: skip
    for low, high in ((5, 30), (30, 60), (60, 90), (90, 120), (120, 150), (150, 175)):
        some = (start >= low) & (start < high)
        if some.any():
            counts = (some, some & kept, some & ends, some & (kept == ends))
            cells.append([
                f"{low} to {high}", *(f"{int(count.sum())}" for count in counts), small(flight.error[-1, some].max()),
                f"{last[some].min():.2g} to {last[some].max():.2g}",
            ])  # fmt: skip
    return cells


def _ways(flights: Recordings) -> Cells:
    def cell(name: str, angle: int, sign: str) -> str:
        flight = flights[f"way: {name}, {angle} deg, {sign}"]
        other = went_round(flight)
        return f"{np.median(flight.path_ratio()):.2f}, {int(other.sum())} of {len(other)}"

    rows = [[name, sign, *(cell(name, angle, sign) for angle in ANGLES)] for name in WAYS for sign in SIGNS]
    return [["law", "start", *(f"{angle} deg" for angle in ANGLES)], *rows]


def _paces(flights: Recordings) -> Cells:
    calm = flights["5.1, without u2, no disturbance"]
    cells: Cells = [["times as fast", "frequencies [rad/s]", "largest error of the last 10 s [deg]"]]
    cells.append(["no disturbance", "-", f"{calm.steady():.4f}"])
    for pace in PACES:
        fast = ", ".join(f"{pace * value:g}" for value in (1.0, 1.2, 1.5))
        cells.append([f"{pace:g}", fast, f"{flights[f'disturbance {pace:g} times as fast'].steady():.3f}"])
    return cells


def _steps(flights: Recordings) -> Cells:
    def error(flight: Recording, time: float) -> str:
        at = min(int(np.searchsorted(flight.time, time - 1e-9)), len(flight.time) - 1)
        return f"{flight.error[at, 0]:.4f}"

    return table("step [ms]", {f"{1000 * step:g}": flights[f"step: {step} s"] for step in STEPS}, {
        "at 5 s": lambda flight: error(flight, 5.0),
        "at 10 s": lambda flight: error(flight, 10.0),
        "at 15 s": lambda flight: error(flight, 15.0),
        "at 20 s": lambda flight: error(flight, 20.0),
        "largest torque [N m]": lambda flight: f"{flight.peak():.2f}",
        "chatter until 10 s [N m/s]": lambda flight: f"{flight.chatter_between(0.0, 10.0):.1f}",
        "chatter after 15 s [N m/s]": lambda flight: f"{flight.chatter_between(15.0, np.inf):.1f}",
    })  # fmt: skip


def _held(flight: Recording) -> str:
    """Return the cell of a flight in the study of sampling."""
    shares = f"{flight.chatter():.1f}, {percent(flight.saturated())}"
    return f"{arrived(flight, 1.0, 5.0)}, {flight.steady(5.0):.3g}, {shares}"


def _gamma(flight: Recording) -> tuple[FloatArray, FloatArray]:
    """Return times and the adaptive gain of the first spacecraft."""
    early = flight.time < 30.0
    gamma = flight.memory["gamma"][early, 0, 0]
    return flight.time[early], np.where(gamma > SMALLEST, gamma, np.nan)


def _scalar(flight: Recording) -> tuple[FloatArray, FloatArray]:
    """Return times and e_4 of the first spacecraft."""
    early = flight.time <= TURNED
    return flight.time[early], signed_error(flight)[early, 0, 0]


def evaluate(flights: Recordings) -> Reproduction:
    """Judge the claims and draw the figures."""
    compared = flights.chosen(("printed", "without u2", "|u1_i|, g0 = 0.6"), "5.1, {}")
    faulty = flights.chosen((*compared, "along S", "floor", "AFNTSMC", "SHOPD+"), "5.1, {}")
    turned = flights.chosen(("printed", "gains of 5.1", "floor", "AFNTSMC", "SHOPD+"), "5.2, {}")
    scalars = Recordings({**turned, "gains of 5.1, h = 1": flights["5.2, gains of 5.1, h = 1"]})
    # Sampled at 10 ms, the printed law chatters from 6 s on.
    effort = {
        "printed, 1 ms": flights["step: 0.001 s"],
        **{name: flight for name, flight in turned.items() if name not in ("printed", "floor")},
    }
    drawn = {
        "attitude": figures.attitude(compared),
        "rates": figures.rates(compared),
        "torque": figures.torque(compared),
        "schemes": figures.errors(faulty),
        "adaptation": figures.histories(
            flights.chosen(ADAPTING).measured(_gamma), "adaptive gain g [(rad/s)^(1/2)]", logarithmic=True
        ),
        "comparison": figures.errors(turned),
        "effort": figures.torque(effort),
        "unwinding": figures.histories(scalars.measured(_scalar), "e4 [-]"),
        "energy": figures.histories(
            turned.measured(lambda flight: (flight.time, flight.spent())), "energy [N^2 m^2 s]"
        ),
    }
    return Reproduction(claims(flights), studies(flights), drawn)
