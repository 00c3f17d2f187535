"""Flights for the claims of Cao, Gong and Han 2022."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

from ftac_gym import scenarios
from ftac_gym.faults import FaultSchedule
from ftac_gym.reproduction.recordings import Plan
from ftac_gym.reproduction.variations import UNLIMITED, sampled, with_limit
from ftac_gym.task.initial_state import InitialState
from ftac_gym.task.references import MRPSinusoid

EXPONENTS = (0.5, 0.3, 0.25, 0.2)
TIMES = (5.0, 10.0, 20.0)
STEPS = (0.01, 0.001)
PERIODS = (0.001, 0.01, 0.05, 0.1, 0.2)
LIMITS = {"unlimited": UNLIMITED, "5 N m": 5.0}
LAYERS = {"sign": 0.0, "layer 0.1": 0.1}
OBSERVERS = {"LO as printed": "lo", "LO corrected": "lo_corrected", "ASMO": "asmo"}


def plans() -> dict[str, Plan]:
    """Return every flight that the claims and the studies need, by name."""
    paper = scenarios.get("cao_2022")
    assert isinstance(paper.faults, FaultSchedule)
    calm = paper.replace(faults=None, disturbance=None)
    free = with_limit(calm, UNLIMITED)
    # The reference moves, so that the torque stays large enough to estimate an effectiveness from it.
    turning = paper.replace(
        reference=MRPSinusoid(amplitude=(0.2, 0.2, 0.2), frequency=(0.5, 0.4, 0.3), phase=(0.0, 1.0, 2.0))
    )
    early = paper.replace(faults=FaultSchedule(tuple(replace(fault, onset=0.5) for fault in paper.faults.faults)))
    start = InitialState(max_rate=0.2)
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
        "PTC, faults in the slew": Plan(early, "ptc"),
        "PTC, faults in the slew, E^ = I": Plan(early, "ptc_no_observer"),
        "PTC, faults in the slew, oracle": Plan(early, "ptc_oracle"),
        "TSMC-class": Plan(paper, "tsmc_class"),
        "TSMC-class, faults in the slew": Plan(early, "tsmc_class"),
        "turning, E^ = I": Plan(turning, "ptc_no_observer", {"layer": 0.05}),
        "turning, oracle": Plan(turning, "ptc_oracle", {"layer": 0.05}),
    }
    for label, observer in OBSERVERS.items():
        found[f"turning, {label}"] = Plan(turning, "ptc", {"faults": observer, "layer": 0.05})
    for name, limit, duration in (("unlimited", UNLIMITED, 25.0), ("5 N m", 5.0, 40.0), ("1 N m", 1.0, 40.0)):
        random = with_limit(calm, limit).replace(initial_state=start, duration=duration)
        found[f"starts, {name}"] = Plan(random, "ptc_no_observer", seed=1, num_spacecraft=64)
    for time in TIMES:
        gains = {"position_time": time, "rate_time": time, "switching_gain": 0.0}
        found[f"T1 = T2 = {time:g} s"] = Plan(sampled(free, 0.001, 0.7 * time), "ptc_no_observer", gains)
    for exponent, (name, limit), step in product(EXPONENTS, LIMITS.items(), STEPS):
        fine = sampled(with_limit(calm, limit), step, 15.0)
        found[f"step: h1 = {exponent}, {name}, {step} s"] = Plan(
            fine, "ptc_no_observer", {"position_exponent": exponent}
        )
    for period, (name, limit), (label, layer) in product(PERIODS, LIMITS.items(), LAYERS.items()):
        held = sampled(with_limit(paper, limit), period, 25.0)
        found[f"hold: {period} s, {name}, {label}"] = Plan(held, "ptc_no_observer", {"layer": layer})
    return found
