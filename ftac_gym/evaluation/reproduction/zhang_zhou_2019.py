"""What Zhang and Zhou 2019 claim, and what their equations do in their example."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ftac_gym import scenarios
from ftac_gym.evaluation.inverse_dynamics import peak_wheel_torque
from ftac_gym.evaluation.reproduction import figures
from ftac_gym.evaluation.reproduction.claims import Claim, Reproduction, judge
from ftac_gym.evaluation.reproduction.flight import Flight
from ftac_gym.evaluation.reproduction.variations import seconds, settled
from ftac_gym.evaluation.reproduction.zhang_zhou_2019_plans import LAYERS, PERIODS
from ftac_gym.evaluation.tables import Cells


def _observed(flight: Flight) -> str:
    """Say how good the estimates of the two faults are in the last 10 s."""
    assert flight.effectiveness is not None and flight.bias is not None
    late = flight.time[1:] >= flight.time[-1] - 10.0
    share, bias = flight.effectiveness[late, 0, 0], flight.bias[late, 0, 1]
    return f"e1 {share.min():.2f} to {share.max():.2f} (0.5), b2 {bias.min():.3f} to {bias.max():.3f} N m (0.06)"


def _estimates_hold(flight: Flight) -> bool:
    """Whether both faults are estimated to a tenth in the last 10 s."""
    assert flight.effectiveness is not None and flight.bias is not None
    late = flight.time[1:] >= flight.time[-1] - 10.0
    share = np.abs(flight.effectiveness[late, 0, 0] - 0.5).max() < 0.05
    return bool(share and np.abs(flight.bias[late, 0, 1] - 0.06).max() < 0.006)


def claims(flights: Mapping[str, Flight]) -> list[Claim]:
    """Return the claims of the abstract, of section 5, of Table 1 and of the conclusion."""
    printed, second, free = (flights[f"printed, {name}"] for name in ("5 N m", "2 N m", "unlimited"))
    sharp = flights["printed, unlimited, sign"]
    tracking, shen, shen_healthy = flights["tracking"], flights["Shen-class"], flights["Shen-class, healthy"]
    stable = flights["stabilisation"]
    needed = peak_wheel_torque(printed.scenario)
    slowed = peak_wheel_torque(tracking.scenario)
    slowed_note = f"reference five times slower: it needs {slowed:.1f} N m"
    mismatch = {name: _mismatch(flights[name]) for name in ("stabilisation", "tracking")}
    undisturbed = flights["tracking, undisturbed"]
    auxiliary = flights["tracking, 2 N m, auxiliary"], flights["tracking, 2 N m"]
    dead, weak = flights["tracking, dead wheel"], flights["tracking, 2 N m"]
    no_network = flights["tracking, no network"]
    table = {"5 N m": printed, "unlimited": free, "unlimited, sign": sharp, "slowed": tracking,
             "slowed, sign": flights["tracking, sign"]}  # fmt: skip
    accuracy = {name: flight.component_accuracy() for name, flight in table.items()}
    printed_accuracy = np.array([1.3e-4, 3.2e-4, 8.5e-4])
    constant = flights["tracking, constant gain"]
    exponential = flights["tracking, sign"]
    free_constant, free_exponential = (flights[f"tracking, unlimited, {name}"] for name in ("constant gain", "sign"))

    def in_table(index: int) -> str:
        return ", ".join(f"{name}: {value[index]:.2g} deg" for name, value in accuracy.items())

    rows = [
        Claim(
            "abstract", "the barrier function removes the effect of inertia errors and disturbances from the observer",
            "largest |w~|_1 after 1 s: " + ", ".join(f"{name} {value:.4f}" for name, value in mismatch.items())
            + f" rad/s (barrier 0.05); estimates with disturbance: {_observed(tracking)}; without: "
            + _observed(undisturbed),
            judge(_estimates_hold(tracking), max(mismatch.values()) < 0.05),
            "true of the rate error, which stays inside the barrier; the disturbance goes into the estimates",
        ),
        Claim(
            "abstract, sec. 5, Fig. 6", "the observer estimates loss of effectiveness and bias successfully",
            f"printed gains, slowed: {_observed(flights['tracking, printed observer'])}; usable gains, printed "
            f"reference: {_observed(printed)}; slowed: {_observed(tracking)}; at rest: {_observed(stable)}",
            judge(
                _estimates_hold(flights["tracking, printed observer"]),
                _estimates_hold(printed) or _estimates_hold(tracking),
            ),
            "only e1, while the wheel is driven hard; a bias cannot be told from a constant disturbance",
        ),
        Claim(
            "abstract", "stabilises the attitude in finite time in spite of the faults",
            f"0.1 deg after {settled(stable)}, then at most {stable.steady():.3f} deg; "
            f"sign: {settled(flights['stabilisation, sign'])}, {flights['stabilisation, sign'].steady():.3f} deg",
            judge(False, stable.settling(0.1) < 60.0),
            "gains chosen, none are printed; to a ball set by boundary layer and sampling, not to zero",
        ),
        Claim(
            "abstract, sec. 5, Fig. 7", "tracks the printed reference in finite time in spite of the faults",
            f"error in the last 10 s up to {printed.steady():.0f} deg with 5 N m, {second.steady():.0f} with 2 N m; "
            f"unlimited: 0.1 deg after {settled(free)}; slowed: {settled(tracking)}",
            judge(
                printed.settling(0.1) < 60.0 or second.settling(0.1) < 60.0,
                min(free.settling(0.1), tracking.settling(0.1)) < 60.0,
            ),
            f"not with these wheels: the reference needs {needed:.1f} N m of one wheel; {slowed_note}",
        ),
        Claim(
            "abstract", "an auxiliary system makes up for the saturation of the wheels",
            f"2 N m, slowed: 0.1 deg after {settled(auxiliary[0])} with it, {settled(auxiliary[1])} without; steady "
            f"{auxiliary[0].steady():.3f} and {auxiliary[1].steady():.3f} deg",
            judge(auxiliary[0].settling(0.1) < 0.95 * auxiliary[1].settling(0.1)),
            "its state provably only falls and is soon frozen; what it adds depends on the integrator's step (study)",
        ),
        Claim(
            "sec. 5, Fig. 8", "the control input stays within |u| < 2 N m",
            f"wheels at the 2 N m limit {100 * second.saturated():.0f} % of the time, printed reference; slowed: "
            f"{100 * weak.saturated():.0f} %, 0.1 deg after {settled(weak)}, error in the last 10 s up to "
            f"{weak.steady():.0f} deg",
            judge(second.saturated() == 0.0),
            "the limiter keeps it there, not the law",
        ),
        Claim(
            "sec. 5, Figs. 2, 3", "the law of [4] tracks well without faults",
            f"Shen-class, slowed: error in the last 10 s up to {shen_healthy.steady():.1f} deg",
            judge(False, shen_healthy.steady() < 1.0),
            "Shen-class: the family's published law with its published gains, which know neither inertia nor reference "
            "torque",
        ),
        Claim(
            "sec. 5, Figs. 4, 5", "faults degrade the law of [4]",
            f"Shen-class, slowed: up to {shen.steady():.2f} deg with, {shen_healthy.steady():.2f} deg without faults",
            judge(False, shen.steady() > 1.2 * shen_healthy.steady()),
            "Shen-class",
        ),
        *(
            Claim(
                "Table 1", f"sigma_{index + 1} is tracked to {printed_accuracy[index]:.1e} deg", in_table(index),
                judge(
                    bool(accuracy["5 N m"][index] <= printed_accuracy[index]),
                    bool(min(value[index] for value in accuracy.values()) <= printed_accuracy[index]),
                ),
                "with a sign the error is chatter, in proportion to the step: 1e-4 deg is a property of the step",
            )
            for index in range(3)
        ),
        Claim(
            "Table 1", "the law settles in 20 s",
            f"to 0.1 deg: 5 N m {settled(printed)}, unlimited {settled(free)}, slowed {settled(tracking)}, "
            f"at rest {settled(stable)}",
            judge(printed.settling(0.1) <= 20.0, tracking.settling(0.1) <= 20.0),
            slowed_note,
        ),
        Claim(
            "Table 1", "the law of [4] settles in 36 s to 0.005-0.008 deg",
            f"Shen-class, printed reference: {settled(flights['printed, Shen-class'])}; slowed: {settled(shen)}, "
            f"steady up to {shen.steady():.1f} deg",
            judge(False, shen.steady() < 0.01 and shen.settling(0.01) < 40.0),
            "Shen-class; its published gains are for bodies a third as heavy and a target at rest",
        ),
        Claim(
            "sec. 5", "the law settles sooner and is more precise than that of [4]",
            f"slowed: {settled(tracking)} and {tracking.steady():.3f} deg against {settled(shen)} and "
            f"{shen.steady():.1f} deg",
            judge(False, tracking.settling(0.1) < shen.settling(0.1) and tracking.steady() < shen.steady()),
            f"against the Shen-class law, untuned; {slowed_note}",
        ),
        Claim(
            "introduction", "the exponential reaching law chatters less than a constant gain of its largest value",
            f"total variation with sign, unlimited: {free_exponential.chatter():.0f} N m/s against "
            f"{free_constant.chatter():.0f}; 5 N m: {exponential.chatter():.0f} against {constant.chatter():.0f}",
            judge(
                exponential.chatter() < 0.95 * constant.chatter(),
                free_exponential.chatter() < 0.95 * free_constant.chatter(),
            ),
            "with torque to spare; wheels of 5 N m switch between their limits either way",
        ),
        Claim(
            "conclusion", "thanks to the network no bound on disturbances need be known",
            f"slowed: steady {tracking.steady():.4f} deg with, {no_network.steady():.4f} deg without the network; "
            f"0.1 deg after {settled(tracking)} and {settled(no_network)}",
            judge(False, no_network.steady() > 1.1 * tracking.steady()),
            "the robust terms do the work: Omega grows until they suffice",
        ),
        Claim(
            "sec. 4, Remark 5", "also a complete failure of a wheel is compensated",
            f"slowed, wheel 1 dead from 10 s: 0.1 deg after {settled(dead)}, steady {dead.steady():.3f} deg",
            judge(False, dead.settling(0.1) < 60.0),
            f"one of four wheels; {slowed_note}",
        ),
    ]  # fmt: skip
    return rows


def _mismatch(flight: Flight) -> float:
    assert flight.rate_mismatch is not None
    return float(np.abs(flight.rate_mismatch[flight.time[1:] > 1.0]).sum(axis=2).max())


def studies(flights: Mapping[str, Flight]) -> dict[str, Cells]:
    """Return the tables that settle the claims."""
    schemes: Cells = [["flight", "0.1 deg after", "steady [deg]", "saturated", "chatter [N m/s]"]]
    for name, flight in flights.items():
        if "layer" in name or name.startswith(("random", "auxiliary")):
            continue
        row = [settled(flight), f"{flight.steady():.4f}", f"{100 * flight.saturated():.0f} %"]
        schemes.append([name, *row, f"{flight.chatter():.1f}"])
    steps: Cells = [["law", "period [ms]", *(f"layer {layer}" if layer else "sign" for layer in LAYERS)]]
    for name in ("stabilisation", "tracking"):
        for period in PERIODS:
            cells = [flights[f"{name}, {period} s, layer {layer}"] for layer in LAYERS]
            steps.append([name, f"{1000 * period:g}", *(f"{settled(c, 1.0)}, {c.steady():.4f} deg" for c in cells)])
    auxiliary: Cells = [["anti-saturation system", "0.1 deg after", "steady [deg]"]]
    without = flights["stabilisation"]
    auxiliary.append(["off", settled(without), f"{without.steady():.4f}"])
    for name in ("10 ms", "1 ms", "fine"):
        flight = flights[f"auxiliary, {name}"]
        label = "on, 10 ms with 1,000 sub-steps" if name == "fine" else f"on, Euler {name}"
        auxiliary.append([label, settled(flight), f"{flight.steady():.4f}"])
    limits: Cells = [["reference", "needed, shared best [N m]", "needed, pseudo-inverse [N m]"]]
    for name in ("zhang_zhou_2019", "zhang_zhou_2019_feasible"):
        scenario = scenarios.get(name)
        best = peak_wheel_torque(scenario)
        limits.append([name, f"{best:.1f}", f"{peak_wheel_torque(scenario, allocation='pseudo_inverse'):.1f}"])
    starts = flights["random starts"]
    times = np.array([starts.settling(0.1, craft) for craft in range(starts.error.shape[1])])
    # Between a start that settles and one that does not there is nothing to interpolate.
    quantiles = [seconds(value) for value in np.percentile(times, [0, 50, 95, 100], method="higher")]
    random: Cells = [["random attitudes, rates to 0.5 rad/s", "first", "median", "95 %", "last"],
                     [f"{len(times)} starts, 0.1 deg after", *quantiles]]  # fmt: skip
    return {
        "All schemes and comparators": schemes,
        "Step size and sampling: 1 deg after, largest error of the last 10 s": steps,
        "The anti-saturation system": auxiliary,
        "Torque that the reference needs of the most loaded wheel": limits,
        "Random starts": random,
    }


def evaluate(flights: Mapping[str, Flight]) -> Reproduction:
    """Judge the claims and draw the figures."""
    sections = {
        "attitude": figures.attitude(
            {name: flights[name] for name in ("printed, 5 N m", "tracking", "Shen-class", "tracking, no observer")}
        ),
        "torque": figures.torque({name: flights[name] for name in ("printed, 2 N m", "tracking", "Shen-class")}),
        "estimates": figures.estimates({name: flights[name] for name in ("printed, 5 N m", "tracking")}),
        "schemes": figures.errors(
            {
                name: flights[name]
                for name in ("tracking", "tracking, sign", "tracking, no observer", "tracking, oracle", "Shen-class")
            }
        ),
    }
    return Reproduction(claims(flights), studies(flights), sections)
