"""Zhang and Zhou 2019 reproduced: verdicts, studies, figures."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ftac_gym import scenarios
from ftac_gym.evaluation.tables import Cells
from ftac_gym.reproduction import figures
from ftac_gym.reproduction.claims import Reproduction
from ftac_gym.reproduction.flight import Flight
from ftac_gym.reproduction.inverse_dynamics import peak_wheel_torque
from ftac_gym.reproduction.variations import seconds, settled
from ftac_gym.reproduction.zhang_zhou_2019.claims import claims
from ftac_gym.reproduction.zhang_zhou_2019.plans import LAYERS, PERIODS


def studies(flights: Mapping[str, Flight]) -> dict[str, Cells]:
    """Return the tables that settle the claims."""
    return {
        "All schemes and comparators": _schemes(flights),
        "Step size and sampling: 1 deg after, largest error of the last 10 s": _sampling(flights),
        "The anti-saturation system": _auxiliary(flights),
        "Torque that the reference needs of the most loaded wheel [N m]": _needs(),
        "Random starts": _starts(flights["random starts"]),
    }


def _schemes(flights: Mapping[str, Flight]) -> Cells:
    table: Cells = [["flight", "0.1 deg after", "steady [deg]", "saturated", "chatter [N m/s]"]]
    for name, flight in flights.items():
        if "layer" not in name and not name.startswith(("random", "auxiliary")):
            row = [settled(flight), f"{flight.steady():.4f}", f"{100 * flight.saturated():.0f} %"]
            table.append([name, *row, f"{flight.chatter():.1f}"])
    return table


def _sampling(flights: Mapping[str, Flight]) -> Cells:
    table: Cells = [["law", "period [ms]", *(f"layer {layer}" if layer else "sign" for layer in LAYERS)]]
    for name in ("stabilisation", "tracking"):
        for period in PERIODS:
            flown = [flights.get(f"{name}, {period} s, layer {layer}") for layer in LAYERS]
            cells = [f"{settled(item, 1.0)}, {item.steady():.4f} deg" if item else "-" for item in flown]
            table.append([name, f"{1000 * period:g}", *cells])
    return table


def _auxiliary(flights: Mapping[str, Flight]) -> Cells:
    labels = {
        "off": "stabilisation",
        "on, Euler 10 ms": "auxiliary, 10 ms",
        "on, Euler 1 ms": "auxiliary, 1 ms",
        "on, 10 ms with 1,000 sub-steps": "auxiliary, fine",
    }
    rows = [[label, settled(flights[name]), f"{flights[name].steady():.4f}"] for label, name in labels.items()]
    return [["anti-saturation system", "0.1 deg after", "steady [deg]"], *rows]


def _needs() -> Cells:
    table: Cells = [["reference", "shared best", "pseudo-inverse", "shared best, with disturbance and faults"]]
    for name in ("zhang_zhou_2019", "zhang_zhou_2019_feasible"):
        scenario = scenarios.get(name)
        needs = (
            peak_wheel_torque(scenario),
            peak_wheel_torque(scenario, allocation="pseudo_inverse"),
            peak_wheel_torque(scenario, disturbance=True, faults=True),
        )
        table.append([name, *(f"{need:.1f}" for need in needs)])
    return table


def _starts(flight: Flight) -> Cells:
    times = np.array([flight.settling(0.1, craft) for craft in range(flight.error.shape[1])])
    # Between a start that settles and one that does not there is nothing to interpolate.
    quantiles = [seconds(float(value)) for value in np.percentile(times, [0, 50, 95, 100], method="higher")]
    return [
        ["random attitudes, rates to 0.5 rad/s", "first", "median", "95 %", "last"],
        [f"{len(times)} starts, 0.1 deg after", *quantiles],
    ]


def evaluate(flights: Mapping[str, Flight]) -> Reproduction:
    """Judge the claims and draw the figures."""

    def chosen(*names: str) -> dict[str, Flight]:
        return {name: flights[name] for name in names}

    drawn = {
        "attitude": figures.attitude(chosen("as printed, 5 N m", "tracking", "Shen-class", "Shen-class, scaled")),
        "torque": figures.torque(chosen("printed, 2 N m", "tracking", "Shen-class, scaled")),
        "estimates": figures.estimates(chosen("as printed, 5 N m", "printed, 5 N m", "tracking")),
        "schemes": figures.errors(
            chosen("tracking", "tracking, sign", "tracking, no observer", "tracking, oracle", "Shen-class, scaled")
        ),
    }
    return Reproduction(claims(flights), studies(flights), drawn)
