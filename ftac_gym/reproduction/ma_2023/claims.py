"""Claims of Ma, Wang and Wang 2023, judged by flights of their example; ``claims.toml`` holds their texts."""

from __future__ import annotations

from functools import partial

import numpy as np

from ftac_gym.reproduction.ma_2023 import measures
from ftac_gym.reproduction.ma_2023.measures import arrival, arrived, small
from ftac_gym.reproduction.ma_2023.plans import ANGLES, HYSTERESES, SIGNS, SMOOTHINGS
from ftac_gym.reproduction.recordings import Recording, Recordings
from ftac_gym.reproduction.verdicts import Finding, Measure
from ftac_gym.reproduction.wording import listed, percent

LIMIT = 10.0
"""The largest torque of the actuators in the example [N m]."""

PROMISED = 8.6
"""The bound of the torque in the example [N m], to the digits of the print."""

USABLE = "|u1_i|, g0 = 0.6"
"""The corrected law of the assumptions."""

ETA = 0.1
"""The hysteresis of flights whose name has no other."""

EARLY = 10.0
"""A time before the printed gains of section 5.2 chatter, sampled at 1 ms, for a second comparison of energies [s]."""


def _accuracy(flight: Recording) -> str:
    return f"5 deg {arrived(flight, 5.0)}, 1 deg {arrived(flight, 1.0)}, steady {flight.steady():.2f} deg"


MEASURES: dict[str, Measure] = {
    "accuracy": _accuracy,
    "arrived": partial(arrived, angle=1.0),
    "calm": lambda flight: small(flight.steady()),
    "early": partial(Recording.energy, until=EARLY),
    "left": lambda flight: flight.error[-1, 0],
    "small": lambda flight: small(flight.error[-1, 0]),
}
"""Measures for the texts."""


def findings(flights: Recordings) -> dict[str, Finding]:
    """Return the findings for the claims of the abstract, of sections 3 to 5 and of the conclusion."""
    topics = (_bounds, _compensation, _convergence, _unwinding, _energy, _output_feedback)
    return {name: found for topic in topics for name, found in topic(flights).items()}


def _bounds(flights: Recordings) -> dict[str, Finding]:
    limited = flights.chosen(("printed", "g0 = 0.6", USABLE), "5.1, {}")
    found = limited.measured(lambda flight: measures.largest_torque(flight.plan))
    free = flights.chosen(limited, "5.1, {}, unlimited").measured(Recording.peak)
    narrow, wide = (measures.printed_bound(limited["printed"].scenario, share) for share in (0.2, 0.6))
    both = {name: (free[name], found[name]) for name in limited}
    shares = {name: (free[name], 100 * flight.saturated()) for name, flight in limited.items()}
    return {
        "bound": Finding(
            round(narrow, 1) <= PROMISED and max(both["printed"]) <= PROMISED, max(both[USABLE]) <= wide,
            narrow=narrow, wide=wide, largest=listed(both, "{:.1f} and {:.1f} N m"),
        ),
        "limit": Finding(
            *(max(both[name]) <= LIMIT for name in ("printed", USABLE)), shares=listed(shares, "{:.1f} N m, {:.2g} %"),
        ),
    }  # fmt: skip


def _compensation(flights: Recordings) -> dict[str, Finding]:
    printed, bare, usable = (flights[f"5.1, {name}"] for name in ("printed", "without u2", USABLE))
    chatter = flights.measured(Recording.chatter)
    little = 0.01 * chatter["5.1, sign"]
    (speed, within), covered = measures.creeping(printed), measures.compensating(printed, 0.8)
    return {
        "with-u2": Finding(
            *(arrival(flight, 5.0) <= 20.0 for flight in (printed, usable)),
            end=flights["5.1, printed, long"].time[-1], speed=speed,
        ),
        "without-u2": Finding(*(arrival(bare, 5.0) > arrival(flight, 5.0) for flight in (printed, usable))),
        "tolerance": Finding(*(flight.steady() < 1.0 for flight in (printed, usable))),
        "saturation": Finding(
            max(chatter["5.1, printed"], chatter["5.1, printed, no fault"]) < little,
            chatter["fine: printed, no fault"] < little,
        ),
        "inequality": Finding(covered > 0.99, covered=percent(covered, 1), within=percent(within, 1)),
    }  # fmt: skip


def _convergence(flights: Recordings) -> dict[str, Finding]:
    starts, gentle_starts = flights["starts, printed"], flights["starts, gains of 5.1"]
    off, gentle_off = measures.left_off(starts), measures.left_off(gentle_starts)
    moving, bare = flights["5.2, printed, no disturbance"], flights["5.2, gains of 5.1, no disturbance"]
    steady = flights.chosen(("printed", "without u2", USABLE, "floor"), "5.1, {}").measured(Recording.steady)
    calm = flights.chosen(steady, "5.1, {}, no disturbance").measured(Recording.steady)
    slow = [arrival(flights[f"delta = {value}"], 1.0) for value in SMOOTHINGS]
    return {
        "theorem-1": Finding(
            not off.any() and bool(moving.error[-1, 0] < 0.1), not gentle_off.any() and bool(bare.error[-1, 0] < 0.1),
            end=moving.time[-1], starts=len(off), count=off.sum(), worst=starts.error[-1].max(),
            count_gentle=gentle_off.sum(), worst_gentle=small(gentle_starts.error[-1].max()),
        ),
        "asymptotic": Finding(
            steady["printed"] < 1e-2, max(steady[USABLE], steady["floor"]) < 1e-2,
            errors=listed({name: (steady[name], calm[name]) for name in steady}, "{:.3f} and {:.3f} deg"),
        ),
        "robust": Finding(*(steady[name] < 1.0 for name in ("printed", USABLE))),
        "delta": Finding(slow[0] < slow[1] < slow[2]),
    }  # fmt: skip


def long_ways(flights: Recordings, name: str) -> tuple[int, int]:
    """Return the number of long ways round, and that of the starts beyond the hysteresis, ``|e_4|`` > 0.1."""
    beyond = [angle for angle in ANGLES if np.cos(np.radians(0.5 * angle)) > ETA]
    others = [measures.went_round(flights[f"way: {name}, {angle} deg, {sign}"]) for angle in beyond for sign in SIGNS]
    return sum(int(other.sum()) for other in others), sum(len(other) for other in others)


def _path(flights: Recordings, name: str, angle: int) -> float:
    """Return the median path over the shortest one from an angle [deg] with q4 < 0."""
    return float(np.median(flights[f"way: {name}, {angle} deg, q4 < 0"].path_ratio()))


def _unwinding(flights: Recordings) -> dict[str, Finding]:
    chosen = flights.chosen(("printed", "printed, h = 1", "gains of 5.1", "AFNTSMC"), "5.2, {}")
    ends = chosen.measured(lambda flight: float(measures.signed_error(flight)[-1, 0, 0]))
    names = ("HSFC", "HSFC, h = 1", "AFNTSMC", "AFNTSMC, eta = 0.1", "SHOPD+")
    ways = {name: long_ways(flights, name) for name in names}
    base = flights[f"eta = {ETA}"]
    apart = [float(np.abs(flights[f"eta = {eta}"].error - base.error).max()) for eta in HYSTERESES]
    usual, wide = (tuple(_path(flights, name, angle) for angle in (140, 165)) for name in ("HSFC", "HSFC, eta = 0.5"))
    return {
        "way-round": Finding(ends["printed"] < -0.99 and ends["AFNTSMC"] > 0.99, ends=listed(ends, "{:.4f}")),
        "unwinding": Finding(ways["HSFC"][0] == 0, ways=listed(ways, "{} of {}")),
        "hysteresis": Finding(
            min(wide) > max(1.0, min(usual)) and max(apart[:-1]) < 1e-6, below=small(max(apart[:-1])), apart=apart[-1],
            paths=listed({"eta = 0.1": usual, "eta = 0.5": wide}, "{:.2f} and {:.2f}", "; "),
        ),
    }  # fmt: skip


def _energy(flights: Recordings) -> dict[str, Finding]:
    names = ("printed", "gains of 5.1", "floor", "AFNTSMC", "AFNTSMC, other sign", "AFNTSMC, unlimited")
    chosen = flights.chosen((*names, "gains of 5.1, h = 1"), "5.2, {}")
    energy, early = chosen.measured(Recording.energy), chosen.measured(MEASURES["early"])
    usable = energy["gains of 5.1"] < energy["AFNTSMC"] and early["printed"] < early["AFNTSMC"]
    longer = energy["AFNTSMC"] > energy["AFNTSMC, other sign"], energy["gains of 5.1, h = 1"] > energy["gains of 5.1"]
    energies = {name: (energy[name], early[name]) for name in names}
    return {
        "energy": Finding(
            energy["printed"] < energy["AFNTSMC"], usable, energies=listed(energies, "{:.0f} ({:.0f} by 10 s)"),
        ),
        "long-way": Finding(all(longer)),
    }  # fmt: skip


def _output_feedback(flights: Recordings) -> dict[str, Finding]:
    """Judge the claims about SHOPD+, for the printed law and for the usable ones, healthy and with faults."""
    rivals = ("SHOPD+", "SHOPD+, q_c = 0")
    healthy = flights.chosen(("printed", "gains of 5.1", *rivals), "5.2, {}")
    faulty = flights.chosen(("printed", "without u2", USABLE, *rivals), "5.1, {}")
    both = ((healthy, ("printed", "gains of 5.1")), (faulty, ("printed", USABLE)))
    costs, times = [], []
    sooner, less = [True, True], [True, True]
    for group, ours in both:
        soon = group.measured(partial(arrival, angle=5.0))
        cost = group.measured(lambda flight: (flight.peak(), flight.energy(EARLY), flight.energy()))
        for index, name in enumerate(ours):
            sooner[index] &= soon[name] < soon["SHOPD+"]
            less[index] &= all(own < other for own, other in zip(cost[name], cost["SHOPD+"], strict=True))
        costs.append(listed(cost, "{:.1f} N m, {:.0f} and {:.0f}"))
        times.append(listed(group.measured(lambda flight: (arrived(flight, 1.0), arrived(flight, 5.0))), "{}, {}"))
    steady = healthy.measured(Recording.steady)
    calm = flights.chosen(("gains of 5.1", "SHOPD+"), "5.2, {}, no disturbance").measured(Recording.steady)
    return {
        "tracking": Finding(max(steady["printed"], steady["SHOPD+"]) < 1.0, max(calm.values()) < 1.0),
        "transient": Finding(*sooner, healthy=times[0], faulty=times[1]),
        "torque": Finding(*less, end=healthy["SHOPD+"].time[-1], healthy=costs[0], faulty=costs[1]),
    }
