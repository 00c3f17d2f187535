"""Claims of Ma, Wang and Wang 2023, judged by flights of their example; ``claims.toml`` holds their texts."""

from __future__ import annotations

from functools import partial

import numpy as np

from ftac_gym.reproduction.ma_2023 import measures
from ftac_gym.reproduction.ma_2023.measures import arrival, arrived, small
from ftac_gym.reproduction.ma_2023.plans import ANGLES, HYSTERESES, SIGNS, SMOOTHINGS
from ftac_gym.reproduction.recorder import Recording, Recordings
from ftac_gym.reproduction.verdicts import Claim, Finding, finding, written
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


def claims(flights: Recordings) -> list[Claim]:
    """Return the claims of the abstract, of sections 3 to 5 and of the conclusion."""
    findings = {**_bounds(flights), **_compensation(flights), **_convergence(flights), **_unwinding(flights)}
    return written("ma_2023", {**findings, **_energy(flights), **_output_feedback(flights)})


def _accuracy(flight: Recording) -> str:
    return f"5 deg {arrived(flight, 5.0)}, 1 deg {arrived(flight, 1.0)}, steady {flight.steady():.2f} deg"


def _bounds(flights: Recordings) -> dict[str, Finding]:
    limited = flights.chosen(("printed", "g0 = 0.6", USABLE), "5.1, {}")
    found = limited.measured(lambda flight: measures.largest_torque(flight.plan))
    free = flights.chosen(limited, "5.1, {}, unlimited").measured(Recording.peak)
    narrow, wide = (measures.printed_bound(limited["printed"].scenario, share) for share in (0.2, 0.6))
    both = {name: (free[name], found[name]) for name in limited}
    shares = {name: (free[name], 100 * flight.saturated()) for name, flight in limited.items()}
    return {
        "bound": finding(
            round(narrow, 1) <= PROMISED and max(both["printed"]) <= PROMISED, max(both[USABLE]) <= wide,
            narrow=narrow, wide=wide, largest=listed(both, "{:.1f} and {:.1f} N m"),
        ),
        "limit": finding(
            *(max(both[name]) <= LIMIT for name in ("printed", USABLE)), shares=listed(shares, "{:.1f} N m, {:.2g} %"),
        ),
    }  # fmt: skip


def _compensation(flights: Recordings) -> dict[str, Finding]:
    names = ("printed", "g0 = 0.6", "without u2", USABLE, "|u1_i|, g0 = 0.2", "along S", "sign", "printed, long")
    schemes = flights.chosen(names, "5.1, {}")
    text = schemes.measured(_accuracy)
    printed, bare, usable, sign, long = (schemes[name] for name in ("printed", "without u2", USABLE, "sign", names[-1]))
    whole = {name: flights[f"5.1, {name}, no fault"] for name in ("printed", "without u2", USABLE)}
    fine, coarse = flights["fine: printed, no fault"], flights["hold: printed, 0.02 s"]
    chatter = {name: flight.chatter() for name, flight in (("printed", printed), ("whole", whole["printed"]))}
    (speed, within), covered = measures.creeping(printed), measures.compensating(printed, 0.8)
    paired = {name: (_accuracy(whole[name]), text[name]) for name in ("printed", USABLE)}
    return {
        "with-u2": finding(
            *(arrival(flight, 5.0) <= 20.0 for flight in (printed, usable)), text=text, end=long.time[-1],
            left=long.error[-1, 0], speed=speed,
        ),
        "without-u2": finding(*(arrival(bare, 5.0) > arrival(flight, 5.0) for flight in (printed, usable)), text=text),
        "tolerance": finding(
            *(flight.steady() < 1.0 for flight in (printed, usable)), paired=listed(paired, "{} and {}", "; ", ": "),
            whole=_accuracy(whole["without u2"]), bare=text["without u2"],
            calm=flights["5.1, without u2, no disturbance"].steady(),
        ),
        "saturation": finding(
            max(chatter.values()) < 0.01 * sign.chatter(), fine.chatter() < 0.01 * sign.chatter(), **chatter,
            sign=sign.chatter(), limited=percent(sign.saturated()), fine=fine.chatter(), coarse=coarse.chatter(),
        ),
        "inequality": finding(
            covered > 0.99, covered=percent(covered, 1), within=percent(within, 1), sign=text["sign"],
        ),
    }  # fmt: skip


def _convergence(flights: Recordings) -> dict[str, Finding]:
    printed, gentle = flights["starts, printed"], flights["starts, gains of 5.1"]
    left, left_gentle = measures.left_off(printed), measures.left_off(gentle)
    moving, bare = flights["5.2, printed, no disturbance"], flights["5.2, gains of 5.1, no disturbance"]
    faulty = flights.chosen(("printed", "without u2", USABLE, "floor"), "5.1, {}").measured(Recording.steady)
    calm = flights.chosen(faulty, "5.1, {}, no disturbance").measured(Recording.steady)
    paced = flights.chosen(("4", "0.75", "0.25"), "disturbance {} times as fast").measured(Recording.steady)
    smooth = flights.chosen([f"delta = {value}" for value in SMOOTHINGS])
    slow = list(smooth.measured(partial(arrival, angle=1.0)).values())
    return {
        "theorem-1": finding(
            not left.any() and bool(moving.error[-1, 0] < 0.1), not left_gentle.any() and bool(bare.error[-1, 0] < 0.1),
            moving=moving.error[-1, 0], end=moving.time[-1], bare=small(bare.error[-1, 0]), starts=len(left),
            count=left.sum(), worst=printed.error[-1].max(), count_gentle=left_gentle.sum(),
            worst_gentle=small(gentle.error[-1].max()),
        ),
        "asymptotic": finding(
            faulty["printed"] < 1e-2, max(faulty[USABLE], faulty["floor"]) < 1e-2,
            errors=listed({name: (faulty[name], calm[name]) for name in faulty}, "{:.3f} and {:.3f} deg"),
            whole=flights["5.1, without u2, no fault"].steady(), bare=small(bare.steady()),
        ),
        "robust": finding(
            faulty["printed"] < 1.0, faulty[USABLE] < 1.0, usable_error=faulty[USABLE], floor=faulty["floor"],
            bare=faulty["without u2"], paced="{:.2f}, {:.2f} and {:.2f}".format(*paced.values()),
        ),
        "delta": finding(
            slow[0] < slow[1] < slow[2], times=listed(smooth.measured(partial(arrived, angle=1.0))),
            energies=", ".join(f"{flight.energy():.0f}" for flight in smooth.values()),
        ),
    }  # fmt: skip


def long_ways(flights: Recordings, name: str) -> tuple[int, int]:
    """Return the number of long ways round, and that of the starts beyond the hysteresis, |e_4| > 0.1."""
    beyond = [angle for angle in ANGLES if np.cos(np.radians(0.5 * angle)) > ETA]
    others = [measures.went_round(flights[f"way: {name}, {angle} deg, {sign}"]) for angle in beyond for sign in SIGNS]
    return sum(int(other.sum()) for other in others), sum(len(other) for other in others)


def _path(flights: Recordings, name: str, angle: int) -> float:
    """Return the median path over the shortest one from an angle [deg] with q4 < 0."""
    return float(np.median(flights[f"way: {name}, {angle} deg, q4 < 0"].path_ratio()))


def _unwinding(flights: Recordings) -> dict[str, Finding]:
    chosen = flights.chosen(("printed", "printed, h = 1", "gains of 5.1", "AFNTSMC"), "5.2, {}")
    ends = chosen.measured(lambda flight: float(measures.signed_error(flight)[-1, 0, 0]))
    left = chosen.measured(lambda flight: flight.error[-1, 0])
    names = ("HSFC", "HSFC, h = 1", "AFNTSMC", "AFNTSMC, eta = 0.1", "SHOPD+")
    ways = {name: long_ways(flights, name) for name in names}
    base = flights[f"eta = {ETA}"]
    apart = [float(np.abs(flights[f"eta = {eta}"].error - base.error).max()) for eta in HYSTERESES]
    usual, wide = (tuple(_path(flights, name, angle) for angle in (140, 165)) for name in ("HSFC", "HSFC, eta = 0.5"))
    return {
        "way-round": finding(
            ends["printed"] < -0.99 and ends["AFNTSMC"] > 0.99, ends=listed(ends, "{:.4f}"), left=left,
        ),
        "unwinding": finding(ways["HSFC"][0] == 0, ways=listed(ways, "{} of {}")),
        "hysteresis": finding(
            min(wide) > max(1.0, min(usual)) and max(apart[:-1]) < 1e-6, below=small(max(apart[:-1])), apart=apart[-1],
            paths=listed({"eta = 0.1": usual, "eta = 0.5": wide}, "{:.2f} and {:.2f}", "; "),
        ),
    }  # fmt: skip


def _energy(flights: Recordings) -> dict[str, Finding]:
    names = ("printed", "gains of 5.1", "floor", "AFNTSMC", "AFNTSMC, other sign", "AFNTSMC, unlimited")
    energies = flights.chosen(names, "5.2, {}").measured(lambda flight: (flight.energy(), flight.energy(EARLY)))
    printed, gentle, rival, short = (energies[name] for name in (*names[:2], "AFNTSMC", "AFNTSMC, other sign"))
    long = flights["5.2, gains of 5.1, h = 1"].energy()
    return {
        "energy": finding(
            printed[0] < rival[0], gentle[0] < rival[0] and printed[1] < rival[1],
            energies=listed(energies, "{:.0f} ({:.0f} by 10 s)"), fine=flights["step: 0.0005 s"].energy(EARLY),
        ),
        "long-way": finding(
            rival[0] > short[0] and long > gentle[0], rival=rival[0], rival_short=short[0], long=long, short=gentle[0],
        ),
    }  # fmt: skip


def _output_feedback(flights: Recordings) -> dict[str, Finding]:
    rival, names = "SHOPD+", ("printed", "gains of 5.1", "SHOPD+", "SHOPD+, q_c = 0")
    healthy = flights.chosen(names, "5.2, {}")
    faulty = flights.chosen(("printed", "without u2", USABLE, *names[2:]), "5.1, {}")
    calm = flights.chosen(names[:3], "5.2, {}, no disturbance").measured(Recording.steady)
    steady = healthy.measured(Recording.steady)
    tracked = {name: (f"{steady[name]:.2f} deg", small(calm[name]), f"{healthy[name].peak():.1f} N m") for name in calm}
    costs, costs_faulty = (
        group.measured(lambda flight: (flight.peak(), flight.energy(EARLY), flight.energy()))
        for group in (healthy, faulty)
    )
    times, times_faulty = (
        group.measured(lambda flight: (arrived(flight, 1.0), arrived(flight, 5.0))) for group in (healthy, faulty)
    )
    soon, soon_faulty = (group.measured(partial(arrival, angle=5.0)) for group in (healthy, faulty))

    def less(name: str, name_faulty: str) -> bool:
        """Whether torque and energies are all smaller than those of SHOPD+, healthy and with faults."""
        pairs = [*zip(costs[name], costs[rival], strict=True)]
        pairs += zip(costs_faulty[name_faulty], costs_faulty[rival], strict=True)
        return all(ours < theirs for ours, theirs in pairs)

    def sooner(name: str, name_faulty: str) -> bool:
        return soon[name] < soon[rival] and soon_faulty[name_faulty] < soon_faulty[rival]

    return {
        "tracking": finding(
            max(steady["printed"], steady[rival]) < 1.0, max(calm["gains of 5.1"], calm[rival]) < 1.0,
            tracked=listed(tracked, "{}, {}, {}"),
        ),
        "transient": finding(
            sooner("printed", "printed"), sooner("gains of 5.1", USABLE),
            healthy=listed(times, "{}, {}"), faulty=listed(times_faulty, "{}, {}"),
        ),
        "torque": finding(
            less("printed", "printed"), less("gains of 5.1", USABLE), end=healthy[rival].time[-1],
            healthy=listed(costs, "{:.1f} N m, {:.0f} and {:.0f}"),
            faulty=listed(costs_faulty, "{:.1f} N m, {:.0f} and {:.0f}"),
        ),
    }  # fmt: skip
