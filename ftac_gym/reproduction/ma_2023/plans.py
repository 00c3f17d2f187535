"""The flights that the claims of Ma, Wang and Wang 2023 ask for."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from ftac_gym import scenarios
from ftac_gym.reproduction.flight import Plan
from ftac_gym.reproduction.variations import UNLIMITED, sampled, with_limit
from ftac_gym.task.disturbances import Disturbance
from ftac_gym.task.initial_state import InitialState
from ftac_gym.task.references import fixed_attitude
from ftac_gym.task.scenario import Scenario

Law = tuple[str, Mapping[str, Any]]

FAULTY: dict[str, Law] = {
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
"""Laws in the example of section 5.1, by how they are called in the report; those without a name are HSFC."""

PRINTED_HEALTHY: Mapping[str, Any] = {"adaptation": 0.1, "smoothing": 0.01, "smallest_effectiveness": 1.0}
"""The gains of section 5.2."""

HEALTHY: dict[str, Law] = {
    "printed": ("hsfc", PRINTED_HEALTHY),
    "printed, h = 1": ("hsfc", {**PRINTED_HEALTHY, "hysteresis": None}),
    "gains of 5.1": ("hsfc", {"smallest_effectiveness": 1.0}),
    "gains of 5.1, h = 1": ("hsfc", {"smallest_effectiveness": 1.0, "hysteresis": None}),
    "floor": ("hsfc_floor", {}),
    "AFNTSMC": ("afntsmc", {}),
    "SHOPD+": ("shopd_plus", {}),
    "SHOPD+, q_c = 0": ("shopd_plus_zero_filter", {}),
}
"""Laws in the example of section 5.2."""

WAYS: dict[str, Law] = {
    "HSFC": ("hsfc", {"smallest_effectiveness": 1.0}),
    "HSFC, eta = 0.5": ("hsfc", {"smallest_effectiveness": 1.0, "hysteresis": 0.5}),
    "HSFC, h = 1": ("hsfc", {"smallest_effectiveness": 1.0, "hysteresis": None}),
    "AFNTSMC": ("afntsmc", {}),
    "AFNTSMC, eta = 0.1": ("afntsmc", {"hysteresis": 0.1}),
    "SHOPD+": ("shopd_plus", {}),
}
"""Laws whose way round is measured."""

HELD = ("printed", "|u1_i|, g0 = 0.6", "without u2", "along S", "floor", "AFNTSMC", "SHOPD+")
"""Laws of section 5.1 that are sampled."""

ADAPTING = ("5.1, printed", "5.1, without u2", "5.1, |u1_i|, g0 = 0.6", "5.2, printed", "5.2, gains of 5.1")
"""Flights whose adaptive gain is drawn."""

ANGLES = (20, 60, 100, 140, 165, 175)
PERIODS = (0.001, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2)
STEPS = (0.01, 0.002, 0.001, 0.0005)
HYSTERESES = (0.05, 0.1, 0.5, 0.88, 0.9)
PACES = (0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 4.0)
SMOOTHINGS = (0.05, 0.2, 0.8)
SIGNS = ("q4 > 0", "q4 < 0")


def plans() -> dict[str, Plan]:
    """Return every flight that the claims and the studies need, by name."""
    faulty, healthy = scenarios.get("ma_2023_faulty"), scenarios.get("ma_2023_unwinding")
    found = {**_faulty(faulty), **_healthy(healthy), **_ways(healthy), **_variations(faulty, healthy)}
    return {**found, **{name: replace(found[name], kept=("gamma",)) for name in (*ADAPTING, "starts, printed")}}


def _faulty(paper: Scenario) -> dict[str, Plan]:
    found = {f"5.1, {name}": Plan(paper, *law) for name, law in FAULTY.items()}
    for name in ("printed", "without u2", "|u1_i|, g0 = 0.6", "along S", "floor"):
        found[f"5.1, {name}, no fault"] = Plan(paper.replace(faults=None), *FAULTY[name])
        found[f"5.1, {name}, no disturbance"] = Plan(paper.replace(disturbance=None), *FAULTY[name])
    for name in ("printed", "g0 = 0.6", "|u1_i|, g0 = 0.2", "|u1_i|, g0 = 0.6"):
        found[f"5.1, {name}, unlimited"] = Plan(with_limit(paper.replace(duration=20.0), UNLIMITED), *FAULTY[name])
    found["5.1, printed, long"] = Plan(paper.replace(duration=500.0), *FAULTY["printed"])
    found["fine: printed, no fault"] = Plan(sampled(paper.replace(faults=None), 0.002, 20.0), *FAULTY["printed"])
    found["5.1, SHOPD+, no fault"] = Plan(paper.replace(faults=None), "shopd_plus")
    return found


def _healthy(paper: Scenario) -> dict[str, Plan]:
    found = {f"5.2, {name}": Plan(paper, *law) for name, law in HEALTHY.items()}
    for name in ("printed", "gains of 5.1", "AFNTSMC", "SHOPD+"):
        found[f"5.2, {name}, other sign"] = Plan(paper, *HEALTHY[name], flipped=True)
        found[f"5.2, {name}, no disturbance"] = Plan(paper.replace(disturbance=None), *HEALTHY[name])
    for flipped, name in ((False, "unlimited"), (True, "unlimited, other sign")):
        found[f"5.2, AFNTSMC, {name}"] = Plan(with_limit(paper, UNLIMITED), "afntsmc", flipped=flipped)
    return found


def _ways(paper: Scenario) -> dict[str, Plan]:
    rest = sampled(paper.replace(reference=fixed_attitude(), disturbance=None), 0.05, 40.0)
    return {
        f"way: {name}, {angle} deg, {sign}": Plan(
            rest.replace(initial_state=InitialState(angle=math.radians(angle))), *law, seed=1, craft=12,
            flipped=sign == SIGNS[1],
        )
        for name, law in WAYS.items() for angle in ANGLES for sign in SIGNS
    }  # fmt: skip


def _variations(faulty: Scenario, healthy: Scenario) -> dict[str, Plan]:
    """Return the flights of the studies, and those that a single claim needs."""
    found = {}
    calm = healthy.replace(reference=fixed_attitude(), disturbance=None)
    starts = calm.replace(initial_state=InitialState(angle=(math.radians(5.0), math.radians(175.0))))
    for name in ("printed", "gains of 5.1"):
        found[f"rest, {name}"] = Plan(calm, *HEALTHY[name])
    # The printed gains get stiff where g goes to zero; those of 5.1 are slow.
    found["starts, printed"] = Plan(sampled(starts, 0.002, 40.0), *HEALTHY["printed"], seed=2, craft=48)
    found["starts, gains of 5.1"] = Plan(sampled(starts, 0.05, 120.0), *HEALTHY["gains of 5.1"], seed=2, craft=48)
    for eta in HYSTERESES:
        found[f"eta = {eta}"] = Plan(healthy.replace(duration=20.0), "hsfc", {**PRINTED_HEALTHY, "hysteresis": eta})
    for pace in PACES:
        paced = faulty.replace(disturbance=_paced(faulty, pace))
        found[f"disturbance {pace:g} times as fast"] = Plan(paced, *FAULTY["without u2"])
    for value in SMOOTHINGS:
        gains = {"smallest_effectiveness": 1.0, "smoothing": value}
        found[f"delta = {value}"] = Plan(healthy.replace(disturbance=None), "hsfc", gains)
    for step in STEPS:
        found[f"step: {step} s"] = Plan(sampled(healthy, step, 20.0), *HEALTHY["printed"])
    for name in HELD:
        for period in PERIODS:
            found[f"hold: {name}, {period} s"] = Plan(sampled(faulty, period, 20.0), *FAULTY[name])
    return found


def _paced(scenario: Scenario, pace: float) -> Disturbance:
    """Return the disturbance of a scenario, so many times as fast."""
    disturbance = scenario.disturbance
    assert isinstance(disturbance, Disturbance)
    return replace(
        disturbance,
        harmonics=tuple(
            replace(harmonic, frequency=pace * harmonic.frequency)  # type: ignore[operator]
            for harmonic in disturbance.harmonics
        ),
    )
