"""Flights for the claims of Chen, Chen, He and Sun 2018."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np

from ftac_gym import scenarios
from ftac_gym.attitude import quaternion_from_mrp
from ftac_gym.baselines.controllers.prescribed_performance import PrescribedPerformance
from ftac_gym.baselines.units import Scales, relative
from ftac_gym.reproduction.recordings import Plan
from ftac_gym.reproduction.variations import sampled, with_limit
from ftac_gym.task.initial_state import InitialState
from ftac_gym.task.prescribed_bound import PrescribedBound
from ftac_gym.task.scenario import Scenario

SCHEMES = {"M1": "chen_m1", "M2": "chen_m2", "M3": "chen_m3", "M3 scaled": "chen_m3_scaled"}
COMPARATORS = ("M2", "M3", "M3 scaled")
LIMITS = (7.5, 7.0, 6.0, 5.0, 4.0)
FACTORS = (1.05, 1.2, 1.3, 2.0, 5.0, 10.0, 20.0, 100.0)
FILTER_STARTS = {"filter starts at zero": "zero", "filter starts at the virtual control": "virtual"}
DECAYS = (0.15, 0.2, 0.5)
ANGLES = (30.0, 90.0, 150.0, 175.0)
STEPS = (0.005, 0.002, 0.001, 0.0005)
PERIODS = (0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2)
FUZZY: dict[str, dict[str, float]] = {
    "lambda = 0": {"fuzzy_gain": 0.0},
    # P'P and 1 / h^2 enter as a product only.
    "P'P / 10": {"fuzzy_width": 0.5 * 10.0**0.5},
    "7 P'P": {"fuzzy_width": 0.5 / 7.0**0.5},
}
WIDE: dict[str, Any] = {"initial": 1.5, "decay": 0.04}
"""Changes to the bound for which the torque suffices."""

SYMMETRIC = {"lower": (1.0, 1.0, 1.0), "upper": (1.0, 1.0, 1.0)}
"""Changes to the bounds that put their middle at the reference."""

HELD: dict[str, tuple[str, dict[str, Any]]] = {
    "M1": ("chen_m1", {}),
    "M1, 10 sub-steps": ("chen_m1", {"filter_substeps": 10}),
    "M1, no filter": ("chen_m1", {"filter_substeps": 0}),
    "M1 sampled": ("chen_m1_sampled", {}),
    "M2": ("chen_m2", {}),
    "M3 scaled": ("chen_m3_scaled", {}),
    "prescribed performance": ("prescribed_performance", {}),
}
"""Baselines of the sampling study, with their gains."""

START = np.array([-0.3, -0.4, 0.2])
"""MRPs at the start of the example."""

SIGNS = {"".join("+" if sign > 0.0 else "-" for sign in signs): signs for signs in product((1.0, -1.0), repeat=3)}
"""Signs of a start in units of the example's, by name."""

WAYS = {"short": (False, False), "long": (False, True), "long, switched": (True, True)}
"""Use of the shadow switch, and the sign of the quaternion at the start: whether it is flipped."""


def bound() -> PrescribedBound:
    """Return the bounds of the example."""
    found = scenarios.get("chen_2018").prescribed_bound
    assert found is not None
    return found


def plans() -> dict[str, Plan]:
    """Return every flight that the claims and the studies need, by name."""
    paper, rocking = scenarios.get("chen_2018"), scenarios.get("chen_2018_rate_torque")
    healthy = paper.replace(faults=None)
    found = {name: Plan(paper, baseline) for name, baseline in SCHEMES.items()}
    found["M1"] = replace(found["M1"], recorded=("weight_bound",))
    found.update({f"{name}, healthy": Plan(healthy, baseline) for name, baseline in SCHEMES.items()})
    found.update({f"M1, {limit:g} N m": Plan(with_limit(paper, limit), "chen_m1") for limit in LIMITS})
    found["M1, -J' w"] = Plan(rocking, "chen_m1")
    found["M1, -J' w, 1 ms"] = Plan(sampled(rocking, 0.001, 6.0), "chen_m1")
    found["M1, wide bounds"] = Plan(paper, "chen_m1", {"bound": WIDE})
    found["M1, wide bounds, 4 N m"] = Plan(with_limit(paper, 4.0), "chen_m1", {"bound": WIDE})
    found["M1, lower = upper = 1"] = Plan(paper, "chen_m1", {"bound": SYMMETRIC})
    found.update({f"M1, {name}": Plan(paper, "chen_m1", gains) for name, gains in FUZZY.items()})
    for decay in DECAYS:
        found[f"M1, kappa = {decay:g}"] = Plan(paper.replace(duration=40.0), "chen_m1", {"bound": {"decay": decay}})
    for name, signs in SIGNS.items():
        attitude = quaternion_from_mrp(START * np.array(signs)).tolist()
        start = paper.replace(initial_state=InitialState.fixed(attitude=attitude), duration=6.0)
        found[f"start {name}"] = Plan(start, "chen_m1")
        found[f"start {name}, mirrored"] = Plan(start, "chen_m1", {"mirror": True})
    short = paper.replace(duration=5.0)
    for factor, where in product(FACTORS, FILTER_STARTS.values()):
        gains = {"bound": {"initial_factor": factor}, "filter_start": where}
        found[f"delta(0) = {factor:g}, {where}"] = Plan(short, "chen_m1", gains)
    found.update({f"step {step:g} s": Plan(sampled(paper, step, 10.0), "chen_m1") for step in STEPS})
    return {**found, **_holds(paper), **_turns(healthy)}


def _holds(paper: Scenario) -> dict[str, Plan]:
    """Return flights at all periods except the example's own; the finest end soon after the least margin."""
    found = {}
    for (name, (baseline, gains)), period in product(HELD.items(), PERIODS):
        flown = period == paper.control_period and name in SCHEMES
        if not flown and (period >= 0.005 or name.startswith("M1")):
            duration = 60.0 if period >= 0.005 else 6.0
            found[f"hold {period:g} s, {name}"] = _held(sampled(paper, period, duration), baseline, gains)
    return found


def _held(scenario: Scenario, baseline: str, gains: dict[str, Any]) -> Plan:
    """Return a flight of the sampling study; gains in units of the scenario have the same SI values at all periods."""
    if baseline == "prescribed_performance":
        scales = Scales.of(scenario)
        values = {"attitude_gain": 0.05, "rate_gain": 2.0, "rate_power_gain": 1e-3 * scales.speed**0.3}
        gains = relative(PrescribedPerformance.gains, scales, values)
    return Plan(scenario, baseline, gains)


def _turns(healthy: Scenario) -> dict[str, Plan]:
    """Return slews about random axes from either sign of the quaternion, with and without the shadow switch."""
    found = {}
    calm = sampled(healthy.replace(disturbance=None), 0.05, 60.0)
    for name, angle, (way, (switch, flipped)) in product(COMPARATORS, ANGLES, WAYS.items()):
        slew = calm.replace(initial_state=InitialState(angle=float(np.radians(angle))))
        found[f"turn {angle:g} deg, {name}, {way}"] = Plan(
            slew, SCHEMES[name], {"shadow_switch": switch}, num_spacecraft=8, flipped=flipped
        )
    return found
