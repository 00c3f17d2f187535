"""The claims of Ma, Wang and Wang 2023 about the way round and about the laws that they compare theirs with."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ftac_gym.reproduction.claims import Claim, judge
from ftac_gym.reproduction.flight import Flight
from ftac_gym.reproduction.ma_2023.motion import arrival, arrived, peak, signed_error, small, went_round
from ftac_gym.reproduction.ma_2023.plans import ANGLES, HYSTERESES, SIGNS

Flights = Mapping[str, Flight]

ETA = 0.1
"""The hysteresis that the flights have unless they say another."""

EARLY = 10.0
"""Until when energies are compared as well [s]: before the printed gains of section 5.2 chatter, sampled at 1 ms."""


def comparisons(flights: Flights) -> list[Claim]:
    """Return the claims about unwinding and about AFNTSMC and SHOPD+."""
    return [*_unwinding(flights), *_energy(flights), *_output_feedback(flights)]


def reached(flight: Flight, flipped: bool = False) -> float:
    """Return e_4 at the end of the first craft's flight."""
    return float(signed_error(flight, flipped)[-1, 0, 0])


def long_ways(flights: Flights, name: str) -> tuple[int, int]:
    """Return how many craft go the long way round, and of how many that start beyond the hysteresis, |e_4| > 0.1."""
    gone, counted = 0, 0
    for angle in ANGLES:
        if np.cos(np.radians(0.5 * angle)) <= ETA:
            continue
        for sign in SIGNS:
            other = went_round(flights[f"way: {name}, {angle} deg, {sign}"], sign == SIGNS[1])
            gone, counted = gone + int(other.sum()), counted + len(other)
    return gone, counted


def _path(flights: Flights, name: str, angle: int) -> float:
    """Return the median path over the shortest one from an angle [deg] with q4 < 0."""
    return float(np.median(flights[f"way: {name}, {angle} deg, {SIGNS[1]}"].path_ratio()))


def _unwinding(flights: Flights) -> list[Claim]:
    printed, gentle, rival = (flights[f"5.2, {name}"] for name in ("printed", "gains of 5.1", "AFNTSMC"))
    ends = {name: reached(flights[f"5.2, {name}"]) for name in ("printed", "printed, h = 1", "gains of 5.1", "AFNTSMC")}
    ways = {
        name: long_ways(flights, name) for name in ("HSFC", "HSFC, h = 1", "AFNTSMC", "AFNTSMC, eta = 0.1", "SHOPD+")
    }
    base = flights[f"eta = {HYSTERESES[1]}"]
    apart = {eta: float(np.abs(flights[f"eta = {eta}"].error - base.error).max()) for eta in HYSTERESES}
    below = max(value for eta, value in apart.items() if eta < HYSTERESES[-1])
    paths = {eta: [_path(flights, name, angle) for angle in (140, 165)]
             for eta, name in ((ETA, "HSFC"), (0.5, "HSFC, eta = 0.5"))}  # fmt: skip
    return [
        Claim(
            "sec. 5.2, Fig. 7", "from e4 = -0.88 HSFC turns towards e4 = -1, AFNTSMC towards e4 = 1",
            "e4 at the end: " + ", ".join(f"{name} {value:.4f}" for name, value in ends.items())
            + f"; error then {printed.error[-1, 0]:.2f} deg, gains of 5.1 {gentle.error[-1, 0]:.2f} deg, AFNTSMC "
            f"{rival.error[-1, 0]:.4f} deg",
            judge(ends["printed"] < -0.99 and ends["AFNTSMC"] > 0.99),
            "the sign is reproduced, the convergence is not: the printed gains leave an error",
        ),
        Claim(
            "abstract, sec. 5.2, conclusion", "unwinding is avoided",
            "at rest, no disturbance, both signs of q; of the starts beyond the hysteresis go the long way: "
            + ", ".join(f"{name} {gone} of {total}" for name, (gone, total) in ways.items()),
            judge(ways["HSFC"][0] == 0),
            "gains of 5.1, g0 = 1; the rule for h does it, for AFNTSMC as well",
        ),
        Claim(
            "Remark 1", "eta weighs robustness against a little needless turning",
            f"sec. 5.2: with eta up to {HYSTERESES[-2]} the same flight as with {ETA}, {small(below)} apart, with "
            f"{HYSTERESES[-1]} up to {apart[HYSTERESES[-1]]:.0f} deg apart, for e4(0) = -0.883. Path over shortest "
            "path from q4 < 0, 140 and 165 deg: "
            + "; ".join(f"eta = {eta} {path[0]:.2f} and {path[1]:.2f}" for eta, path in paths.items()),
            judge(min(paths[0.5]) > max(1.0, min(paths[ETA])) and below < 1e-6),
            "the needless turning alone: no noise is flown. eta is not printed",
        ),
    ]  # fmt: skip


def _energies(flights: Flights, names: tuple[str, ...]) -> str:
    chosen = {name: flights[f"5.2, {name}"] for name in names}
    return ", ".join(
        f"{name} {flight.energy():.0f} ({flight.energy(EARLY):.0f} by {EARLY:g} s)" for name, flight in chosen.items()
    )


def _energy(flights: Flights) -> list[Claim]:
    names = ("printed", "gains of 5.1", "floor", "AFNTSMC", "AFNTSMC, other sign", "AFNTSMC, unlimited")
    spent = {name: flights[f"5.2, {name}"].energy() for name in (*names, "printed, h = 1", "gains of 5.1, h = 1")}
    pairs = {"AFNTSMC": "AFNTSMC, other sign", "gains of 5.1, h = 1": "gains of 5.1"}
    early = {name: flights[f"5.2, {name}"].energy(EARLY) for name in names}
    return [
        Claim(
            "sec. 5.2, Fig. 10", "HSFC needs less energy than AFNTSMC",
            f"integral of the squared torque [N^2 m^2 s]: {_energies(flights, names)}; printed, sampled at 0.5 ms, "
            f"{flights['step: 0.0005 s'].energy(EARLY):.0f} by {EARLY:g} s",
            judge(spent["printed"] < spent["AFNTSMC"], spent["gains of 5.1"] < spent["AFNTSMC"]
                  and early["printed"] < early["AFNTSMC"]),
            f"gains of 5.1, or by {EARLY:g} s: later the printed gains have let g go to zero and the sampled torque "
            "chatters. Energy is not defined in the paper. The short way costs AFNTSMC more, too: it is faster",
        ),
        Claim(
            "sec. 1, Remark 2", "unwinding costs energy",
            "the long and the short way [N^2 m^2 s]: "
            + "; ".join(f"{long} {spent[long]:.0f}, {short} {spent[short]:.0f}" for long, short in pairs.items()),
            judge(all(spent[long] > spent[short] for long, short in pairs.items())),
            "",
        ),
    ]  # fmt: skip


def _output_feedback(flights: Flights) -> list[Claim]:
    names = ("printed", "gains of 5.1", "SHOPD+", "SHOPD+, q_c = 0")
    healthy = {name: flights[f"5.2, {name}"] for name in names}
    faulty = {name: flights[f"5.1, {name}"] for name in ("printed", "without u2", "|u1_i|, g0 = 0.6", *names[2:])}
    calm = {name: flights[f"5.2, {name}, no disturbance"] for name in names[:3]}
    usable, mended, rival = healthy["gains of 5.1"], faulty["|u1_i|, g0 = 0.6"], healthy["SHOPD+"]
    costs = {name: (peak(flight), flight.energy(EARLY), flight.energy()) for name, flight in healthy.items()}
    struck = {name: (peak(flight), flight.energy(EARLY), flight.energy()) for name, flight in faulty.items()}

    def less(mine: tuple[float, ...], theirs: tuple[float, ...]) -> bool:
        return all(own < other for own, other in zip(mine, theirs, strict=True))

    def said(cost: Mapping[str, tuple[float, float, float]]) -> str:
        return ", ".join(
            f"{name} {top:.1f} N m, {early:.0f} and {all_:.0f}" for name, (top, early, all_) in cost.items()
        )

    return [
        Claim(
            "sec. 5.2", "HSFC and SHOPD+ track completely within the allowable torque",
            "healthy, largest error of the last 10 s, without disturbance, and largest torque: "
            + ", ".join(f"{name} {healthy[name].steady():.2f} deg, {small(quiet.steady())}, {costs[name][0]:.1f} N m"
                        for name, quiet in calm.items()),
            judge(max(healthy["printed"].steady(), rival.steady()) < 1.0,
                  max(calm["gains of 5.1"].steady(), calm["SHOPD+"].steady()) < 1.0),
            "gains of 5.1 and no disturbance; completely: within 1 deg",
        ),
        Claim(
            "sec. 5.2, Figs. 11, 12", "HSFC has a faster transient than SHOPD+, as it compensates faults",
            "1 deg and 5 deg after, healthy: "
            + ", ".join(f"{name} {arrived(one, 1.0)}, {arrived(one, 5.0)}" for name, one in healthy.items())
            + "; with faults: "
            + ", ".join(f"{name} {arrived(one, 1.0)}, {arrived(one, 5.0)}" for name, one in faulty.items()),
            judge(arrival(healthy["printed"], 5.0) < arrival(rival, 5.0)
                  and arrival(faulty["printed"], 5.0) < arrival(faulty["SHOPD+"], 5.0),
                  arrival(usable, 5.0) < arrival(rival, 5.0)
                  and arrival(mended, 5.0) < arrival(faulty["SHOPD+"], 5.0)),
            "gains of 5.1; with faults |u1_i| in place of ||u1|| and g0 = 0.6. Judged by 5 deg; SHOPD+ never "
            "stays below 1. With faults it is u2 that makes the difference, without them there is nothing to mend",
        ),
        Claim(
            "sec. 5.2, Fig. 13", "HSFC needs less torque than SHOPD+",
            f"largest torque, integral of the square by {EARLY:g} and by {rival.time[-1]:g} s [N^2 m^2 s], healthy: "
            f"{said(costs)}; with faults: {said(struck)}",
            judge(less(costs["printed"], costs["SHOPD+"]) and less(struck["printed"], struck["SHOPD+"]),
                  less(costs["gains of 5.1"], costs["SHOPD+"])
                  and less(struck["|u1_i|, g0 = 0.6"], struck["SHOPD+"])),
            "gains of 5.1; with faults |u1_i| in place of ||u1|| and g0 = 0.6. With faults the printed law spends "
            "little because it hardly turns",
        ),
    ]  # fmt: skip
