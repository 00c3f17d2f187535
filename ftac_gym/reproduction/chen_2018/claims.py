"""Claims of Chen, Chen, He and Sun 2018, judged by flights of their example; ``claims.toml`` holds their texts."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from ftac_gym.reproduction.chen_2018 import measures, plans
from ftac_gym.reproduction.chen_2018.measures import accurate, least, margin
from ftac_gym.reproduction.chen_2018.plans import COMPARATORS, FACTORS, SCHEMES, SIGNS, bound
from ftac_gym.reproduction.recordings import Recording, Recordings, below_from
from ftac_gym.reproduction.verdicts import Finding, Measure
from ftac_gym.reproduction.wording import listed, listed_times, percent, seconds, settled

EVEN = "M1, lower = upper = 1"
LEAK = 0.001
"""m1 [1/s]."""


MEASURES: dict[str, Measure] = {
    "margin": margin,
    "accurate": lambda recording: seconds(accurate(recording)),
    "accuracy": lambda recording: f"{settled(recording, 1.0)}, {recording.steady():.2f} deg",
}
"""Measures for the texts."""


def findings(flights: Recordings) -> dict[str, Finding]:
    """Return the findings for the claims of the abstract, of section 5 and of the conclusion."""
    return {**_bounds(flights), **_convergence(flights), **_comparisons(flights)}


def _kept_factors(flights: Recordings, where: str) -> list[float]:
    """Return the delta(0) with which M1 keeps its bounds, for a filter that starts at ``where``."""
    return [factor for factor in FACTORS if least(flights[f"delta(0) = {factor:g}, {where}"]) > 0.0]


def _numbers(values: Iterable[float]) -> str:
    return ", ".join(f"{value:g}" for value in values) or "none"


def _bounds(flights: Recordings) -> dict[str, Finding]:
    names = [f"{limit:g} N m" for limit in plans.LIMITS]
    names += ["-J' w", "-J' w, 1 ms", *(f"kappa = {decay:g}" for decay in plans.DECAYS)]
    weak = flights.chosen(names, "M1, {}").measured(least)
    wide, wide_bound = ("M1, wide bounds", "M1, wide bounds, 4 N m"), replace(bound(), **plans.WIDE)
    kept = flights.chosen((*wide, *COMPARATORS)).measured(lambda recording: least(recording, wide_bound))
    zero, virtual = (_kept_factors(flights, where) for where in ("zero", "virtual"))
    printed, mirrored = (
        sum(least(flight) > 0.0 for flight in flights.chosen(SIGNS, form).values())
        for form in ("start {}", "start {}, mirrored")
    )
    radius, finest = measures.theorem_radius(), flights["step 0.0005 s"]
    return {
        "bounds": Finding(False, least(flights["M1"]) > 0.0 and least(finest) > 0.0),
        "rival-bounds": Finding(least(flights["M2"]) < 0.0 and least(flights["M3"]) < 0.0),
        "guarantee": Finding(
            min(weak.values()) > 0.0, min(kept[name] for name in wide) > 0.0,
            weak=listed(weak, "{:+.2g}"), kept=listed(kept, "{:+.2g}"),
        ),
        "infinite": Finding(
            False, FACTORS[-1] in virtual, zero=_numbers(zero), factors=_numbers(FACTORS), virtual=_numbers(virtual),
        ),
        "start": Finding(printed == len(SIGNS), mirrored == len(SIGNS), printed=printed, mirrored=mirrored),
        "theorem-6": Finding(radius < 1.0, radius=radius, share=np.exp(-2.0 * radius)),
    }  # fmt: skip


def _convergence(flights: Recordings) -> dict[str, Finding]:
    own, even = flights["M1"], flights[EVEN]
    size, theta = measures.transformed(own), measures.weight_bound(own)
    near = {f"{limit:g}:": below_from(own.time, size, limit) for limit in (0.1, 0.05, 0.01)}
    late = flights.chosen(("M1", EVEN, "M2, healthy")).measured(
        lambda recording: (measures.shrinking(recording, 0.3, 0.4), measures.shrinking(recording, 0.8, 0.9))
    )
    across = flights.chosen((*SCHEMES, "M2, healthy")).measured(measures.overshoot)
    reached = flights.chosen((*SCHEMES, EVEN)).measured(accurate)
    low, high = bound().bound(own.time[-1])
    rest, middle = (", ".join(f"{value:.2e}" for value in part) for part in (own.attitude[-1, 0], 0.5 * (low + high)))
    off, off_even = (float(np.abs(flight.attitude[-1, 0]).max()) for flight in (own, even))
    window = round(10.0 / own.scenario.control_period)
    fall, leaked = float(1.0 - theta[-1] / theta[-1 - window]), float(-np.expm1(-10.0 * LEAK))
    return {
        "transformed": Finding(all(30.0 <= time <= 50.0 for time in near.values()), near=listed_times(near)),
        "overshoot": Finding(across["M1"] == 0.0, across["M1"] < 1e-3, across=listed(across, "{:.1e}")),
        "accuracy": Finding(*(reached[name] < np.inf for name in ("M1", EVEN)), reached=listed_times(reached)),
        "origin": Finding(off < 1e-5, off_even < 1e-5, rest=rest, middle=middle, even=off_even),
        "finite-time": Finding(
            *(late[name][1] > 1.5 * late[name][0] for name in ("M1", EVEN)), late=listed(late, "{:.3f} and {:.3f}"),
        ),
        "theta": Finding(
            abs(fall) < 0.5 * leaked, abs(fall) < 0.02,
            largest=theta.max(), time=own.time[int(np.argmax(theta))], fall=percent(fall, 2), leaked=percent(leaked, 2),
        ),
    }  # fmt: skip


def _comparisons(flights: Recordings) -> dict[str, Finding]:
    schemes, own = flights.chosen(SCHEMES), flights["M1"]
    plain, without = flights["hold 0.005 s, M1, no filter"], flights["M1, lambda = 0"]
    steady, peak = schemes.measured(Recording.steady), schemes.measured(lambda flight: float(flight.speed().max()))
    calm = schemes.measured(lambda flight: below_from(flight.time, flight.speed(), 0.1))
    turned = schemes.measured(lambda flight: float(flight.path_ratio()[0]))
    best = [min(values, key=values.__getitem__) == "M1" for values in (peak, calm, turned)]
    sampled = Recordings({**schemes, "M1 sampled": flights["hold 0.005 s, M1 sampled"]})
    torques = sampled.measured(lambda flight: (measures.torque_size(flight), flight.chatter()))

    def similar(*names: str) -> bool:
        sizes, variations = zip(*(torques[name] for name in names), strict=True)
        return bool(max(sizes) < 1.5 * min(sizes) and max(variations) < 3.0 * min(variations))

    def faster(flight: Recording) -> bool:
        others = flights["M2"], flights["M3 scaled"]
        sooner = all(flight.settling(1.0) < other.settling(1.0) for other in others)
        return sooner and all(flight.steady() < other.steady() for other in others)

    worse = accurate(own) < 0.9 * accurate(without) or (least(own) > 0.0 >= least(without))
    spared = least(own) > 0.0 and not (least(plain) > 0.0 and np.isfinite(plain.settling(1.0)))
    return {
        "all-stabilise": Finding(
            *(max(steady["M1"], steady["M2"], steady[name]) < 2.0 for name in ("M3", "M3 scaled"))
        ),
        "rates": Finding(
            all(best), best[1] and best[2],
            calm=listed_times(calm), turned=listed(turned, "{:.2f}"), peak=listed(peak, "{:.1f} deg/s"),
        ),
        "torques": Finding(
            similar("M1", "M2", "M3"), similar("M1 sampled", "M2", "M3 scaled"),
            torques=listed(torques, "{:.2f} N m, {:.1f} N m/s"),
        ),
        "faster": Finding(faster(own), faster(flights[EVEN])),
        "tolerance": Finding(bool(np.isfinite(accurate(own)))),
        "fuzzy": Finding(worse),
        "filter": Finding(spared),
    }  # fmt: skip
