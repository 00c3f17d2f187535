"""The flights that the claims of Li, Xu and Chang 2023 ask for."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from typing import Any

from ftac_gym import baselines, scenarios
from ftac_gym.faults import FaultSchedule, LossOfEffectiveness
from ftac_gym.reproduction.flight import Plan
from ftac_gym.reproduction.variations import sampled
from ftac_gym.scenarios.li_2023 import START
from ftac_gym.task.initial_state import InitialState
from ftac_gym.task.scenario import Scenario
from ftac_gym.task.sensors import SensorErrors

LAWS = {
    "FASMC": "fuzzy_smc",
    "PD": "fuzzy_pd",
    "PD gyroscopic": "fuzzy_pd_gyroscopic",
    "AISMC": "aismc",
    "RAFTSMC-class": "raftsmc_class",
}
"""The paper's scheme, its comparators, and PD in both readings."""

SCHEMES = tuple(LAWS)

OTHERS: dict[str, tuple[str, dict[str, Any]]] = {
    "FASMC solved": ("fuzzy_smc_solved", {"short_way": False}),
    "FASMC with ILO-class": ("fuzzy_smc_ilo_class", {}),
    "FASMC without observer": ("fuzzy_smc", {"faults": "none", "observer": None}),
    "pd_dob": ("pd_dob", {}),
    "pd_shaped": ("pd_shaped", {"rate_limit": 0.1}),
}
"""What is flown beside them."""

PERIODS = (0.02, 0.05, 0.1, 0.2, 0.5, 1.0)
INTEGRATIONS: dict[str, dict[str, Any]] = {
    "RK4, interpolated": {},
    "RK4, held": {"interpolate": False},
    "Euler": {"method": "euler", "longest_step": 10.0},
}
NOISES = (1e-6, 1e-5, 1e-4)
BOUNDS = (2.0, 20.0)
FAST = 0.5
"""Rate about each axis of a start within the sector of the fuzzy model, which ends at 0.7 [rad/s]."""


def printed() -> Scenario:
    """Return the example with the reading of its start that has a first manoeuvre."""
    return scenarios.get("li_2023")


def _observed(**changes: Any) -> dict[str, Any]:
    """Return gains of ``fuzzy_smc`` with other ones of its observer."""
    return {"observer": {**baselines.defaults("fuzzy_smc")["observer"], **changes}}


def plans() -> dict[str, Plan]:
    """Return every flight that the claims and the studies need, by name."""
    paper, weak = printed(), scenarios.get("li_2023_weak")
    healthy, start = paper.replace(faults=None), scenarios.get("li_2023_printed_start")
    found = {name: Plan(paper, law) for name, law in LAWS.items()}
    found.update({name: Plan(paper, law, gains) for name, (law, gains) in OTHERS.items()})
    found.update({f"{name}, sum": Plan(paper, law, {"limit": "sum"}) for name, law in LAWS.items()})
    found.update({f"{name}, printed start": Plan(start, law) for name, law in LAWS.items()})
    found.update({f"{name}, healthy": Plan(healthy, law) for name, law in LAWS.items()})
    found["FASMC, weak"] = Plan(weak, "fuzzy_smc")
    found["FASMC with ILO-class, weak"] = Plan(weak, "fuzzy_smc_ilo_class")
    found["FASMC, aligned"] = Plan(paper.replace(misalignment=None), "fuzzy_smc")
    found["FASMC, undisturbed"] = Plan(paper.replace(misalignment=None, disturbance=None), "fuzzy_smc")
    found["FASMC, mean gains"] = Plan(paper, "fuzzy_smc", {"scheduled": False, **_observed(scheduled=False)})
    short = healthy.replace(duration=80.0)
    found["FASMC, q"] = Plan(short, "fuzzy_smc")
    found["FASMC, -q"] = Plan(short, "fuzzy_smc", flipped=True)
    found["FASMC, -q, short way"] = Plan(short, "fuzzy_smc", {"short_way": True}, flipped=True)
    fast = healthy.replace(initial_state=InitialState.fixed(START, rate=(FAST, FAST, FAST)))
    found.update({f"{name}, fast start": Plan(fast, law) for name, law in LAWS.items()})
    found["FASMC, from zero"] = Plan(paper, "fuzzy_smc", _observed(start="zero"))
    found["FASMC, from zero, bounded"] = Plan(paper, "fuzzy_smc", _observed(start="zero", vibration_bound=0.2))
    found["FASMC, bounded"] = Plan(paper, "fuzzy_smc", _observed(vibration_bound=0.2))
    return {**found, **_halves(paper), **_samplings(paper), **_noisy(paper)}


def _halves(paper: Scenario) -> dict[str, Plan]:
    """Return flights with half of the effectiveness on top, for two bounds on the fault."""
    assert isinstance(paper.faults, FaultSchedule)
    lost = tuple(LossOfEffectiveness(wheel=wheel, onset=40.0, effectiveness=0.5) for wheel in range(3))
    half = paper.replace(faults=replace(paper.faults, faults=(*paper.faults.faults, *lost)))
    return {f"FASMC, half, {bound:g} N m": Plan(half, "fuzzy_smc", _observed(torque_bound=bound)) for bound in BOUNDS}


def _samplings(paper: Scenario) -> dict[str, Plan]:
    """Return flights at all periods, for each way of integrating the observer."""
    return {
        f"{name}, {period:g} s": Plan(sampled(paper, period, 200.0), "fuzzy_smc", _observed(**changes))
        for (name, changes), period in product(INTEGRATIONS.items(), PERIODS)
        if name != "Euler" or period <= 0.1  # beyond, its numbers overflow
    }


def _noisy(paper: Scenario) -> dict[str, Plan]:
    return {
        f"FASMC, noise {noise:g}": Plan(paper.replace(sensors=SensorErrors(rate_noise=noise)), "fuzzy_smc")
        for noise in NOISES
    }
