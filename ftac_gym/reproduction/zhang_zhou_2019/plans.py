"""Flights for the claims of Zhang and Zhou 2019."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product
from typing import Any

from ftac_gym import scenarios
from ftac_gym.faults import FaultSchedule, Outage
from ftac_gym.reproduction.recordings import Plan
from ftac_gym.reproduction.variations import UNLIMITED, sampled, with_limit
from ftac_gym.task.initial_state import InitialState

PERIODS = (0.001, 0.01, 0.05, 0.1, 0.2)
LAYERS = (0.0, 0.05, 0.2)
TRACKING, STABILISATION = "zhang_zhou_tracking", "zhang_zhou_stabilisation"
CONSTANT: Mapping[str, Any] = {"layer": 0.0, "reaching_switching": 3.0, "reaching_steepness": 0.0}
"""Largest gain of the exponential reaching law, at every distance."""
AUXILIARY: Mapping[str, Any] = {"anti_saturation": {}}
AS_PRINTED: Mapping[str, Any] = {"layer": 0.0, "faults": "asmo_printed", "anti_saturation": {}}
SCALED: Mapping[str, Any] = {"gain": 1000.0, "surface_gain": 0.8}
"""Gains of the Shen-class law for this body and these wheels: published ones are for 0.2 N m and a lighter body."""
SAMPLED = {"stabilisation": 30.0, "tracking": 45.0}
"""Duration of the sampling studies [s]: the transient of the faults at 10 s has decayed by then."""


def plans() -> dict[str, Plan]:
    """Return every flight that the claims and the studies need, by name."""
    printed = scenarios.get("zhang_zhou_2019")
    feasible = scenarios.get("zhang_zhou_2019_feasible")
    rest = scenarios.get("zhang_zhou_2019_stabilisation")
    starts = rest.replace(initial_state=InitialState(max_rate=0.5), duration=40.0)
    found = {
        "as printed, 5 N m": Plan(printed, TRACKING, AS_PRINTED),
        "as printed, 2 N m": Plan(scenarios.get("zhang_zhou_2019_2nm"), TRACKING, AS_PRINTED),
        "printed, 5 N m": Plan(printed, TRACKING),
        "printed, 2 N m": Plan(scenarios.get("zhang_zhou_2019_2nm"), TRACKING),
        "printed, unlimited": Plan(with_limit(printed, UNLIMITED), TRACKING),
        "printed, unlimited, sign": Plan(with_limit(printed, UNLIMITED), TRACKING, {"layer": 0.0}),
        "printed, Shen-class": Plan(printed, "shen_class"),
        "tracking": Plan(feasible, TRACKING),
        "tracking, sign": Plan(feasible, TRACKING, {"layer": 0.0}),
        "tracking, healthy": Plan(feasible.replace(faults=None), TRACKING),
        "tracking, no observer": Plan(feasible, f"{TRACKING}_no_observer"),
        "tracking, oracle": Plan(feasible, f"{TRACKING}_oracle"),
        "tracking, printed observer": Plan(feasible, TRACKING, {"faults": "asmo_printed"}),
        "tracking, no network": Plan(feasible, TRACKING, {"network_gain": 0.0}),
        "tracking, auxiliary": Plan(feasible, TRACKING, AUXILIARY),
        "tracking, 2 N m": Plan(with_limit(feasible, 2.0), TRACKING),
        "tracking, 2 N m, auxiliary": Plan(with_limit(feasible, 2.0), TRACKING, AUXILIARY),
        "tracking, unlimited": Plan(with_limit(feasible, UNLIMITED), TRACKING),
        "tracking, unlimited, sign": Plan(with_limit(feasible, UNLIMITED), TRACKING, {"layer": 0.0}),
        "tracking, unlimited, constant gain": Plan(with_limit(feasible, UNLIMITED), TRACKING, CONSTANT),
        "tracking, constant gain": Plan(feasible, TRACKING, CONSTANT),
        "tracking, dead wheel": Plan(feasible.replace(faults=FaultSchedule((Outage(wheel=0, onset=10.0),))), TRACKING),
        "tracking, undisturbed": Plan(feasible.replace(disturbance=None, inertia_uncertainty=None), TRACKING),
        "Shen-class": Plan(feasible, "shen_class"),
        "Shen-class, healthy": Plan(feasible.replace(faults=None), "shen_class"),
        "Shen-class, scaled": Plan(feasible, "shen_class", SCALED),
        "Shen-class, scaled, healthy": Plan(feasible.replace(faults=None), "shen_class", SCALED),
        "Shen-class, scaled, at rest": Plan(rest, "shen_class", SCALED),
        "stabilisation": Plan(rest, STABILISATION),
        "stabilisation, sign": Plan(rest, STABILISATION, {"layer": 0.0}),
        "stabilisation, no observer": Plan(rest, f"{STABILISATION}_no_observer"),
        "stabilisation, oracle": Plan(rest, f"{STABILISATION}_oracle"),
        "stabilisation, 2 N m": Plan(with_limit(rest, 2.0), STABILISATION),
        "stabilisation, unlimited": Plan(with_limit(rest, UNLIMITED), STABILISATION),
        "stabilisation, undisturbed": Plan(rest.replace(disturbance=None, inertia_uncertainty=None), STABILISATION),
        "random starts": Plan(starts, STABILISATION, seed=1, num_spacecraft=64),
        "auxiliary, 10 ms": Plan(sampled(rest, 0.01, 25.0), STABILISATION, AUXILIARY),
        "auxiliary, 1 ms": Plan(sampled(rest, 0.001, 25.0), STABILISATION, AUXILIARY),
        "auxiliary, fine": Plan(sampled(rest, 0.01, 25.0), STABILISATION, {"anti_saturation": {"substeps": 1000}}),
    }  # fmt: skip
    for name, scenario, baseline in (("stabilisation", rest, STABILISATION), ("tracking", feasible, TRACKING)):
        for period, layer in product(PERIODS, LAYERS):
            # The widest layer hides the effect of the step: at the smallest step it is left out.
            if (period, layer) != (PERIODS[0], LAYERS[-1]):
                held = sampled(scenario, period, SAMPLED[name])
                found[f"{name}, {period} s, layer {layer}"] = Plan(held, baseline, {"layer": layer})
    return found
