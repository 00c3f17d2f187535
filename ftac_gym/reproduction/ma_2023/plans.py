"""Flights for the claims of Ma, Wang and Wang 2023."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from itertools import product
from typing import Any

from ftac_gym import scenarios
from ftac_gym.reproduction.recordings import Plan
from ftac_gym.reproduction.variations import UNLIMITED, sampled, with_limit
from ftac_gym.task.disturbances import Disturbance
from ftac_gym.task.initial_state import InitialState
from ftac_gym.task.references import fixed_attitude
from ftac_gym.task.scenario import Scenario

Tuned = tuple[str, Mapping[str, Any]]
"""Baseline and its gains."""

FAULTY: dict[str, Tuned] = {
    "printed": ("hsfc", {}),
    "g0 = 0.6": ("hsfc", {"smallest_effectiveness": 0.6}),
    "without u2": ("hsfc", {"smallest_effectiveness": 1.0}),
    "|u1_i|, g0 = 0.6": ("hsfc_componentwise", {}),
    "|u1_i|, g0 = 0.2": ("hsfc_componentwise", {"smallest_effectiveness": 0.2}),
    "along S": ("hsfc", {"compensation": "sliding"}),
    "sign": ("hsfc", {"layer": 0.0}),
    "floor": ("hsfc_floor", {}),
    "AFNTSMC": ("afntsmc", {}),
    "SHOPD+": ("shopd_plus", {}),
    "SHOPD+, q_c = 0": ("shopd_plus_zero_filter", {}),
}
"""Baselines in the example of section 5.1, by their names in the report; those without a name are HSFC."""

PRINTED_HEALTHY: Mapping[str, Any] = {"adaptation": 0.1, "smoothing": 0.01, "smallest_effectiveness": 1.0}
"""The gains of section 5.2."""

HEALTHY: dict[str, Tuned] = {
    "printed": ("hsfc", PRINTED_HEALTHY),
    "printed, h = 1": ("hsfc", {**PRINTED_HEALTHY, "hysteresis": None}),
    "gains of 5.1": ("hsfc", {"smallest_effectiveness": 1.0}),
    "gains of 5.1, h = 1": ("hsfc", {"smallest_effectiveness": 1.0, "hysteresis": None}),
    "floor": ("hsfc_floor", {}),
    "AFNTSMC": ("afntsmc", {}),
    "SHOPD+": ("shopd_plus", {}),
    "SHOPD+, q_c = 0": ("shopd_plus_zero_filter", {}),
}
"""Baselines in the example of section 5.2."""

WAYS: dict[str, Tuned] = {
    "HSFC": ("hsfc", {"smallest_effectiveness": 1.0}),
    "HSFC, eta = 0.5": ("hsfc", {"smallest_effectiveness": 1.0, "hysteresis": 0.5}),
    "HSFC, h = 1": ("hsfc", {"smallest_effectiveness": 1.0, "hysteresis": None}),
    "AFNTSMC": ("afntsmc", {}),
    "AFNTSMC, eta = 0.1": ("afntsmc", {"hysteresis": 0.1}),
    "SHOPD+": ("shopd_plus", {}),
}
"""Baselines whose way round is measured."""

HELD = ("printed", "|u1_i|, g0 = 0.6", "without u2", "along S", "floor", "AFNTSMC", "SHOPD+")
"""Baselines of section 5.1 in the study of sampling."""

ADAPTING = ("5.1, printed", "5.1, without u2", "5.1, |u1_i|, g0 = 0.6", "5.2, printed", "5.2, gains of 5.1")
"""Flights with a figure of their adaptive gain."""

BOUNDED = ("printed", "g0 = 0.6", "|u1_i|, g0 = 0.2", "|u1_i|, g0 = 0.6")
"""Baselines of section 5.1 whose largest torque is compared with a bound."""

ANGLES = (20, 60, 100, 140, 165, 175)
PERIODS = (0.001, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2)
STEPS = (0.01, 0.002, 0.001, 0.0005)
HYSTERESES = (0.05, 0.1, 0.5, 0.88, 0.9)
PACES = (0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 4.0)
SMOOTHINGS = (0.05, 0.2, 0.8)
SIGNS = {"q4 > 0": False, "q4 < 0": True}
"""Signs of the scalar at the start, and whether the quaternion is flipped for them."""


def plans() -> dict[str, Plan]:
    """Return every flight that the claims and the studies need, by name."""
    faulty, healthy = scenarios.get("ma_2023_faulty"), scenarios.get("ma_2023_unwinding")
    found = {**_faulty(faulty), **_healthy(healthy), **_at_rest(healthy)}
    return {**found, **{name: replace(found[name], recorded=("gamma",)) for name in (*ADAPTING, "starts, printed")}}


def _faulty(paper: Scenario) -> dict[str, Plan]:
    """Return flights in the example of section 5.1."""
    whole, free = paper.replace(faults=None), with_limit(paper.replace(duration=20.0), UNLIMITED)
    found = {f"5.1, {name}": Plan(paper, *tuned) for name, tuned in FAULTY.items()}
    for name in ("printed", "without u2", "|u1_i|, g0 = 0.6", "along S", "floor"):
        found[f"5.1, {name}, no fault"] = Plan(whole, *FAULTY[name])
        found[f"5.1, {name}, no disturbance"] = Plan(paper.replace(disturbance=None), *FAULTY[name])
    for name in BOUNDED:
        found[f"5.1, {name}, unlimited"] = Plan(free, *FAULTY[name])
    found["5.1, printed, long"] = Plan(paper.replace(duration=500.0), *FAULTY["printed"])
    found["fine: printed, no fault"] = Plan(sampled(whole, 0.002, 20.0), *FAULTY["printed"])
    found["5.1, SHOPD+, no fault"] = Plan(whole, "shopd_plus")
    for pace in PACES:
        paced = paper.replace(disturbance=_paced(paper, pace))
        found[f"disturbance {pace:g} times as fast"] = Plan(paced, *FAULTY["without u2"])
    for name, period in product(HELD, PERIODS):
        found[f"hold: {name}, {period} s"] = Plan(sampled(paper, period, 20.0), *FAULTY[name])
    return found


def _healthy(paper: Scenario) -> dict[str, Plan]:
    """Return flights in the example of section 5.2."""
    calm, free = paper.replace(disturbance=None), with_limit(paper, UNLIMITED)
    found = {f"5.2, {name}": Plan(paper, *tuned) for name, tuned in HEALTHY.items()}
    for name in ("printed", "gains of 5.1", "AFNTSMC", "SHOPD+"):
        found[f"5.2, {name}, other sign"] = Plan(paper, *HEALTHY[name], flipped=True)
        found[f"5.2, {name}, no disturbance"] = Plan(calm, *HEALTHY[name])
    found["5.2, AFNTSMC, unlimited"] = Plan(free, "afntsmc")
    found["5.2, AFNTSMC, unlimited, other sign"] = Plan(free, "afntsmc", flipped=True)
    for eta in HYSTERESES:
        found[f"eta = {eta}"] = Plan(paper.replace(duration=20.0), "hsfc", {**PRINTED_HEALTHY, "hysteresis": eta})
    for value in SMOOTHINGS:
        found[f"delta = {value}"] = Plan(calm, "hsfc", {"smallest_effectiveness": 1.0, "smoothing": value})
    for step in STEPS:
        found[f"step: {step} s"] = Plan(sampled(paper, step, 20.0), *HEALTHY["printed"])
    return found


def _at_rest(paper: Scenario) -> dict[str, Plan]:
    """Return flights to a reference at rest, without disturbance."""
    found = {}
    calm = paper.replace(reference=fixed_attitude(), disturbance=None)
    for (name, tuned), angle, (sign, flipped) in product(WAYS.items(), ANGLES, SIGNS.items()):
        turn = sampled(calm, 0.05, 40.0).replace(initial_state=InitialState(angle=math.radians(angle)))
        found[f"way: {name}, {angle} deg, {sign}"] = Plan(turn, *tuned, seed=1, num_spacecraft=12, flipped=flipped)
    starts = calm.replace(initial_state=InitialState(angle=(math.radians(5.0), math.radians(175.0))))
    # The printed gains become stiff where g goes to zero; those of 5.1 are slow.
    for name, period, duration in (("printed", 0.002, 40.0), ("gains of 5.1", 0.05, 120.0)):
        random = sampled(starts, period, duration)
        found[f"starts, {name}"] = Plan(random, *HEALTHY[name], seed=2, num_spacecraft=48)
    return found


def _paced(scenario: Scenario, pace: float) -> Disturbance:
    """Return the disturbance of a scenario with all frequencies times a factor."""
    disturbance = scenario.disturbance
    assert isinstance(disturbance, Disturbance)
    harmonics = tuple(
        replace(harmonic, frequency=pace * harmonic.frequency)  # type: ignore[operator]
        for harmonic in disturbance.harmonics
    )
    return replace(disturbance, harmonics=harmonics)
