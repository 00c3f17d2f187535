"""The flights that the claims of Cao, Gong and Han 2022 ask for."""

from __future__ import annotations

from dataclasses import replace

from ftac_gym import scenarios
from ftac_gym.faults import FaultSchedule
from ftac_gym.reproduction.flight import Plan
from ftac_gym.reproduction.variations import UNLIMITED, sampled, with_limit
from ftac_gym.task.initial_state import InitialState
from ftac_gym.task.references import MRPSinusoid

EXPONENTS = (0.5, 0.3, 0.25, 0.2)
TIMES = (5.0, 10.0, 20.0)
PERIODS = (0.001, 0.01, 0.05, 0.1, 0.2)
OBSERVERS = {"LO as printed": "lo", "LO corrected": "lo_corrected", "ASMO": "asmo"}


def plans() -> dict[str, Plan]:
    """Return every flight that the claims and the studies need, by name."""
    paper = scenarios.get("cao_2022")
    calm = paper.replace(faults=None, disturbance=None)
    free = with_limit(calm, UNLIMITED)
    turning = paper.replace(
        reference=MRPSinusoid(amplitude=(0.2, 0.2, 0.2), frequency=(0.5, 0.4, 0.3), phase=(0.0, 1.0, 2.0))
    )
    struck = paper.replace(
        faults=FaultSchedule(
            tuple(replace(fault, onset=0.5) for fault in paper.faults.faults)  # type: ignore[union-attr]
        )
    )
    found = {
        "PTC as printed": Plan(paper, "ptc_printed"),
        "PTC h1 = 0.5, E^ = I": Plan(paper, "ptc_no_observer", {"position_exponent": 0.5}),
        "PTC h1 = 0.5, regularised": Plan(paper, "ptc_regularised"),
        "PTC": Plan(paper, "ptc"),
        "PTC, E^ = I": Plan(paper, "ptc_no_observer"),
        "PTC, oracle": Plan(paper, "ptc_oracle"),
        "PTC, LO as printed": Plan(paper, "ptc", {"faults": "lo"}),
        "PTC, ASMO": Plan(paper, "ptc", {"faults": "asmo"}),
        "PTC, sign as acceleration": Plan(paper, "ptc", {"switching_form": "acceleration", "switching_gain": 0.1}),
        "PTC, layer 0.05": Plan(paper, "ptc", {"layer": 0.05}),
        "PTC, 5 N m": Plan(with_limit(paper, 5.0), "ptc_no_observer"),
        "PTC, unlimited": Plan(with_limit(paper, UNLIMITED), "ptc_no_observer"),
        "PTC h1 = 0.5, 5 N m": Plan(with_limit(paper, 5.0), "ptc_no_observer", {"position_exponent": 0.5}),
        "PTC, struck in the slew": Plan(struck, "ptc"),
        "PTC, struck in the slew, E^ = I": Plan(struck, "ptc_no_observer"),
        "PTC, struck in the slew, oracle": Plan(struck, "ptc_oracle"),
        "TSMC-class": Plan(paper, "tsmc_class"),
        "TSMC-class, struck in the slew": Plan(struck, "tsmc_class"),
        "starts, unlimited": Plan(
            free.replace(initial_state=InitialState(max_rate=0.2), duration=25.0), "ptc_no_observer", seed=1, craft=64
        ),
    }
    for limit in (5.0, 1.0):
        weak = with_limit(calm, limit).replace(initial_state=InitialState(max_rate=0.2))
        found[f"starts, {limit:g} N m"] = Plan(weak, "ptc_no_observer", seed=1, craft=64)
    found["turning, E^ = I"] = Plan(turning, "ptc_no_observer", {"layer": 0.05})
    found["turning, oracle"] = Plan(turning, "ptc_oracle", {"layer": 0.05})
    for label, observer in OBSERVERS.items():
        # Disturbance as printed; the reference moves, so that there is torque to learn from.
        found[f"turning, {label}"] = Plan(turning, "ptc", {"faults": observer, "layer": 0.05})
    for time in TIMES:
        gains = {"position_time": time, "rate_time": time, "switching_gain": 0.0}
        found[f"T1 = T2 = {time:g} s"] = Plan(sampled(free, 0.001, 0.7 * time), "ptc_no_observer", gains)
    for exponent in EXPONENTS:
        for limit in (UNLIMITED, 5.0):
            for period in (0.01, 0.001):
                flown = sampled(with_limit(calm, limit), period, 15.0)
                name = f"step: h1 = {exponent}, {limit_name(limit)}, {period} s"
                found[name] = Plan(flown, "ptc_no_observer", {"position_exponent": exponent})
    for period in PERIODS:
        for limit in (UNLIMITED, 5.0):
            for layer in (0.0, 0.1):
                flown = sampled(with_limit(paper, limit), period, 25.0)
                found[f"hold: {period} s, {limit_name(limit)}, {layer}"] = Plan(
                    flown, "ptc_no_observer", {"layer": layer}
                )
    return found


def limit_name(limit: float) -> str:
    """Return a torque limit [N m] in words."""
    return "unlimited" if limit == UNLIMITED else f"{limit:g} N m"
