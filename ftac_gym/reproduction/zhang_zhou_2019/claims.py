"""The claims of Zhang and Zhou 2019, and what their equations do in their example."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ftac_gym.reproduction.claims import Claim, judge
from ftac_gym.reproduction.flight import Flight
from ftac_gym.reproduction.inverse_dynamics import peak_wheel_torque
from ftac_gym.reproduction.variations import settled
from ftac_gym.utils.parameters import FloatArray

Flights = Mapping[str, Flight]


def claims(flights: Flights) -> list[Claim]:
    """Return the claims of the abstract, of section 5, of Table 1 and of the conclusion."""
    return [*_estimation(flights), *_control(flights), *_comparison(flights), *_table_1(flights), *_parts(flights)]


def _slowed(flights: Flights) -> str:
    return f"reference five times slower, which needs {peak_wheel_torque(flights['tracking'].scenario):.1f} N m"


def _late(flight: Flight) -> tuple[FloatArray, FloatArray, float]:
    """Return e1^ and b2^ of the last 10 s, and what of the true b2 = 0.06 N m the wheels' axes let one see."""
    assert flight.effectiveness is not None and flight.bias is not None
    late = flight.time[:-1] >= flight.time[-1] - 10.0
    axes = flight.scenario.spacecraft.wheels.axis_matrix
    seen = float((np.linalg.pinv(axes) @ axes)[1, 1]) * 0.06
    return flight.effectiveness[late, 0, 0], flight.bias[late, 0, 1], seen


def _observed(flight: Flight) -> str:
    share, bias, _ = _late(flight)
    return f"e1 {share.min():.2f} to {share.max():.2f}, b2 {bias.min():.3f} to {bias.max():.3f} N m"


def _estimates_hold(flight: Flight) -> bool:
    """Whether e1 is known to 0.05 and the visible part of b2 to a fifth in the last 10 s."""
    share, bias, seen = _late(flight)
    return bool(np.abs(share - 0.5).max() < 0.05 and np.abs(bias - seen).max() < 0.2 * seen)


def _mismatch(flight: Flight) -> float:
    """Return the largest |w~|_1 after the first second [rad/s]."""
    assert flight.rate_mismatch is not None
    return float(np.abs(flight.rate_mismatch[flight.time[:-1] > 1.0]).sum(axis=2).max())


def _estimation(flights: Flights) -> list[Claim]:
    printed, tracking, rest = (flights[name] for name in ("as printed, 5 N m", "tracking", "stabilisation"))
    calm = flights["tracking, undisturbed"]
    mismatch = {name: _mismatch(flights[name]) for name in ("as printed, 5 N m", "tracking", "stabilisation")}
    visible = _late(tracking)[2]
    return [
        Claim(
            "abstract", "the barrier function removes the effect of inertia errors and disturbances from the observer",
            "largest |w~|_1 after 1 s: " + ", ".join(f"{name} {value:.4f}" for name, value in mismatch.items())
            + f" rad/s (barrier 0.05); estimates, slowed: {_observed(tracking)}, without inertia error and disturbance "
            f"{_observed(calm)}",
            judge(False, max(mismatch.values()) < 0.05),
            "of the rate error, which stays inside the barrier; of the estimates see the next row",
        ),
        Claim(
            "abstract, sec. 5, Fig. 6", "the observer estimates loss of effectiveness and bias successfully",
            f"true e1 0.5, b2 0.06 of which the axes let one see {visible:.3f} N m. Printed gains and reference: "
            f"{_observed(printed)}; slowed: {_observed(flights['tracking, printed observer'])}. Usable gains, printed "
            f"reference: {_observed(flights['printed, 5 N m'])}; slowed: {_observed(tracking)}; at rest: "
            f"{_observed(rest)}",
            judge(
                _estimates_hold(printed),
                any(_estimates_hold(flight) for flight in (flights["printed, 5 N m"], tracking, rest, calm)),
            ),
            "usable gains; asked for: e1 to 0.05 and the visible bias to a fifth throughout the last 10 s",
        ),
        Claim(
            "abstract, conclusion", "the controllers compensate the faults by the estimates",
            f"0.1 deg after, slowed: printed gains {settled(flights['tracking, printed observer'])}, usable gains "
            f"{settled(tracking)}, E^ = I {settled(flights['tracking, no observer'])}, exact "
            f"{settled(flights['tracking, oracle'])}; at rest: {settled(rest)}, E^ = I "
            f"{settled(flights['stabilisation, no observer'])}, exact {settled(flights['stabilisation, oracle'])}",
            judge(
                _earlier(flights["tracking, printed observer"], flights["tracking, no observer"]),
                _earlier(tracking, flights["tracking, no observer"]),
            ),
            f"usable gains; {_slowed(flights)}",
        ),
    ]  # fmt: skip


def _earlier(first: Flight, second: Flight) -> bool:
    """Whether the first settles at least 5 % earlier than the second."""
    return first.settling(0.1) < 0.95 * second.settling(0.1)


def _control(flights: Flights) -> list[Claim]:
    printed, second = (flights[f"as printed, {limit} N m"] for limit in (5, 2))
    tracking, rest, sharp = flights["tracking"], flights["stabilisation"], flights["stabilisation, sign"]
    free, weak, dead = (flights[name] for name in ("printed, unlimited", "tracking, 2 N m", "tracking, dead wheel"))
    helped = flights["tracking, auxiliary"]
    needed = peak_wheel_torque(printed.scenario)
    return [
        Claim(
            "abstract", "stabilises the attitude in finite time in spite of the faults",
            f"0.1 deg after {settled(rest)}, then at most {rest.steady():.3f} deg; sign: {settled(sharp)}, "
            f"{sharp.steady():.3f} deg",
            judge(False, rest.settling(0.1) < 60.0 and sharp.settling(0.1) < 60.0),
            "gains chosen, none are printed; to a ball set by boundary layer or sampling, not to zero",
        ),
        Claim(
            "abstract, sec. 5, Fig. 7", "tracks the printed reference in finite time in spite of the faults",
            f"as printed, error in the last 10 s up to {printed.steady():.0f} deg with 5 N m, {second.steady():.0f} "
            f"with 2 N m; unlimited torque: 0.1 deg after {settled(free)}; slowed: {settled(tracking)}",
            judge(
                printed.settling(0.1) < 60.0 or second.settling(0.1) < 60.0,
                tracking.settling(0.1) < 60.0,
            ),
            f"the printed reference needs {needed:.1f} N m of one wheel; {_slowed(flights)}",
        ),
        Claim(
            "abstract", "an auxiliary system makes up for the saturation of the wheels",
            f"slowed, 5 N m: 0.1 deg after {settled(helped)} with it, {settled(tracking)} without; 2 N m: "
            f"{settled(flights['tracking, 2 N m, auxiliary'])} and {settled(weak)}",
            judge(_earlier(helped, tracking) or _earlier(flights["tracking, 2 N m, auxiliary"], weak)),
            "its state provably only falls; what it adds depends on the integrator's step (study)",
        ),
        Claim(
            "sec. 5, Fig. 8", "the control input stays within |u| < 2 N m",
            f"as printed: wheels at the 2 N m limit {100 * second.saturated():.0f} % of the time; slowed: "
            f"{100 * weak.saturated():.0f} %, error in the last 10 s up to {weak.steady():.0f} deg",
            judge(second.saturated() == 0.0, weak.saturated() == 0.0),
            "the limiter keeps it there, not the law",
        ),
        Claim(
            "sec. 4, Remark 5", "also a complete failure of a wheel is compensated",
            f"slowed, wheel 0 dead from 10 s: 0.1 deg after {settled(dead)}, steady {dead.steady():.3f} deg",
            judge(False, dead.settling(0.1) < 60.0),
            f"one of four wheels; {_slowed(flights)}",
        ),
    ]  # fmt: skip


def _comparison(flights: Flights) -> list[Claim]:
    tracking, rest = flights["tracking"], flights["stabilisation"]
    shen, scaled = flights["Shen-class"], flights["Shen-class, scaled"]
    healthy, scaled_healthy = flights["Shen-class, healthy"], flights["Shen-class, scaled, healthy"]
    scaled_rest = flights["Shen-class, scaled, at rest"]
    return [
        Claim(
            "sec. 5, Figs. 2, 3", "the law of [4] tracks well without faults",
            f"Shen-class, slowed, error in the last 10 s up to {healthy.steady():.1f} deg with its published gains, "
            f"{scaled_healthy.steady():.2f} deg scaled",
            judge(False, min(healthy.steady(), scaled_healthy.steady()) < 1.0),
            "Shen-class, gains scaled to this body and these wheels; it has no feed-forward of the reference",
        ),
        Claim(
            "sec. 5, Figs. 4, 5", "faults degrade the law of [4]",
            f"Shen-class, slowed, with and without faults: published gains {shen.steady():.2f} and "
            f"{healthy.steady():.2f} deg, scaled {scaled.steady():.3f} and {scaled_healthy.steady():.3f} deg",
            judge(False, min(shen.steady() / healthy.steady(), scaled.steady() / scaled_healthy.steady()) > 1.1),
            "Shen-class; with either gains by more than a tenth",
        ),
        Claim(
            "sec. 5", "the law settles sooner and is more precise than that of [4]",
            f"slowed: {settled(tracking)}, {tracking.steady():.3f} deg against {settled(scaled)}, "
            f"{scaled.steady():.3f} deg (scaled); at rest: {settled(rest)}, {rest.steady():.3f} deg against "
            f"{settled(scaled_rest)}, {scaled_rest.steady():.3f} deg",
            judge(
                False,
                tracking.settling(0.1) < scaled.settling(0.1) and tracking.steady() < scaled.steady()
                and rest.settling(0.1) < scaled_rest.settling(0.1) and rest.steady() < scaled_rest.steady(),
            ),
            f"against the Shen-class law with scaled gains; {_slowed(flights)}",
        ),
    ]  # fmt: skip


def _table_1(flights: Flights) -> list[Claim]:
    printed, free, tracking = (flights[name] for name in ("as printed, 5 N m", "printed, unlimited", "tracking"))
    table = {
        "as printed, 5 N m": printed,
        "unlimited": free,
        "unlimited, sign": flights["printed, unlimited, sign"],
        "slowed": tracking,
        "slowed, sign, 10 ms": flights["tracking, sign"],
        "slowed, sign, 1 ms": flights["tracking, 0.001 s, layer 0.0"],
    }
    accuracy = {name: flight.component_accuracy() for name, flight in table.items()}
    scaled, shen = flights["Shen-class, scaled"], flights["Shen-class"]
    rows = []
    for index, printed_accuracy in enumerate((1.3e-4, 3.2e-4, 8.5e-4)):
        found = {name: value[index] for name, value in accuracy.items()}
        rows.append(
            Claim(
                "Table 1", f"sigma_{index + 1} is tracked to {printed_accuracy:.1e} deg",
                ", ".join(f"{name}: {value:.2g} deg" for name, value in found.items()),
                judge(found["as printed, 5 N m"] <= printed_accuracy, min(found.values()) <= printed_accuracy),
                "with a sign the error is chatter, which shrinks with the step: a number of the simulation",
            )
        )  # fmt: skip
    return [
        *rows,
        Claim(
            "Table 1", "the law settles in 20 s",
            f"0.1 deg after: as printed {settled(printed)}, unlimited {settled(free)}, slowed {settled(tracking)}, at "
            f"rest {settled(flights['stabilisation'])}",
            judge(printed.settling(0.1) <= 20.0, tracking.settling(0.1) <= 20.0),
            _slowed(flights),
        ),
        Claim(
            "Table 1", "the law of [4] settles in 36 s to 0.005-0.008 deg",
            f"Shen-class, printed reference: {settled(flights['printed, Shen-class'])}; slowed: {settled(shen)}, "
            f"{shen.steady():.2f} deg, scaled {settled(scaled)}, {scaled.steady():.3f} deg",
            judge(False, any(flight.settling(0.008) < 40.0 for flight in (shen, scaled))),
            "Shen-class; the law of [4] itself was not to be had",
        ),
    ]  # fmt: skip


def _parts(flights: Flights) -> list[Claim]:
    tracking, without = flights["tracking"], flights["tracking, no network"]
    sharp, constant = flights["tracking, sign"], flights["tracking, constant gain"]
    free_sharp, free_constant = (flights[f"tracking, unlimited, {name}"] for name in ("sign", "constant gain"))
    return [
        Claim(
            "introduction", "the exponential reaching law chatters less than a constant gain of its largest value",
            f"total variation with sign, unlimited: {free_sharp.chatter():.0f} N m/s against "
            f"{free_constant.chatter():.0f}; 5 N m: {sharp.chatter():.0f} against {constant.chatter():.0f}",
            judge(sharp.chatter() < 0.95 * constant.chatter(), free_sharp.chatter() < 0.95 * free_constant.chatter()),
            "with torque to spare; wheels that switch between their limits do so either way",
        ),
        Claim(
            "conclusion", "thanks to the network no bound on disturbances need be known",
            f"slowed: steady {tracking.steady():.4f} deg with, {without.steady():.4f} deg without the network; 0.1 deg "
            f"after {settled(tracking)} and {settled(without)}",
            judge(False, without.steady() > 1.1 * tracking.steady() or _earlier(tracking, without)),
            "the law without the network needs no bound either: its robust terms adapt",
        ),
    ]  # fmt: skip
