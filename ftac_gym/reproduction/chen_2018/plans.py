"""The flights that the claims of Chen, Chen, He and Sun 2018 ask for."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np

from ftac_gym import scenarios
from ftac_gym.attitude import quaternion_from_mrp
from ftac_gym.reproduction.flight import Plan
from ftac_gym.reproduction.variations import sampled, with_limit
from ftac_gym.task.initial_state import InitialState
from ftac_gym.task.prescribed_bound import PrescribedBound
from ftac_gym.task.scenario import Scenario

SCHEMES = ("M1", "M2", "M3", "M3 scaled")
LAWS = {"M1": "chen_m1", "M2": "chen_m2", "M3": "chen_m3", "M3 scaled": "chen_m3_scaled"}
LIMITS = (7.5, 7.0, 6.0, 5.0, 4.0)
FACTORS = (1.05, 1.2, 1.3, 2.0, 5.0, 10.0, 20.0, 100.0)
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
WIDE = {"initial": 1.5, "decay": 0.04}
"""A bound that the torque can meet."""

SYMMETRIC = {"lower": (1.0, 1.0, 1.0), "upper": (1.0, 1.0, 1.0)}
"""Bounds whose middle is the reference."""

HELD: dict[str, tuple[str, dict[str, Any]]] = {
    "M1": ("chen_m1", {}),
    "M1, 10 sub-steps": ("chen_m1", {"filter_substeps": 10}),
    "M1, no filter": ("chen_m1", {"filter_substeps": 0}),
    "M1 sampled": ("chen_m1_sampled", {}),
    "M2": ("chen_m2", {}),
    "M3 scaled": ("chen_m3_scaled", {}),
    "prescribed performance": ("prescribed_performance", {}),
}
"""Laws of the sampling study."""

SIGNS = tuple(product((1.0, -1.0), repeat=3))


def printed() -> Scenario:
    """Return the example as printed, but for what it leaves open."""
    return scenarios.get("chen_2018")


def bound() -> PrescribedBound:
    """Return the bounds of the example."""
    found = printed().prescribed_bound
    assert found is not None
    return found


def mirrored(signs: tuple[float, ...]) -> PrescribedBound:
    """Return the bounds exchanged on the axes whose start has the other sign than in the example."""
    return bound().mirrored(np.array(signs) < 0.0)


def start_name(signs: tuple[float, ...]) -> str:
    """Return the signs of a start, in units of the example's, in words."""
    return "".join("+" if sign > 0.0 else "-" for sign in signs)


def plans() -> dict[str, Plan]:
    """Return every flight that the claims and the studies need, by name."""
    paper = printed()
    healthy = paper.replace(faults=None)
    found = {name: Plan(paper, LAWS[name]) for name in SCHEMES}
    found["M1"] = replace(found["M1"], kept=("weight_bound",))
    found.update({f"{name}, healthy": Plan(healthy, LAWS[name]) for name in SCHEMES})
    found.update({f"M1, {limit:g} N m": Plan(with_limit(paper, limit), "chen_m1") for limit in LIMITS})
    rocking = scenarios.get("chen_2018_rate_torque")
    found["M1, -J' w"] = Plan(rocking, "chen_m1")
    found["M1, -J' w, 1 ms"] = Plan(sampled(rocking, 0.001, 6.0), "chen_m1")
    found["M1, wide bounds"] = Plan(paper, "chen_m1", {"bound": WIDE})
    found["M1, wide bounds, 4 N m"] = Plan(with_limit(paper, 4.0), "chen_m1", {"bound": WIDE})
    found["M1, lower = upper = 1"] = Plan(paper, "chen_m1", {"bound": SYMMETRIC})
    found.update({f"M1, {name}": Plan(paper, "chen_m1", gains) for name, gains in FUZZY.items()})
    for decay in DECAYS:
        found[f"M1, kappa = {decay:g}"] = Plan(paper.replace(duration=40.0), "chen_m1", {"bound": {"decay": decay}})
    return {**found, **_starts(paper), **_factors(paper), **_steps(paper), **_holds(paper), **_turns(healthy)}


def _starts(paper: Scenario) -> dict[str, Plan]:
    """Return starts with all signs, with the bounds as printed and mirrored to the start."""
    found, start = {}, np.array([-0.3, -0.4, 0.2])
    for signs in SIGNS:
        attitude = quaternion_from_mrp(start * np.array(signs)).tolist()
        there = paper.replace(initial_state=InitialState.fixed(attitude=attitude), duration=6.0)
        found[f"start {start_name(signs)}"] = Plan(there, "chen_m1")
        found[f"start {start_name(signs)}, mirrored"] = Plan(there, "chen_m1", {"mirror": True})
    return found


def _factors(paper: Scenario) -> dict[str, Plan]:
    short = paper.replace(duration=5.0)
    return {
        f"delta(0) = {factor:g}, {where}": Plan(
            short, "chen_m1", {"bound": {"initial_factor": factor}, "filter_start": where}
        )
        for factor in FACTORS
        for where in ("zero", "virtual")
    }


def _steps(paper: Scenario) -> dict[str, Plan]:
    return {f"step {step:g} s": Plan(sampled(paper, step, 10.0), "chen_m1") for step in STEPS}


def _holds(paper: Scenario) -> dict[str, Plan]:
    """Return flights at all periods but the example's own; the finest are over soon after the margin is least."""
    found = {}
    for (name, (law, gains)), period in product(HELD.items(), PERIODS):
        own = period == paper.control_period and name in LAWS
        if not own and (period >= 0.005 or name.startswith("M1")):
            short = 60.0 if period >= 0.005 else 6.0
            found[f"hold {period:g} s, {name}"] = Plan(sampled(paper, period, short), law, gains)
    return found


def _turns(healthy: Scenario) -> dict[str, Plan]:
    """Return slews about random axes from either sign of the quaternion, with and without the shadow switch."""
    found = {}
    calm = sampled(healthy.replace(disturbance=None), 0.05, 60.0)
    for name, angle in product(SCHEMES[1:], ANGLES):
        slew = calm.replace(initial_state=InitialState(angle=float(np.radians(angle))))
        for way, switch, flipped in (("short", False, False), ("long", False, True), ("long, switched", True, True)):
            found[f"turn {angle:g} deg, {name}, {way}"] = Plan(
                slew, LAWS[name], {"shadow_switch": switch}, craft=8, flipped=flipped
            )
    return found
