"""The claims of Ma, Wang and Wang 2023 about the law itself, and what its equations do in their example."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ftac_gym.reproduction.claims import Claim, judge
from ftac_gym.reproduction.flight import Flight
from ftac_gym.reproduction.ma_2023.comparisons import comparisons
from ftac_gym.reproduction.ma_2023.motion import (
    arrival,
    arrived,
    first_torque,
    held_to,
    largest_torque,
    peak,
    printed_bound,
    rate_error,
    small,
)
from ftac_gym.reproduction.ma_2023.plans import FAULTY, SMOOTHINGS
from ftac_gym.utils.parameters import FloatArray

Flights = Mapping[str, Flight]

LIMIT = 10.0
"""The largest torque of the actuators in the example [N m]."""

PROMISED = 8.6
"""The bound of the torque in the example [N m], to the digits of the print."""

LAYER = 0.005
"""Epsilon of (43) [rad/s]."""

USABLE = "|u1_i|, g0 = 0.6"
"""The mended law that the assumptions are about."""

MENDED = "|u1_i| in place of ||u1|| in (19) and g0 = 0.6, which is above the smallest effectiveness, 0.47"


def claims(flights: Flights) -> list[Claim]:
    """Return the claims of the abstract, of sections 3 to 5 and of the conclusion."""
    return [*_bounds(flights), *_compensation(flights), *_convergence(flights), *comparisons(flights)]


def _both(flight: Flight) -> str:
    return f"5 deg {arrived(flight, 5.0)}, 1 deg {arrived(flight, 1.0)}, steady {flight.steady():.2f} deg"


def _bounds(flights: Flights) -> list[Claim]:
    names = ("printed", "g0 = 0.6", USABLE)
    free = {name: peak(flights[f"5.1, {name}, unlimited"]) for name in names}
    paper = flights["5.1, printed"].scenario
    found = {name: largest_torque(paper, *FAULTY[name]) for name in names}
    stated = printed_bound(paper, 0.2), printed_bound(paper, 0.6)
    limited = {name: flights[f"5.1, {name}"] for name in names}
    return [
        Claim(
            "abstract, (21), sec. 5.1", "the torque has a bound known beforehand, 8.6 N m in the example",
            f"(21) gives {stated[0]:.1f} N m for g0 = 0.2 and {stated[1]:.2f} N m for g0 = 0.6; largest torque of "
            "unlimited wheels in the example and over 20000 random states: "
            + ", ".join(f"{name} {free[name]:.1f} and {found[name]:.1f} N m" for name in names),
            judge(
                round(stated[0], 1) <= PROMISED and max(free["printed"], found["printed"]) <= PROMISED,
                max(free[USABLE], found[USABLE]) <= stated[1],
            ),
            f"{MENDED}; with the norm the bound is k + f + (1 - g0)/g0 (sqrt(3) k + f), f = J_M (c1^2 + c2)",
        ),
        Claim(
            "abstract, sec. 5.1, conclusion", "the gains keep the torque within the 10 N m of the wheels",
            "largest torque of unlimited wheels, and share of time at the limit of 10 N m: "
            + ", ".join(f"{name} {free[name]:.1f} N m, {100 * limited[name].saturated():.2g} %" for name in names),
            judge(max(free["printed"], found["printed"]) <= LIMIT, max(free[USABLE], found[USABLE]) <= LIMIT),
            f"{MENDED}; as printed the start already asks for more",
        ),
    ]  # fmt: skip


def creeping(flight: Flight) -> tuple[float, float]:
    """Return the largest |w_e,i| after 10 s [rad/s], and the share of that time with every one within the layer."""
    speed = np.abs(rate_error(flight)[flight.time > 10.0, 0]).max(axis=1)
    return float(speed.max()), float(np.mean(speed <= LAYER))


def _compensation(flights: Flights) -> list[Claim]:
    printed, bare, mended = (flights[f"5.1, {name}"] for name in ("printed", "without u2", USABLE))
    long, along, componentwise = (flights[f"5.1, {name}"] for name in ("printed, long", "along S", "|u1_i|, g0 = 0.2"))
    speed, within = creeping(printed)
    sign, whole = flights["5.1, sign"], flights["5.1, printed, no fault"]
    first = first_torque(printed)
    paired = {name: (flights[f"5.1, {name}, no fault"], flights[f"5.1, {name}"]) for name in ("printed", USABLE)}
    return [
        Claim(
            "sec. 5.1, Figs. 4, 5", "with the fault term u2 the errors converge fast",
            f"as printed: {_both(printed)}, after {long.time[-1]:.0f} s still {long.error[-1, 0]:.1f} deg; |w_e,i| up "
            f"to {speed:.4f} rad/s after 10 s. g0 = 0.6: {_both(flights['5.1, g0 = 0.6'])}; {USABLE}: {_both(mended)}; "
            f"|u1_i|, g0 = 0.2: {_both(componentwise)}; along S, g0 = 0.2: {_both(along)}",
            judge(arrival(printed, 5.0) <= 20.0, arrival(mended, 5.0) <= 20.0),
            f"{MENDED}; fast: 5 deg within 20 s. As printed u2 opposes the turn and outweighs u1: a brake",
        ),
        Claim(
            "sec. 5.1, Figs. 1, 2", "without u2 the tracking takes more time",
            f"without u2 {_both(bare)}; with it as printed {_both(printed)}; {USABLE}: {_both(mended)}",
            judge(arrival(bare, 5.0) > arrival(printed, 5.0), arrival(bare, 5.0) > arrival(mended, 5.0)),
            f"{MENDED}; judged by 5 deg: without u2 the disturbance keeps the error above 1 deg",
        ),
        Claim(
            "abstract, conclusion", "the law tolerates a partial loss of effectiveness",
            "healthy and with faults: "
            + "; ".join(f"{name}: {_both(before)} and {_both(after)}" for name, (before, after) in paired.items())
            + f"; without u2: {_both(flights['5.1, without u2, no fault'])} and {_both(bare)}, steady without "
            f"disturbance {flights['5.1, without u2, no disturbance'].steady():.2f} deg",
            judge(paired["printed"][1].steady() < 1.0, paired[USABLE][1].steady() < 1.0),
            f"{MENDED}; tolerated: within 1 deg throughout the last 10 s. Without u2 the law tolerates half the torque "
            "as well, but not the disturbance on top",
        ),
        Claim(
            "Remark 4, (43)", "a saturation function instead of the sign takes the chatter away",
            f"sampled at 10 ms: sign {sign.chatter():.0f} N m/s and {100 * sign.saturated():.0f} % of the time "
            f"at the limit, saturation function {printed.chatter():.1f} N m/s; with healthy wheels "
            f"{whole.chatter():.0f} N m/s at 10 ms and {flights['fine: printed, no fault'].chatter():.1f} N m/s at 2 "
            f"ms; with faults at 20 ms {flights['hold: printed, 0.02 s'].chatter():.0f} N m/s",
            judge(max(printed.chatter(), whole.chatter()) < 0.01 * sign.chatter(),
                  flights["fine: printed, no fault"].chatter() < 0.01 * sign.chatter()),
            "sampled fast enough: within the layer the gain of w_e is (1 - g0)/g0 ||u1|| / layer, up to 7000 N m s/rad",
        ),
        Claim(
            "(36)", "the inequality that makes u2 cover the loss of effectiveness holds with (43), too",
            f"it holds in {100 * held_to(printed, first, 0.8):.1f} % of the time; all |w_e,i| are within the layer in "
            f"{100 * within:.1f} % of that after 10 s. With the sign: {_both(sign)}",
            judge(held_to(printed, first, 0.8) > 0.99),
            "it asks for |w_e,i| beyond the layer, where the printed law hardly ever is. With the sign it holds by its "
            "algebra, and the law stops at w_e = 0, wherever that is",
        ),
    ]  # fmt: skip


def stays(flight: Flight, angle: float = 0.1) -> FloatArray:
    """Return which craft are off by more than an angle [deg] at the end, (N,)."""
    off: FloatArray = flight.error[-1] > angle
    return off


def _convergence(flights: Flights) -> list[Claim]:
    printed, gentle = flights["starts, printed"], flights["starts, gains of 5.1"]
    left = stays(printed), stays(gentle)
    moving, bare = flights["5.2, printed, no disturbance"], flights["5.2, gains of 5.1, no disturbance"]
    faulty = {name: flights[f"5.1, {name}"] for name in ("printed", "without u2", USABLE, "floor")}
    calm = {name: flights[f"5.1, {name}, no disturbance"] for name in faulty}
    slow = {value: arrival(flights[f"delta = {value}"], 1.0) for value in SMOOTHINGS}
    return [
        Claim(
            "Theorem 1", "the errors tend to zero from every start",
            f"start of sec. 5.2, no fault, no disturbance: gains of 5.2 {moving.error[-1, 0]:.2f} deg left after "
            f"{moving.time[-1]:.0f} s, gains of 5.1 {small(bare.error[-1, 0])}. {len(left[0])} random attitudes at "
            f"rest: gains of 5.2, {int(left[0].sum())} stay more than 0.1 deg off, by up to "
            f"{printed.error[-1].max():.0f} deg; gains of 5.1, {int(left[1].sum())}, largest error "
            f"{small(gentle.error[-1].max())}",
            judge(not left[0].any() and moving.error[-1, 0] < 0.1, not left[1].any() and bare.error[-1, 0] < 0.1),
            "gains of 5.1; V is zero for g = 0, w_e = 0 and any attitude, and the gains of 5.2 take g there",
        ),
        Claim(
            "abstract, (38)", "they do so asymptotically in spite of disturbances",
            "largest error of the last 10 s in sec. 5.1, with and without disturbance: "
            + ", ".join(f"{name} {faulty[name].steady():.3f} and {calm[name].steady():.3f} deg" for name in faulty)
            + f"; without u2 and faults {flights['5.1, without u2, no fault'].steady():.3f} and "
            f"{small(flights['5.2, gains of 5.1, no disturbance'].steady())} (start of sec. 5.2)",
            judge(faulty["printed"].steady() < 1e-2, max(faulty[USABLE].steady(), faulty["floor"].steady()) < 1e-2),
            "near the target the law is a spring and a damper of finite stiffness, without integral action; the faults "
            "leave an error, too, as they take half of the feed-forward",
        ),
        Claim(
            "conclusion", "the control is robust against the disturbance",
            f"largest error of the last 10 s: {USABLE} {faulty[USABLE].steady():.2f} deg, floor "
            f"{faulty['floor'].steady():.2f} deg; without u2 {faulty['without u2'].steady():.2f} deg, or "
            f"{flights['disturbance 4 times as fast'].steady():.2f}, "
            f"{flights['disturbance 0.75 times as fast'].steady():.2f} and "
            f"{flights['disturbance 0.25 times as fast'].steady():.2f} deg if the disturbance is 4, 0.75 and 0.25 "
            "times as fast",
            judge(faulty["printed"].steady() < 1.0, faulty[USABLE].steady() < 1.0),
            f"{MENDED}; robust: within 1 deg. The disturbance is about the law's resonance, which u2 damps",
        ),
        Claim(
            "Remark 5", "a large delta slows the convergence",
            "without disturbance and u2, 1 deg after: "
            + ", ".join(f"delta = {value} {arrived(flights[f'delta = {value}'], 1.0)}" for value in SMOOTHINGS)
            + ", energy " + ", ".join(f"{flights[f'delta = {value}'].energy():.0f}" for value in SMOOTHINGS)
            + " N^2 m^2 s",
            judge(slow[SMOOTHINGS[0]] < slow[SMOOTHINGS[1]] < slow[SMOOTHINGS[2]]),
            "gains of 5.1 but for delta",
        ),
    ]  # fmt: skip
