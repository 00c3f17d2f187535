"""The claims of Li, Xu and Chang 2023 about control: accuracy, energy, vibration, limits."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ftac_gym.reproduction.claims import Claim, judge
from ftac_gym.reproduction.flight import Flight
from ftac_gym.reproduction.li_2023.measures import (
    CALM,
    FIRST,
    LATE,
    SECOND,
    at_limit,
    axis_errors,
    energy_at,
    fault_error,
    largest,
    settling,
    shaking,
    vibration_error,
    virtual_control,
    words,
)
from ftac_gym.reproduction.li_2023.plans import FAST, SCHEMES
from ftac_gym.reproduction.variations import seconds

Flights = Mapping[str, Flight]


def control_claims(flights: Flights) -> list[Claim]:
    """Return the claims of section 5.3, and those of the abstract and of the conclusion that it bears."""
    return [*_comparisons(flights), *_vibration(flights), *_limits(flights)]


def _vibration(flights: Flights) -> list[Claim]:
    own, healthy = flights["FASMC"], flights["FASMC, healthy"]
    error, size = vibration_error(healthy, LATE)
    return [
        Claim(
            "abstract, sec. 5.3, Fig. 4", "the vibration disturbance is counteracted in real time",
            f"healthy, 160 to 200 s: the modes' torque on the body is {size:.3f} N m, known to {error:.4f} N m (root "
            f"mean squares), and |q_ev| at most {largest(healthy, LATE):.1e}. Energy of the modes at 30 s and 78 s: "
            + ", ".join(
                f"{name} {1e3 * energy_at(flights[name], 30.0):.2f}, {1e3 * energy_at(flights[name], 78.0):.3f} mJ"
                for name in (*SCHEMES, "pd_dob", "pd_shaped"))
            + "; root mean square of their torque from 160 to 200 s: "
            + words({name: shaking(flights[name], LATE) for name in SCHEMES}, ".3f", " N m"),
            judge(error < 0.05 * size and largest(healthy, LATE) < 1e-5,
                  vibration_error(own, CALM)[0] < 0.05 * vibration_error(own, CALM)[1]),
            "their torque on the hub is, the vibration itself is not: a hub held still leaves the modes to their own "
            "damping, and FASMC leaves the most energy in them. Schemes that give way take it out",
        ),
    ]  # fmt: skip


def _times(flights: Flights, names: tuple[str, ...]) -> str:
    return "; ".join(
        f"{name} {seconds(settling(flights[name], FIRST))}, {seconds(settling(flights[name], SECOND))}"
        for name in names
    )


def _comparisons(flights: Flights) -> list[Claim]:
    ends = {name: largest(flights[name], LATE) for name in SCHEMES}
    calm = {name: largest(flights[f"{name}, healthy"], LATE) for name in SCHEMES}
    energy = {name: flights[name].energy(commanded=True) for name in SCHEMES}
    initial = {name: flights[name].energy(40.0, commanded=True) for name in SCHEMES}
    held = {name: flights[f"{name}, printed start"].energy(commanded=True) for name in SCHEMES}
    chatter = {name: flights[name].chatter() for name in SCHEMES}
    axes = {name: axis_errors(flights[name]) for name in SCHEMES}
    rivals = ("PD", "AISMC")
    faster = all(settling(flights["FASMC"], FIRST) < settling(flights[name], FIRST) for name in rivals)
    better = all(ends["FASMC"] < ends[name] for name in rivals)
    others = [name for name in SCHEMES if name != "FASMC"]
    return [
        Claim(
            "sec. 5.3, Figs. 10, 11", "all methods keep the attitude stable under the faults",
            f"largest |q_ev| from 160 to 200 s: {words(ends)}",
            judge(max(ends.values()) < 0.01, max(ends.values()) < 0.1),
            "a small neighbourhood is one of 0.1, which is 11 degrees",
        ),
        Claim(
            "sec. 1, sec. 5.3", "the proposed scheme has the smallest steady-state error",
            f"largest |q_ev| from 160 to 200 s: {words(ends)}; healthy: {words(calm)}",
            judge(all(ends["FASMC"] < ends[name] for name in others)),
            "RAFTSMC is one of its class",
        ),
        Claim(
            "sec. 5.3", "it converges faster and ends better than PD and AISMC",
            f"|q_ev| below 0.01 after, first and second manoeuvre: {_times(flights, SCHEMES)}; and at the end "
            f"{words({name: ends[name] for name in ('FASMC', *rivals)})}",
            judge(faster and better, settling(flights["FASMC"], FIRST) < settling(flights["PD"], FIRST) and better),
            "faster than PD as printed. Without the rest of g(s) PD is faster in both manoeuvres, AISMC in the first",
        ),
        Claim(
            "sec. 5.3", "RAFTSMC converges fastest",
            f"|q_ev| below 0.01 after, first and second manoeuvre: {_times(flights, SCHEMES)}",
            judge(False, all(settling(flights["RAFTSMC-class"], FIRST) < settling(flights[name], FIRST)
                             for name in SCHEMES if name != "RAFTSMC-class")),
            "one of its class, in the first manoeuvre; after the faults it does not come below 0.01 again",
        ),
        Claim(
            "sec. 1, sec. 5.3, Fig. 12", "the proposed scheme saves energy; AISMC and RAFTSMC spend more",
            f"integral of |u|^2 over 200 s: {words(energy, '.0f')}; over the first 40 s: {words(initial, '.0f')}; from "
            f"the printed start: {words(held, '.0f')} N^2 m^2 s",
            judge(energy["FASMC"] < min(energy["AISMC"], energy["RAFTSMC-class"])),
            "it spends the most in either reading of the start",
        ),
        Claim(
            "sec. 5.3", "PD takes little energy, converges slowly and ends worse",
            f"integral of |u|^2 {energy['PD']:.0f} N^2 m^2 s, below 0.01 after "
            f"{_times(flights, ('PD', 'PD gyroscopic'))}; at the end "
            + words({name: ends[name] for name in ("PD", "PD gyroscopic")}),
            judge(energy["PD"] < min(energy[name] for name in SCHEMES if name != "PD") and ends["PD"] > ends["FASMC"]),
            "taking off g(s) is what makes it slow: without, it is as fast as the others",
        ),
        Claim(
            "sec. 5.3, Fig. 12", "the gap in energy comes from the initial stage of the manoeuvre",
            "integral of |u|^2, FASMC minus the scheme, first 40 s and after: " + ", ".join(
                f"{name} {initial['FASMC'] - initial[name]:+.0f}, "
                f"{energy['FASMC'] - initial['FASMC'] - energy[name] + initial[name]:+.0f}" for name in others)
            + " N^2 m^2 s",
            judge(initial["AISMC"] > 1.05 * initial["FASMC"] and initial["RAFTSMC-class"] > 1.05 * initial["FASMC"],
                  all(abs(initial["FASMC"] - initial[name]) >
                      abs(energy["FASMC"] - initial["FASMC"] - energy[name] + initial[name])
                      for name in ("AISMC", "RAFTSMC-class"))),
            "the other way round: it is FASMC that spends more there",
        ),
        Claim(
            "abstract, sec. 5.3", "the torque fluctuates less: pole placement and a bounded v avoid radical torques",
            f"total variation of the commands: {words(chatter, '.2f', ' N m/s')}",
            judge(all(chatter["FASMC"] < chatter[name] for name in others)),
            "it fluctuates the most: it follows the vibration",
        ),
        Claim(
            "sec. 5.3, Fig. 11", "the time-varying fault affects the steady-state error more than the intermittent one",
            "largest MRP error from 160 to 200 s on their axes: " + ", ".join(
                f"{name} {error[0]:.1e} and {error[1]:.1e}" for name, error in axes.items()),
            judge(all(error[0] > error[1] for error in axes.values()), axes["FASMC"][0] > axes["FASMC"][1]),
            "for the schemes with an observer; the others keep an offset under the lasting fault",
        ),
    ]  # fmt: skip


def _limits(flights: Flights) -> list[Claim]:
    own, both = flights["FASMC"], flights["FASMC, sum"]
    sums = {
        name: float(np.abs(flight.command[:, 0]).sum(axis=1).max())
        for name, flight in (("wheel by wheel", own), ("sum", both))
    }
    size, control = virtual_control(own)
    lost = {name: flights[f"{name}, fast start"] for name in SCHEMES}
    pointing_lost = {name: float(flight.error[-1, 0]) for name, flight in lost.items()}
    ways = {name: flights[f"FASMC, {name}"] for name in ("q", "-q", "-q, short way")}
    spent = {name: flight.energy(commanded=True) for name, flight in ways.items()}
    aligned, misaligned = largest(flights["FASMC, aligned"], LATE), largest(own, LATE)
    return [
        Claim(
            "sec. 5.3, Fig. 9", "the torque keeps to |u|_1 < 5 N m",
            f"largest sum of magnitudes: {words(sums, '.1f', ' N m')}; |q_ev| below 0.01 after "
            f"{_times(flights, ('FASMC', 'FASMC, sum'))}; share of time that any wheel is at 5 N m "
            f"{100.0 * at_limit(own):.1f} %",
            judge(sums["wheel by wheel"] <= 5.0 + 1e-9, sums["sum"] <= 5.0 + 1e-9),
            "the limit is on the sum; 5 root 3, the bound on v in the appendix, goes with 5 N m for each wheel",
        ),
        Claim(
            "Theorem 2, sec. 5.3", "the virtual control is bounded, |v| < 5 root 3 N m, for |s(0)| < 0.1",
            f"at the start of a manoeuvre |s| is up to {size:.2f} rad/s and |v| up to {control:.1f} N m",
            judge(size < 0.1 and control < 5.0 * np.sqrt(3.0)),
            "s(0) of the example is far outside, and the bound is void",
        ),
        Claim(
            "Theorem 2, sec. 4.2", "the loop is globally asymptotically stable",
            f"energy in 80 s without faults: {words(spent, '.0f', ' N^2 m^2 s')}; angle turned over the shortest: "
            + words({name: float(flight.path_ratio()[0]) for name, flight in ways.items()}, ".1f")
            + f"; error after 200 s from {FAST:g} rad/s about each axis: {words(pointing_lost, '.1f', ' deg')}",
            judge(spent["-q"] < 1.1 * spent["q"] and pointing_lost["FASMC"] < 1.0),
            "from -q, the same attitude, it goes the long way round, which the sign of q_e would mend; from a fast "
            "start within the fuzzy sector the saturated torque loses it, and the proof leaves saturation out",
        ),
        Claim(
            "abstract, conclusion", "the scheme bears configuration misalignment",
            f"largest |q_ev| from 160 to 200 s: {misaligned:.1e} with, {aligned:.1e} without; before the faults, root "
            f"mean square of f^ - f {np.linalg.norm(fault_error(own, CALM)):.1e} and "
            f"{np.linalg.norm(fault_error(flights['FASMC, aligned'], CALM)):.1e} N m",
            judge(misaligned < 1.5 * aligned),
            "the degrees of the misalignment are degrees",
        ),
        Claim(
            "sec. 5.2, Table 1", "there is a manoeuvre from 0 to 40 s",
            f"from the printed start |q_ev| is {largest(flights['FASMC, printed start'], (0.0, 0.1)):.2f}, from that "
            f"of section 5.1 {largest(own, (0.0, 0.1)):.2f}; energy in 40 s: "
            f"{flights['FASMC, printed start'].energy(40.0, commanded=True):.0f} and "
            f"{own.energy(40.0, commanded=True):.0f} N^2 m^2 s",
            judge(largest(flights["FASMC, printed start"], (0.0, 0.1)) > 0.1, largest(own, (0.0, 0.1)) > 0.1),
            "the start of section 5.1; the printed one is the target itself",
        ),
        Claim(
            "sec. 5.2", "nothing happens to the attitude from 40 to 80 s, when the faults strike",
            "largest |q_ev| from 45 to 79 s: " + words(
                {name: largest(flights[name], (45.0, 79.0)) for name in (*SCHEMES, "FASMC without observer")}),
            judge(largest(own, (45.0, 79.0)) < 0.01, largest(own, (45.0, 79.0)) < 0.02),
            "small: below 0.02; without the observer the faults would show",
        ),
    ]  # fmt: skip
