"""Flights for the claims of Li, Xu and Chang 2023."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from typing import Any

from ftac_gym import baselines, scenarios
from ftac_gym.baselines.controllers.pd import PDDisturbanceObserver
from ftac_gym.baselines.units import Scales, relative
from ftac_gym.faults import FaultSchedule, LossOfEffectiveness
from ftac_gym.reproduction.recordings import Plan
from ftac_gym.reproduction.variations import sampled
from ftac_gym.scenarios.li_2023 import START
from ftac_gym.task.initial_state import InitialState
from ftac_gym.task.sensors import SensorErrors

SCHEMES = {
    "FASMC": "fuzzy_smc",
    "PD": "fuzzy_pd",
    "PD gyroscopic": "fuzzy_pd_gyroscopic",
    "AISMC": "aismc",
    "RAFTSMC-class": "raftsmc_class",
}
"""The paper's scheme, its comparators, and PD in both readings, with their baselines."""


def _in_units(rate_limit: float) -> dict[str, float]:
    """Return the gains of ``pd_dob`` on the flagship, for this example, with a rate limit [rad/s]."""
    values = {"rate_limit": rate_limit, "rate_gain": 6.162, "position_gain": 2.484, "bandwidth": 0.3897}
    return relative(PDDisturbanceObserver.gains, Scales.of(scenarios.get("li_2023")), values)


OTHERS: dict[str, tuple[str, dict[str, Any]]] = {
    "FASMC solved": ("fuzzy_smc_solved", {"short_way": False}),
    "FASMC with ILO-class": ("fuzzy_smc_ilo_class", {}),
    "FASMC without observer": ("fuzzy_smc", {"faults": "none", "observer": None}),
    "pd_dob": ("pd_dob", _in_units(0.1743)),
    "pd_shaped": ("pd_shaped", _in_units(0.1)),
}
"""Further baselines in the same example, with their gains."""

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


def _observed(**changes: Any) -> dict[str, Any]:
    """Return gains of ``fuzzy_smc`` with changes to those of its observer."""
    return {"observer": {**baselines.defaults("fuzzy_smc")["observer"], **changes}}


def plans() -> dict[str, Plan]:
    """Return every flight that the claims and the studies need, by name."""
    paper, weak = scenarios.get("li_2023"), scenarios.get("li_2023_weak")
    healthy, start = paper.replace(faults=None), scenarios.get("li_2023_printed_start")
    fast = healthy.replace(initial_state=InitialState.fixed(START, rate=(FAST, FAST, FAST)))
    short, aligned = healthy.replace(duration=80.0), paper.replace(misalignment=None)
    found = {name: Plan(paper, baseline) for name, baseline in SCHEMES.items()}
    found.update({name: Plan(paper, baseline, gains) for name, (baseline, gains) in OTHERS.items()})
    for name, baseline in SCHEMES.items():
        found[f"{name}, sum"] = Plan(paper, baseline, {"limit": "sum"})
        found[f"{name}, printed start"] = Plan(start, baseline)
        found[f"{name}, healthy"] = Plan(healthy, baseline)
        found[f"{name}, fast start"] = Plan(fast, baseline)
    found["FASMC, weak"] = Plan(weak, "fuzzy_smc")
    found["FASMC with ILO-class, weak"] = Plan(weak, "fuzzy_smc_ilo_class")
    found["FASMC, aligned"] = Plan(aligned, "fuzzy_smc")
    found["FASMC, undisturbed"] = Plan(aligned.replace(disturbance=None), "fuzzy_smc")
    found["FASMC, mean gains"] = Plan(paper, "fuzzy_smc", {"scheduled": False, **_observed(scheduled=False)})
    found["FASMC, q"] = Plan(short, "fuzzy_smc")
    found["FASMC, -q"] = Plan(short, "fuzzy_smc", flipped=True)
    found["FASMC, -q, short way"] = Plan(short, "fuzzy_smc", {"short_way": True}, flipped=True)
    found["FASMC, from zero"] = Plan(paper, "fuzzy_smc", _observed(start="zero"))
    found["FASMC, from zero, bounded"] = Plan(paper, "fuzzy_smc", _observed(start="zero", vibration_bound=0.2))
    found["FASMC, bounded"] = Plan(paper, "fuzzy_smc", _observed(vibration_bound=0.2))
    # Half of the effectiveness is lost in addition.
    assert isinstance(paper.faults, FaultSchedule)
    lost = tuple(LossOfEffectiveness(wheel=wheel, onset=40.0, effectiveness=0.5) for wheel in range(3))
    half = paper.replace(faults=replace(paper.faults, faults=(*paper.faults.faults, *lost)))
    for bound in BOUNDS:
        found[f"FASMC, half, {bound:g} N m"] = Plan(half, "fuzzy_smc", _observed(torque_bound=bound))
    for (name, changes), period in product(INTEGRATIONS.items(), PERIODS):
        if name != "Euler" or period <= 0.1:  # the numbers of the Euler method overflow at longer periods
            found[f"{name}, {period:g} s"] = Plan(sampled(paper, period, 200.0), "fuzzy_smc", _observed(**changes))
    for noise in NOISES:
        noisy = paper.replace(sensors=SensorErrors(rate_noise=noise))
        found[f"FASMC, noise {noise:g}"] = Plan(noisy, "fuzzy_smc")
    return found
