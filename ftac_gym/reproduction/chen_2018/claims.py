"""The claims of Chen, Chen, He and Sun 2018, and what their equations do in their example."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ftac_gym.reproduction.chen_2018.measures import (
    accurate,
    changed,
    least,
    margin,
    overshoot,
    shrinking,
    theorem_radius,
    torque_size,
    transformed,
    weight_bound,
    when,
)
from ftac_gym.reproduction.chen_2018.plans import (
    DECAYS,
    FACTORS,
    FUZZY,
    LIMITS,
    SCHEMES,
    SIGNS,
    WIDE,
    mirrored,
    start_name,
)
from ftac_gym.reproduction.claims import Claim, judge
from ftac_gym.reproduction.flight import Flight, from_when
from ftac_gym.reproduction.variations import seconds, settled

Flights = Mapping[str, Flight]

LEAK = 0.001
"""m1 [1/s]."""


def claims(flights: Flights) -> list[Claim]:
    """Return the claims of the abstract, of section 5 and of the conclusion."""
    return [*_bounds(flights), *_convergence(flights), *_comparisons(flights), *_parts(flights)]


def _margins(flights: Flights, names: tuple[str, ...]) -> str:
    return ", ".join(f"{name} {margin(flights[name])}" for name in names)


def _weakened(flights: Flights) -> dict[str, float]:
    """Return the least margins where torque, body or bound are less kind than in the example."""
    found = {f"{limit:g} N m": least(flights[f"M1, {limit:g} N m"]) for limit in LIMITS}
    found["-J' w"] = least(flights["M1, -J' w"])
    found["-J' w, 1 ms"] = least(flights["M1, -J' w, 1 ms"])
    return {**found, **{f"kappa = {k:g}": least(flights[f"M1, kappa = {k:g}"], changed(decay=k)) for k in DECAYS}}


def kept_factors(flights: Flights, where: str) -> list[float]:
    """Return the delta(0) with which M1 keeps its bounds, for a filter that starts at ``where``."""
    found = {factor: flights[f"delta(0) = {factor:g}, {where}"] for factor in FACTORS}
    return [factor for factor, flight in found.items() if least(flight, changed(initial_factor=factor)) > 0.0]


def kept_starts(flights: Flights) -> tuple[int, int]:
    """Return from how many starts M1 keeps the bounds as printed, and bounds mirrored to the start."""
    as_printed = sum(least(flights[f"start {start_name(signs)}"]) > 0.0 for signs in SIGNS)
    fitted = (least(flights[f"start {start_name(signs)}, mirrored"], mirrored(signs)) > 0.0 for signs in SIGNS)
    return as_printed, sum(fitted)


def _list(values: list[float]) -> str:
    return ", ".join(f"{value:g}" for value in values) or "none"


def _bounds(flights: Flights) -> list[Claim]:
    weak, wide = _weakened(flights), changed(**WIDE)
    kept = {name: least(flights[name], wide) for name in ("M1, wide bounds", "M1, wide bounds, 4 N m", *SCHEMES[1:])}
    zero, virtual = (kept_factors(flights, where) for where in ("zero", "virtual"))
    unfitted, fitted = kept_starts(flights)
    own, fine = least(flights["M1"]), least(flights["step 0.0005 s"])
    radius = theorem_radius()
    return [
        Claim(
            "abstract, sec. 5, Fig. 1", "M1 stays within its bounds all the time",
            "least margin, as a share of the bounds' distance: "
            f"{_margins(flights, ('M1', 'M1, healthy'))}; first 10 s at 1 ms {margin(flights['step 0.001 s'])}, at "
            f"0.5 ms {margin(flights['step 0.0005 s'])}",
            judge(False, own > 0.0 and fine > 0.0),
            "delta(0) = 2 and phi(0) = 0 are ours: infinity is printed for one, nothing for the other. It is close",
        ),
        Claim(
            "sec. 5, Fig. 1", "M2 and M3 do not keep the bounds",
            "least margin: " + _margins(flights, ("M2", "M3", "M3 scaled")) + "; "
            + _margins(flights, ("M2, healthy", "M3, healthy", "M3 scaled, healthy")),
            judge(least(flights["M2"]) < 0.0 and least(flights["M3"]) < 0.0),
            "not by the transient: without the faults M2 keeps them, with more margin than M1",
        ),
        Claim(
            "abstract, conclusion", "the performance prescribed is guaranteed whatever saturates, fails or varies",
            "least margin: " + ", ".join(f"{name} {value:+.2g}" for name, value in weak.items())
            + "; rho_0 = 1.5 and kappa = 0.04: " + ", ".join(f"{name} {value:+.2g}" for name, value in kept.items()),
            judge(min(weak.values()) > 0.0, min(kept["M1, wide bounds"], kept["M1, wide bounds, 4 N m"]) > 0.0),
            "only with a bound that the torque can meet; M2 and the scaled M3 then keep it too",
        ),
        Claim(
            "sec. 3.3", "bounds that start infinitely wide are kept",
            f"kept with delta(0) = {_list(zero)} of {_list(list(FACTORS))} where the filter starts at zero, "
            f"{_list(virtual)} where it starts at the virtual control",
            judge(False, FACTORS[-1] in virtual),
            "delta(0) = 100 and the filter started at the virtual control; infinity asks for an infinite rate",
        ),
        Claim(
            "sec. 3.3", "the bounds do not need to know the start",
            f"starts with all 8 signs: kept {unfitted} times as printed, {fitted} times mirrored to the start",
            judge(unfitted == len(SIGNS), fitted == len(SIGNS)),
            "delta falls within a second to values that fit the signs of one start only",
        ),
        Claim(
            "Theorem 6", "the transformed error converges to a small region",
            f"with Table 1 the radius is at least {radius:.1f}; |epsilon| = {radius:.0f} on one axis is "
            f"{np.exp(-2.0 * radius):.0e} of the distance from a bound",
            judge(radius < 1.0),
            "m1 = 0.001 makes it large: the theorem bounds nothing that floating-point numbers can tell from a breach",
        ),
    ]  # fmt: skip


def _convergence(flights: Flights) -> list[Claim]:
    own, even = flights["M1"], flights["M1, lower = upper = 1"]
    size, theta = transformed(own), weight_bound(own)
    near = {f"{limit:g}:": from_when(own.time, size, limit) for limit in (0.1, 0.05, 0.01)}
    late = {name: (shrinking(flights[name], 0.3, 0.4), shrinking(flights[name], 0.8, 0.9))
            for name in ("M1", "M1, lower = upper = 1", "M2, healthy")}  # fmt: skip
    across = {name: float(overshoot(flights[name]).max()) for name in (*SCHEMES, "M2, healthy")}
    reached = {name: accurate(flights[name]) for name in (*SCHEMES, "M1, lower = upper = 1")}
    low, high = changed().bound(own.time[-1])
    rest, middle, evened = own.attitude[-1, 0], 0.5 * (low + high), even.attitude[-1, 0]
    window = round(10.0 / own.scenario.control_period)
    fall, leaked = float(1.0 - theta[-1] / theta[-1 - window]), float(-np.expm1(-10.0 * LEAK))
    return [
        Claim(
            "sec. 5, Fig. 4", "the transformed error comes to the neighbourhood of zero at about 40 s",
            f"|epsilon| stays below {when(near)}",
            judge(all(30.0 <= value <= 50.0 for value in near.values())),
            "read as: within 30 to 50 s, whichever of 0.1, 0.05 and 0.01 the neighbourhood is",
        ),
        Claim(
            "sec. 5", "no attitude component overshoots",
            "farthest beyond zero: " + ", ".join(f"{name} {value:.1e}" for name, value in across.items()),
            judge(across["M1"] == 0.0, across["M1"] < 1e-3),
            "M1 does not even come to zero; less than 1e-3 would do",
        ),
        Claim(
            "sec. 5", "every MRP comes below 0.001", f"after: {when(reached)}",
            judge(np.isfinite(reached["M1"]), np.isfinite(reached["M1, lower = upper = 1"])),
            "at the very end, as rho does; M2 and the scaled M3 are there sooner, and lower = upper = 1 is soonest",
        ),
        Claim(
            "abstract, sec. 5", "the attitude is brought to the origin",
            f"M1 at the end: ({', '.join(f'{value:.2e}' for value in rest)}); middle of the bounds: "
            f"({', '.join(f'{value:.2e}' for value in middle)}); lower = upper = 1: largest "
            f"{np.abs(evened).max():.1e}",
            judge(float(np.abs(rest).max()) < 1e-5, float(np.abs(evened).max()) < 1e-5),
            "bounds with lower = upper: epsilon = 0 is the middle of the bounds, and theirs is not zero",
        ),
        Claim(
            "abstract, Theorem 6, conclusion", "the attitude is stabilised in finite time",
            "|sigma| shrinks at, in 1/s, early (0.3 to 0.4 of the flight) and late (0.8 to 0.9): "
            + ", ".join(f"{name} {first:.3f} and {last:.3f}" for name, (first, last) in late.items()),
            judge(late["M1"][1] > 1.5 * late["M1"][0],
                  late["M1, lower = upper = 1"][1] > 1.5 * late["M1, lower = upper = 1"][0]),
            "lower = upper = 1, and bounds that are broken at 4 s; a finite time shows as a rate that grows. As "
            "printed, sigma follows rho, which is exponential",
        ),
        Claim(
            "sec. 5, Fig. 5", "the estimate theta converges to a positive constant",
            f"largest {theta.max():.2f} at {own.time[int(np.argmax(theta))]:.1f} s; in the last 10 s it falls by "
            f"{100.0 * fall:.2f} %, by the leak alone it would by {100.0 * leaked:.2f} %",
            judge(abs(fall) < 0.5 * leaked, abs(fall) < 0.02),
            "it looks constant for a minute, but leaks away with m1 = 0.001 1/s; theta(0) = 0 and the rules are ours",
        ),
    ]  # fmt: skip


def _comparisons(flights: Flights) -> list[Claim]:
    schemes = {name: flights[name] for name in SCHEMES}
    own, even = flights["M1"], flights["M1, lower = upper = 1"]
    peak = {name: float(flight.speed().max()) for name, flight in schemes.items()}
    calm = {name: from_when(flight.time, flight.speed(), 0.1) for name, flight in schemes.items()}
    turned = {name: float(flight.path_ratio()[0]) for name, flight in schemes.items()}
    best = [min(values, key=values.__getitem__) == "M1" for values in (peak, calm, turned)]
    torques = {**schemes, "M1 sampled": flights["hold 0.005 s, M1 sampled"]}
    sizes = {name: torque_size(flight) for name, flight in torques.items()}
    chatter = {name: flight.chatter() for name, flight in torques.items()}
    compared = {**schemes, "M1, lower = upper = 1": even, "M3 scaled, healthy": flights["M3 scaled, healthy"]}
    others = (flights["M2"], flights["M3 scaled"])
    return [
        Claim(
            "sec. 5", "all three schemes stabilise the attitude",
            "error in the last 10 s: "
            + ", ".join(f"{name} {flight.steady():.2f} deg" for name, flight in schemes.items()),
            judge(max(schemes[name].steady() for name in SCHEMES[:3]) < 2.0,
                  max(schemes[name].steady() for name in ("M1", "M2", "M3 scaled")) < 2.0),
            "M3 with tau = 100, rho = 10; its printed gains are for a body of 10 to 20 kg m^2, and it is lost when the "
            "wheels fail",
        ),
        Claim(
            "sec. 5, Fig. 2", "M1 has better body rates than M2 and M3",
            f"below 0.1 deg/s from: {when(calm)}; angle turned over the shortest: "
            + ", ".join(f"{name} {value:.2f}" for name, value in turned.items()) + "; largest rate: "
            + ", ".join(f"{name} {value:.1f} deg/s" for name, value in peak.items()),
            judge(all(best), best[1] and best[2]),
            "by when it is calm and by how far it turns; M2's largest rate is smaller",
        ),
        Claim(
            "sec. 5, Fig. 3", "the control torques of the three schemes are similar",
            "root mean square and total variation: " + ", ".join(
                f"{name} {sizes[name]:.2f} N m, {chatter[name]:.1f} N m/s" for name in torques),
            judge(_similar(sizes, chatter, SCHEMES[:3]),
                  _similar(sizes, chatter, ("M1 sampled", "M2", "M3 scaled"))),
            "M1 without filter and tau2, M3 with scaled gains; similar: within 1.5 in size and 3 in variation. As "
            f"printed M1 chatters, at the limit for {100.0 * own.saturated():.0f} % of the time",
        ),
        Claim(
            "sec. 1, sec. 5", "M1 is faster and more precise",
            "1 deg after, and error in the last 10 s: " + ", ".join(
                f"{name} {settled(flight, 1.0)}, {flight.steady():.2f} deg" for name, flight in compared.items()),
            judge(_faster(own, others), _faster(even, others)),
            "lower = upper = 1, whose bounds are then not kept; as printed M1 is no sooner than its bound and less "
            "precise than M2. Without faults the scaled M3 takes half the time",
        ),
        Claim(
            "abstract, sec. 5, conclusion",
            "M1 stabilises the attitude despite varying inertia, disturbance, saturation and faults",
            f"every MRP below 0.001 after: {when({name: accurate(flights[name]) for name in _TOLERANT})}",
            judge(np.isfinite(accurate(own)), False),
            "a limit of 4 N m is too little",
        ),
    ]  # fmt: skip


_TOLERANT = ("M1", "M1, healthy", "M1, -J' w", "M1, 5 N m", "M1, 4 N m")


def _similar(sizes: Mapping[str, float], chatter: Mapping[str, float], names: tuple[str, ...]) -> bool:
    size, variation = [sizes[name] for name in names], [chatter[name] for name in names]
    return max(size) < 1.5 * min(size) and max(variation) < 3.0 * min(variation)


def _faster(flight: Flight, others: tuple[Flight, ...]) -> bool:
    sooner = all(flight.settling(1.0) < other.settling(1.0) for other in others)
    return sooner and all(flight.steady() < other.steady() for other in others)


def _parts(flights: Flights) -> list[Claim]:
    own, plain = flights["M1"], flights["hold 0.005 s, M1, no filter"]
    without = flights["M1, lambda = 0"]
    fuzzy = {"as printed": own, **{name: flights[f"M1, {name}"] for name in FUZZY}}
    worse = accurate(own) < 0.9 * accurate(without) or (least(own) > 0.0 >= least(without))
    spared = least(own) > 0.0 and not (least(plain) > 0.0 and np.isfinite(plain.settling(1.0)))
    return [
        Claim(
            "abstract, sec. 5", "the adaptive fuzzy system is what copes with uncertainty and faults",
            "margin, and 0.001 after: " + "; ".join(
                f"{name} {margin(flight)}, {seconds(accurate(flight))}" for name, flight in fuzzy.items()),
            judge(worse),
            "without it (lambda = 0) the flight is the same",
        ),
        Claim(
            "abstract, sec. 1, conclusion", "the command filter spares the law a singularity",
            f"margin, 1 deg after and share of time at the limit: filter {margin(own)}, {settled(own, 1.0)}, "
            f"{100.0 * own.saturated():.0f} %; no filter {margin(plain)}, {settled(plain, 1.0)}, "
            f"{100.0 * plain.saturated():.0f} %",
            judge(spared),
            "without the filter there is none either: the law uses the derivative only as an input of the fuzzy "
            "system, which does nothing",
        ),
    ]  # fmt: skip
