"""Studies and figures for Ma, Wang and Wang 2023."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from matplotlib.figure import Figure

from ftac_gym import baselines
from ftac_gym.baselines.controllers.hsfc import HSFC
from ftac_gym.evaluation.tables import Cells
from ftac_gym.reproduction import paper_figures as figures
from ftac_gym.reproduction.ma_2023 import measures, plans
from ftac_gym.reproduction.ma_2023.measures import arrived, small
from ftac_gym.reproduction.recordings import Plan, Recording, Recordings
from ftac_gym.reproduction.wording import each, grid, milliseconds, named, pairs, percent, table
from ftac_gym.utils.parameters import FloatArray


def studies(flights: Recordings) -> dict[str, Cells]:
    """Return the tables that settle the claims."""
    low, high = measures.resonance(flights["5.1, without u2"])
    return {
        "All schemes (10 ms; HSFC where no other is named)": _schemes(flights),
        "Largest torque [N m] (c1 and c2 of (44), f = J_M (c1^2 + c2))": _bounds(flights),
        "Random attitudes at rest, no fault, no disturbance, gains of 5.2 (2 ms, 40 s)": _starts(flights),
        "Way round at rest, no disturbance (50 ms, 40 s, 12 axes): median path over shortest path, and number of long "
        "ways (from 175 deg |e4| is within eta)":
            grid(("law", "start"), pairs(plans.WAYS, plans.SIGNS), named(plans.ANGLES, "{} deg"),
                 lambda kind, angle: _way(flights[f"way: {kind[0]}, {angle} deg, {kind[1]}"])),
        f"Speed of the disturbance, 5.1 without u2 (resonance with faults at {low:.2f} to {high:.2f} rad/s)":
            _paces(flights),
        "Step size, 5.2 as printed: error [deg] (the step is the control period)": _steps(flights),
        "Sampling, 5.1 (20 s): 1 deg after, steady error of the last 5 s [deg], chatter [N m/s], at the limit": grid(
            "period [ms]", milliseconds(plans.PERIODS), named(plans.HELD),
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
    def corrected(plan: Plan) -> float:
        baseline = baselines.build(plan.baseline, plan.scenario, **plan.gains)
        assert isinstance(baseline, HSFC)
        return baseline.torque_bound(measures.RATE, measures.ACCELERATION)

    printed = flights["5.1, printed"].scenario
    return table("law", named(plans.BOUNDED), {
        "(21)": lambda name: f"{measures.printed_bound(printed, 0.6 if name.endswith('0.6') else 0.2):.2f}",
        "corrected": lambda name: f"{corrected(flights[f'5.1, {name}'].plan):.2f}",
        "20000 random states": lambda name: f"{measures.largest_torque(flights[f'5.1, {name}'].plan):.2f}",
        "in the example": lambda name: f"{flights[f'5.1, {name}, unlimited'].peak():.2f}",
    })  # fmt: skip


def _starts(flights: Recordings) -> Cells:
    flight = flights["starts, printed"]
    start, ends = flight.error[0], ~measures.left_off(flight)
    kept, last = measures.margins(flight, 15.0) > 0.0, flight.memory["gamma"][flight.time < 15.0][-1, :, 0]
    ranges = {
        f"{low} to {high}": (start >= low) & (start < high) for low, high in pairwise((5, 30, 60, 90, 120, 150, 175))
    }
    return table("angle [deg]", {name: some for name, some in ranges.items() if some.any()}, {
        "starts": lambda some: f"{some.sum()}",
        "g^2 > 2 alpha k |e_v|^2 / delta": lambda some: f"{(some & kept).sum()}",
        "end within 0.1 deg": lambda some: f"{(some & ends).sum()}",
        "both alike": lambda some: f"{(some & (kept == ends)).sum()}",
        "largest error left": lambda some: small(flight.error[-1, some].max()),
        "g left at 15 s": lambda some: f"{last[some].min():.2g} to {last[some].max():.2g}",
    })  # fmt: skip


def _way(flight: Recording) -> str:
    """Return the cell of a flight in the study of the way round."""
    other = measures.went_round(flight)
    return f"{np.median(flight.path_ratio()):.2f}, {int(other.sum())} of {len(other)}"


def _paces(flights: Recordings) -> Cells:
    calm = flights["5.1, without u2, no disturbance"]
    cells: Cells = [["times as fast", "frequencies [rad/s]", "largest error of the last 10 s [deg]"]]
    cells.append(["no disturbance", "-", f"{calm.steady():.4f}"])
    for pace in plans.PACES:
        fast = ", ".join(f"{pace * value:g}" for value in (1.0, 1.2, 1.5))
        cells.append([f"{pace:g}", fast, f"{flights[f'disturbance {pace:g} times as fast'].steady():.3f}"])
    return cells


def _steps(flights: Recordings) -> Cells:
    def error(flight: Recording, time: float) -> str:
        at = min(int(np.searchsorted(flight.time, time - 1e-9)), len(flight.time) - 1)
        return f"{flight.error[at, 0]:.4f}"

    steps = {name: flights[f"step: {step} s"] for name, step in milliseconds(plans.STEPS).items()}
    return table("step [ms]", steps, {
        **each((5.0, 10.0, 15.0, 20.0), "at {:g} s", error),
        "largest torque [N m]": lambda flight: f"{flight.peak():.2f}",
        "chatter until 10 s [N m/s]": lambda flight: f"{flight.chatter(0.0, 10.0):.1f}",
        "chatter after 15 s [N m/s]": lambda flight: f"{flight.chatter(15.0, np.inf):.1f}",
    })  # fmt: skip


def _held(flight: Recording) -> str:
    """Return the cell of a flight in the study of sampling."""
    shares = f"{flight.chatter():.1f}, {percent(flight.saturated())}"
    return f"{arrived(flight, 1.0, 5.0)}, {flight.steady(5.0):.3g}, {shares}"


def _gamma(flight: Recording) -> FloatArray:
    """Return the adaptive gain of the first spacecraft until 30 s, as far as it exceeds 1e-6."""
    gamma = flight.memory["gamma"][flight.time < 30.0, 0, 0]
    return np.where(gamma > 1e-6, gamma, np.nan)


def _scalar(flight: Recording) -> FloatArray:
    """Return e_4 of the first spacecraft until 20 s."""
    scalar: FloatArray = measures.signed_error(flight)[flight.time <= 20.0, 0, 0]
    return scalar


def draw(flights: Recordings) -> dict[str, Figure]:
    """Draw the figures, by file name without ending."""
    compared = flights.chosen(("printed", "without u2", "|u1_i|, g0 = 0.6"), "5.1, {}")
    faulty = flights.chosen((*compared, "along S", "floor", "AFNTSMC", "SHOPD+"), "5.1, {}")
    turned = flights.chosen(("printed", "gains of 5.1", "floor", "AFNTSMC", "SHOPD+"), "5.2, {}")
    scalars = Recordings({**turned, "gains of 5.1, h = 1": flights["5.2, gains of 5.1, h = 1"]})
    # Sampled at 10 ms, the printed law chatters from 6 s on.
    effort = {"printed, 1 ms": flights["step: 0.001 s"], **turned.chosen(("gains of 5.1", "AFNTSMC", "SHOPD+"))}
    return {
        "attitude": figures.attitude(compared),
        "rates": figures.rates(compared),
        "torque": figures.torque(compared),
        "schemes": figures.errors(faulty),
        "adaptation": figures.histories(
            flights.chosen(plans.ADAPTING), _gamma, "adaptive gain g [(rad/s)^(1/2)]", logarithmic=True
        ),
        "comparison": figures.errors(turned),
        "effort": figures.torque(effort),
        "unwinding": figures.histories(scalars, _scalar, "e4 [-]"),
        "energy": figures.histories(turned, Recording.spent, "energy [N^2 m^2 s]"),
    }
