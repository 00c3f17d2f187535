"""Ma, Wang and Wang 2023 reproduced: verdicts, studies, figures."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ftac_gym.baselines.controllers.hsfc import HSFC
from ftac_gym.evaluation.tables import Cells
from ftac_gym.reproduction import figures
from ftac_gym.reproduction.claims import Reproduction
from ftac_gym.reproduction.flight import Flight
from ftac_gym.reproduction.ma_2023.claims import claims, stays
from ftac_gym.reproduction.ma_2023.motion import (
    ACCELERATION,
    RATE,
    arrived,
    largest_torque,
    peak,
    printed_bound,
    signed_error,
    small,
    went_round,
)
from ftac_gym.reproduction.ma_2023.plans import (
    ADAPTING,
    ANGLES,
    FAULTY,
    HELD,
    PACES,
    PERIODS,
    PRINTED_HEALTHY,
    SIGNS,
    STEPS,
    WAYS,
)
from ftac_gym.utils.parameters import FloatArray

GAIN = 5.0
"""k [N m]."""

SMALLEST = 1e-6
"""Adaptive gain that is still drawn."""

TURNED = 20.0
"""Until when e_4 is drawn [s]."""


def studies(flights: Mapping[str, Flight]) -> dict[str, Cells]:
    """Return the tables that settle the claims."""
    low, high = resonance(flights["5.1, without u2"])
    return {
        "All schemes (10 ms; HSFC where no other is named)": _schemes(flights),
        "Largest torque [N m] (c1 and c2 of (44), f = J_M (c1^2 + c2))": _bounds(flights),
        "Random attitudes at rest, no fault, no disturbance, gains of 5.2 (2 ms, 40 s)": _starts(flights),
        "Way round at rest, no disturbance (50 ms, 40 s, 12 axes): median path over shortest path, and how many go the "
        "long way (from 175 deg |e4| is within eta)":
            _ways(flights),
        f"Speed of the disturbance, 5.1 without u2 (resonance of the faulty craft at {low:.2f} to {high:.2f} rad/s)":
            _paces(flights),
        "Step size, 5.2 as printed: error [deg] (the step is the control period)": _steps(flights),
        "Sampling, 5.1 (20 s): 1 deg after, steady error of the last 5 s [deg], chatter [N m/s], at the limit":
            _holds(flights),
    }  # fmt: skip


def resonance(flight: Flight, smoothing: float = 0.05) -> tuple[float, float]:
    """Return the lowest and highest natural frequency sqrt(G k / (2 delta J)) of HSFC near the target [rad/s]."""
    inertia = np.linalg.eigvalsh(flight.scenario.spacecraft.inertia_matrix)
    stiffness = float(flight.true_effectiveness.mean()) * GAIN / (2.0 * smoothing)
    return float(np.sqrt(stiffness / inertia.max())), float(np.sqrt(stiffness / inertia.min()))


def _schemes(flights: Mapping[str, Flight]) -> Cells:
    heading = [
        "flight",
        "5 deg after",
        "1 deg after",
        "steady [deg]",
        "largest torque [N m]",
        "chatter [N m/s]",
        "at the limit",
    ]
    table: Cells = [[*heading, "energy [N^2 m^2 s]"]]
    for name, flight in flights.items():
        if name.startswith(("5.1", "5.2")):
            row = [
                arrived(flight, 5.0),
                arrived(flight, 1.0),
                f"{flight.steady():.4f}",
                f"{peak(flight):.1f}",
                f"{flight.chatter():.1f}",
            ]
            table.append([name, *row, f"{100 * flight.saturated():.1f} %", f"{flight.energy():.0f}"])
    return table


def _bounds(flights: Mapping[str, Flight]) -> Cells:
    table: Cells = [["law", "(21)", "corrected", "20000 random states", "in the example"]]
    for name in ("printed", "g0 = 0.6", "|u1_i|, g0 = 0.2", "|u1_i|, g0 = 0.6"):
        law, gains = FAULTY[name]
        scenario = flights["5.1, printed"].scenario
        effectiveness = 0.6 if name.endswith("0.6") else 0.2
        componentwise = "componentwise" if name.startswith("|") else "norm"
        built = HSFC(scenario, smallest_effectiveness=effectiveness, compensation=componentwise)
        row = [printed_bound(scenario, effectiveness), built.torque_bound(RATE, ACCELERATION)]
        row += [largest_torque(scenario, law, gains), peak(flights[f"5.1, {name}, unlimited"])]
        table.append([name, *(f"{value:.2f}" for value in row)])
    return table


def margins(flight: Flight, gamma: FloatArray, adaptation: float, smoothing: float) -> FloatArray:
    """Return g^2 - 2 alpha k |e_v|^2 / delta where S = 0 is reached to within the layer, (N,); nan if it is not.

    There e_v' = -g^2 e_v / 2 and (g^2)' = -2 alpha k |e_v|^2 g^2 / delta, near the target: the difference is kept, and
    it is what is left of g^2 in the end.
    """
    axis = signed_error(flight)[: len(gamma), :, 1:]
    variable = flight.rate[: len(gamma)] + gamma[..., None] ** 2 * axis
    within = (np.abs(variable) <= gamma[..., None] ** 2 * smoothing).all(axis=2)
    first = within.argmax(axis=0), np.arange(gamma.shape[1])
    square = np.einsum("tni,tni->tn", axis, axis)
    left = gamma[first] ** 2 - 2.0 * adaptation * GAIN * square[first] / smoothing
    reached: FloatArray = np.where(within.any(axis=0), left, np.nan)
    return reached


def _starts(flights: Mapping[str, Flight]) -> Cells:
    flight = flights["starts, printed"]
    gamma = flight.memory["gamma"][flight.time < 15.0, :, 0]
    gains = PRINTED_HEALTHY["adaptation"], PRINTED_HEALTHY["smoothing"]
    margin, left = margins(flight, gamma, *gains), stays(flight)
    heading = ["angle [deg]", "starts", "g^2 > 2 alpha k |e_v|^2 / delta", "end within 0.1 deg", "both alike"]
    table: Cells = [[*heading, "largest error left", "g left at 15 s"]]
    for low, high in ((5, 30), (30, 60), (60, 90), (90, 120), (120, 150), (150, 175)):
        some = (flight.error[0] >= low) & (flight.error[0] < high)
        if not some.any():
            continue
        alike = int(((margin[some] > 0.0) == ~left[some]).sum())
        counts = [f"{int(count)}" for count in (some.sum(), (margin[some] > 0.0).sum(), (~left[some]).sum(), alike)]
        last = gamma[-1, some]
        table.append([f"{low} to {high}", *counts, small(flight.error[-1, some].max()),
                      f"{last.min():.2g} to {last.max():.2g}"])  # fmt: skip
    return table


def _ways(flights: Mapping[str, Flight]) -> Cells:
    table: Cells = [["law", "start", *(f"{angle} deg" for angle in ANGLES)]]
    for name in WAYS:
        for sign in SIGNS:
            cells = []
            for angle in ANGLES:
                flight = flights[f"way: {name}, {angle} deg, {sign}"]
                other = went_round(flight, sign == SIGNS[1])
                cells.append(f"{np.median(flight.path_ratio()):.2f}, {int(other.sum())} of {len(other)}")
            table.append([name, sign, *cells])
    return table


def _paces(flights: Mapping[str, Flight]) -> Cells:
    table: Cells = [["times as fast", "frequencies [rad/s]", "largest error of the last 10 s [deg]"]]
    calm = flights["5.1, without u2, no disturbance"]
    table.append(["no disturbance", "-", f"{calm.steady():.4f}"])
    for pace in PACES:
        fast = ", ".join(f"{pace * value:g}" for value in (1.0, 1.2, 1.5))
        table.append([f"{pace:g}", fast, f"{flights[f'disturbance {pace:g} times as fast'].steady():.3f}"])
    return table


def _steps(flights: Mapping[str, Flight]) -> Cells:
    times = (5.0, 10.0, 15.0, 20.0)
    heading = ["step [ms]", *(f"at {time:g} s" for time in times)]
    table: Cells = [[*heading, "largest torque [N m]", "chatter until 10 s [N m/s]", "chatter after 15 s [N m/s]"]]
    for step in STEPS:
        flight = flights[f"step: {step} s"]
        at = np.minimum(np.searchsorted(flight.time, np.array(times) - 1e-9), len(flight.time) - 1)
        cells = [f"{value:.4f}" for value in flight.error[at, 0]]
        chatter = f"{variation(flight, 0.0, 10.0):.1f}", f"{variation(flight, 15.0, np.inf):.1f}"
        table.append([f"{1000 * step:g}", *cells, f"{peak(flight):.2f}", *chatter])
    return table


def variation(flight: Flight, start: float, end: float) -> float:
    """Return the total variation of the commands of the first craft between two times, per second [N m/s]."""
    some = flight.command[(flight.time[:-1] >= start) & (flight.time[:-1] < end), 0]
    return float(np.abs(np.diff(some, axis=0)).sum(axis=0).mean() / max(len(some), 1) / flight.scenario.control_period)


def _holds(flights: Mapping[str, Flight]) -> Cells:
    table: Cells = [["period [ms]", *HELD]]
    for period in PERIODS:
        cells = []
        for name in HELD:
            flight = flights[f"hold: {name}, {period} s"]
            shares = f"{flight.chatter():.1f}, {100 * flight.saturated():.0f} %"
            cells.append(f"{arrived(flight, 1.0, 5.0)}, {flight.steady(5.0):.3g}, {shares}")
        table.append([f"{1000 * period:g}", *cells])
    return table


def _gammas(flights: Mapping[str, Flight]) -> dict[str, tuple[FloatArray, FloatArray]]:
    """Return the adaptive gains of flights of both examples."""
    lines = {}
    for name in ADAPTING:
        flight = flights[name]
        early = flight.time < 30.0
        gamma = flight.memory["gamma"][early, 0, 0]
        lines[name] = flight.time[early], np.where(gamma > SMALLEST, gamma, np.nan)
    return lines


def _scalar(flight: Flight) -> tuple[FloatArray, FloatArray]:
    """Return times and e_4 of the first craft."""
    early = flight.time <= TURNED
    return flight.time[early], signed_error(flight)[early, 0, 0]


def evaluate(flights: Mapping[str, Flight]) -> Reproduction:
    """Judge the claims and draw the figures."""
    compared = {name: flights[f"5.1, {name}"] for name in ("printed", "without u2", "|u1_i|, g0 = 0.6")}
    faulty = ("printed", "without u2", "|u1_i|, g0 = 0.6", "along S", "floor", "AFNTSMC", "SHOPD+")
    turned = {name: flights[f"5.2, {name}"] for name in ("printed", "gains of 5.1", "floor", "AFNTSMC", "SHOPD+")}
    scalars = {**turned, "gains of 5.1, h = 1": flights["5.2, gains of 5.1, h = 1"]}
    drawn = {
        "attitude": figures.attitude(compared),
        "rates": figures.rates(compared),
        "torque": figures.torque(compared),
        "schemes": figures.errors({name: flights[f"5.1, {name}"] for name in faulty}),
        "adaptation": figures.histories(_gammas(flights), "adaptive gain g [(rad/s)^(1/2)]", logarithmic=True),
        "comparison": figures.errors(turned),
        "effort": figures.torque(
            {
                # Sampled at 10 ms it chatters from 6 s on.
                "printed, 1 ms": flights["step: 0.001 s"],
                **{name: turned[name] for name in ("gains of 5.1", "AFNTSMC", "SHOPD+")},
            }
        ),
        "unwinding": figures.histories({name: _scalar(flight) for name, flight in scalars.items()}, "e4 [-]"),
        "energy": figures.histories(
            {name: (flight.time, flight.spent()) for name, flight in turned.items()}, "energy [N^2 m^2 s]"
        ),
    }
    return Reproduction(claims(flights), studies(flights), drawn)
