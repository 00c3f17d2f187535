"""Studies and figures for Zhang and Zhou 2019."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from ftac_gym import scenarios
from ftac_gym.evaluation.tables import Cells
from ftac_gym.reproduction import paper_figures as figures
from ftac_gym.reproduction.inverse_dynamics import peak_wheel_torque
from ftac_gym.reproduction.recordings import Recordings
from ftac_gym.reproduction.wording import grid, milliseconds, percent, seconds, settled, table
from ftac_gym.reproduction.zhang_zhou_2019.plans import LAYERS, PERIODS, SAMPLED


def studies(flights: Recordings) -> dict[str, Cells]:
    """Return the tables that settle the claims."""
    return {
        "All schemes and comparators": _schemes(flights),
        "Step size and sampling: 1 deg after, largest error of the last 10 s": _sampling(flights),
        "The anti-saturation system": _auxiliary(flights),
        "Torque that the reference needs of the most loaded wheel [N m]": _needs(),
        "Random starts": _starts(flights),
    }


def _schemes(flights: Recordings) -> Cells:
    apart = ("random", "auxiliary")
    schemes = {name: item for name, item in flights.items() if "layer" not in name and not name.startswith(apart)}
    return table("flight", schemes, {
        "0.1 deg after": settled,
        "steady [deg]": lambda flight: f"{flight.steady():.4f}",
        "saturated": lambda flight: percent(flight.saturated()),
        "chatter [N m/s]": lambda flight: f"{flight.chatter():.1f}",
    })  # fmt: skip


def _sampling(flights: Recordings) -> Cells:
    def cell(kind: tuple[str, float], layer: float) -> str:
        flight = flights.get(f"{kind[0]}, {kind[1]} s, layer {layer}")
        return f"{settled(flight, 1.0)}, {flight.steady():.4f} deg" if flight else "-"

    rows = {(name, label): (name, period) for name in SAMPLED for label, period in milliseconds(PERIODS).items()}
    return grid(("law", "period [ms]"), rows, {f"layer {layer}" if layer else "sign": layer for layer in LAYERS}, cell)


def _auxiliary(flights: Recordings) -> Cells:
    variants = flights.relabelled({
        "off": "stabilisation",
        "on, Euler 10 ms": "auxiliary, 10 ms",
        "on, Euler 1 ms": "auxiliary, 1 ms",
        "on, 10 ms with 1,000 sub-steps": "auxiliary, fine",
    })  # fmt: skip
    return table("anti-saturation system", variants, {
        "0.1 deg after": settled,
        "steady [deg]": lambda flight: f"{flight.steady():.4f}",
    })  # fmt: skip


def _needs() -> Cells:
    names = ("zhang_zhou_2019", "zhang_zhou_2019_feasible")
    return table("reference", {name: scenarios.get(name) for name in names}, {
        "shared best": lambda task: f"{peak_wheel_torque(task):.1f}",
        "pseudo-inverse": lambda task: f"{peak_wheel_torque(task, allocation='pseudo_inverse'):.1f}",
        "shared best, with disturbance and faults":
            lambda task: f"{peak_wheel_torque(task, disturbance=True, faults=True):.1f}",
    })  # fmt: skip


def _starts(flights: Recordings) -> Cells:
    times = flights["random starts"].arrivals()
    # No time lies between a start that settles and one that never does, so that interpolation is left out.
    quantiles = [seconds(float(value)) for value in np.percentile(times, [0, 50, 95, 100], method="higher")]
    return [
        ["random attitudes, rates to 0.5 rad/s", "first", "median", "95 %", "last"],
        [f"{len(times)} starts, 0.1 deg after", *quantiles],
    ]


def draw(flights: Recordings) -> dict[str, Figure]:
    """Draw the figures, by file name without ending."""
    scaled = "Shen-class, scaled"
    return {
        "attitude": figures.attitude(flights.chosen(("as printed, 5 N m", "tracking", "Shen-class", scaled))),
        "torque": figures.torque(flights.chosen(("printed, 2 N m", "tracking", scaled))),
        "estimates": figures.estimates(flights.chosen(("as printed, 5 N m", "printed, 5 N m", "tracking"))),
        "schemes": figures.errors(
            flights.chosen(("tracking", "tracking, sign", "tracking, no observer", "tracking, oracle", scaled))
        ),
    }
