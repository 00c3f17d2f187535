"""The claims of Li, Xu and Chang 2023, and what their equations do in their example."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ftac_gym.evaluation.reproduction.claims import Claim, judge
from ftac_gym.evaluation.reproduction.flight import Flight
from ftac_gym.evaluation.reproduction.li_2023_measures import (
    FIRST,
    LATE,
    SECOND,
    energy_at,
    fault_error,
    inequalities,
    largest,
    rate_error,
    refused,
    settling,
    shaking,
    swings,
    symmetric_growth,
    vibration_error,
    words,
)
from ftac_gym.evaluation.reproduction.li_2023_model import loop_errors, term_errors
from ftac_gym.evaluation.reproduction.li_2023_plans import BOUNDS, SCHEMES
from ftac_gym.evaluation.reproduction.variations import seconds

Flights = Mapping[str, Flight]

CALM = (15.0, 39.5)
"""After the observer's transient, before the faults [s]."""


def claims(flights: Flights) -> list[Claim]:
    """Return the claims of the abstract, of sections 3 to 5 and of the conclusion."""
    return [*_model(), *_design(flights), *_observer(flights), *_control(flights), *_limits(flights)]


def _model() -> list[Claim]:
    loops, terms = loop_errors(), term_errors()
    exact = max(loops["triangular sets"], terms["triangular sets"])
    return [
        Claim(
            "abstract, sec. 5.1, Fig. 3", "the fuzzy model with three premise variables and eight rules fits the craft",
            f"largest difference of the quaternion in closed loop: {words(loops)}; of w' at random rates below "
            f"0.1 rad/s, relative: {words(terms)}",
            judge(exact < 1e-12),
            "with triangular sets, which the paper draws but does not print, it is no approximation",
        ),
        Claim(
            "sec. 5.1, conclusion", "models in which fewer rules fire are worse",
            f"one rule at a time: quaternion off by {loops['nearest rule']:.2g} in closed loop, triangular sets by "
            f"{loops['triangular sets']:.1g}",
            judge(False, loops["nearest rule"] > 10.0 * loops["triangular sets"]),
            "by the nearest rule, which stands for the model compared with: its equations are not in the paper",
        ),
    ]  # fmt: skip


def _design(flights: Flights) -> list[Claim]:
    found = inequalities()
    first, second = (found[f"Theorem {number}, published, delta(3,3) -"] for number in (1, 2))
    plus = found["Theorem 1, published, delta(3,3) +"]
    other = found["Theorem 2, published, delta(3,3) +"]
    own, mean = flights["FASMC"], flights["FASMC, mean gains"]
    off = float(np.abs(own.attitude - mean.attitude).max())
    return [
        Claim(
            "appendix A.1", "the published observer gains hold gamma_1 = 1.6563 and the disc O(-10, 10)",
            f"with delta(3,3) = -0.83674: gamma_1 = {first.gamma:.4f}, farthest pole {first.reach:.3f} from -10; with "
            f"+0.83674: rules {', '.join(str(rule) for rule in plus.outside)} leave the disc, to {plus.reach:.3f}",
            judge(plus.holds and plus.gamma <= 1.6563, first.holds and first.gamma <= 1.6563),
            "delta(3,3) with the other sign than printed",
        ),
        Claim(
            "appendix A.2", "the published controller gains hold gamma_2 = 1.7919",
            f"with delta(3,3) = -0.83674: gamma_2 = {second.gamma:.4f}; with +0.83674: {other.gamma:.4f}, and no gains "
            f"do better than {found['Theorem 2, solved, delta(3,3) +'].gamma:.4f}",
            judge(other.gamma <= 1.7919, second.holds and second.gamma <= 1.7919),
            "delta(3,3) with the other sign, K = Y X^-1 and the disc about -20: about +20 nothing is stable",
        ),
        Claim(
            "sec. 5.2", "gamma_1^2 <= 0.1",
            f"solving says: {refused()}",
            judge(found["Theorem 1, solved, delta(3,3) -"].gamma ** 2 <= 0.1),
            "a constant d_1 is a fault to the observer: gamma_1 is never below 1",
        ),
        Claim(
            "conclusion, remark 7", "the matrix inequalities are easily solved, with high numerical stability",
            "; ".join(
                f"{name.split(',')[0]} gamma = {item.gamma:.4f} in {item.seconds:.1f} s"
                for name, item in found.items() if "solved" in name and name.endswith("-")),
            judge(False, all(item.holds for name, item in found.items() if "solved" in name)),
            "with scaled errors and an interior-point solver; the results are proved afterwards",
        ),
        Claim(
            "sec. 4.2, proof (49)", "A_i + B K_i Hurwitz makes s'(A_i + B K_i)s negative",
            f"largest eigenvalue of the symmetric part: at least {symmetric_growth():+.2f} 1/s at every rule",
            judge(symmetric_growth() < 0.0),
            "a stable matrix can have growing directions; the loop is stable all the same, by the other P",
        ),
        Claim(
            "abstract, sec. 2", "the scheduling of the gains with the rate is what copes with the nonlinearity",
            f"with the mean of all eight gains the MRPs differ by at most {off:.1e}",
            judge(off > 0.01),
            "rates stay below 0.15 rad/s, a fifth of the sector: the rules fire nearly alike",
        ),
    ]  # fmt: skip


def _observer(flights: Flights) -> list[Claim]:
    own, weak, calm = flights["FASMC"], flights["FASMC, weak"], flights["FASMC, healthy"]
    learning, learning_weak = flights["FASMC with ILO-class"], flights["FASMC with ILO-class, weak"]
    before, after = rate_error(own, CALM), rate_error(own, LATE)
    switching = rate_error(own, SECOND)
    windows = {"15 to 40 s": CALM, "160 to 200 s": LATE}
    pulls = {name: vibration_error(own, window) for name, window in windows.items()}
    healthy = vibration_error(calm, LATE)
    errors = {
        name: float(np.linalg.norm(fault_error(flight, LATE)))
        for name, flight in (
            ("FAFEO", own),
            ("FAFEO, weak faults", weak),
            ("ILO-class", learning),
            ("ILO-class, weak", learning_weak),
        )
    }
    channels = fault_error(own, LATE)
    zero = rate_error(flights["FASMC, from zero"], CALM)
    return [
        Claim(
            "sec. 5.2, Fig. 6", "|w - w^| is below 4e-7 rad/s in 15 s",
            f"largest from 15 to 40 s: {before:.1e} rad/s; without disturbance and misalignment "
            f"{rate_error(flights['FASMC, undisturbed'], CALM):.1e}; starting from zero {zero:.1e}",
            judge(before < 4e-7, rate_error(flights["PD gyroscopic"], (35.0, 40.0)) < 4e-7),
            "for PD without the rest of g(s), after 35 s",
        ),
        Claim(
            "sec. 5.2, Fig. 6", "|w - w^| is below 3e-5 rad/s once the faults act",
            f"largest from 160 to 200 s: {after:.1e} rad/s; from 80 s on, with the switch of the second fault, "
            f"{switching:.1e} rad/s",
            judge(switching < 3e-5, after < 3e-5),
            "away from the steps of the intermittent fault",
        ),
        Claim(
            "abstract, sec. 5.2, Fig. 5", "the vibration is estimated without measuring it, robustly against faults",
            "; ".join(f"{name}: error {error:.3f} of {size:.3f} N m" for name, (error, size) in pulls.items())
            + f" (root mean squares); healthy, 160 to 200 s: {healthy[0]:.4f} of {healthy[1]:.3f} N m",
            judge(all(error < 0.1 * size for error, size in pulls.values()), healthy[0] < 0.1 * healthy[1]),
            "healthy; a fault that changes goes into the estimate of the vibration as well",
        ),
        Claim(
            "abstract, sec. 5.2, Fig. 7", "the faults are estimated, to small bounded errors",
            f"root mean square of f^ - f from 160 to 200 s: {', '.join(f'{value:.3f}' for value in channels)} N m, for "
            "faults of up to 1.3, 1.5 and 0 N m",
            judge(bool((channels < 0.05).all()), bool((channels < 0.2).all())),
            "small: below 0.2 N m. The time-varying fault is followed with a lag of about 1 s",
        ),
        Claim(
            "sec. 5.2, Figs. 7, 8", "the observer errs less on faults than an ILO, most for weak ones",
            f"root mean square of f^ - f from 160 to 200 s: {words(errors, '.3f', ' N m')}; calm, 15 to 40 s: FAFEO "
            f"{np.linalg.norm(fault_error(own, CALM)):.3f}, ILO-class "
            f"{np.linalg.norm(fault_error(learning, CALM)):.3f} N m",
            judge(errors["FAFEO"] < errors["ILO-class"] and errors["FAFEO, weak faults"] < errors["ILO-class, weak"],
                  errors["FAFEO, weak faults"] < errors["ILO-class, weak"]),
            "for weak faults and before the faults. The ILO counts vibration as a fault, but follows a changing fault "
            "faster; its gains are ours",
        ),
        Claim(
            "sec. 3.1, (17), appendix", "|d^|_1 <= 0.2 and |f^| <= 2 are safe projections",
            f"|w - w^| from 15 to 40 s, started from zero: {zero:.1e} rad/s, with the first "
            f"{rate_error(flights['FASMC, from zero, bounded'], CALM):.1e}; half the effectiveness on top: |q_ev| at "
            "the end " + ", ".join(
                f"f_max = {bound:g}: {largest(flights[f'FASMC, half, {bound:g} N m'], LATE):.1e}" for bound in BOUNDS),
            judge(rate_error(flights["FASMC, from zero, bounded"], CALM) < 2.0 * zero
                  and largest(flights[f"FASMC, half, {BOUNDS[0]:g} N m"], LATE) < 2e-3,
                  rate_error(flights["FASMC, bounded"], CALM) < 2.0 * before),
            "the observer starts at the truth, and f_max exceeds the whole of (E - I) u + f",
        ),
    ]  # fmt: skip


def _times(flights: Flights, names: tuple[str, ...]) -> str:
    return "; ".join(
        f"{name} {seconds(settling(flights[name], FIRST))}, {seconds(settling(flights[name], SECOND))}"
        for name in names
    )


def _control(flights: Flights) -> list[Claim]:
    ends = {name: largest(flights[name], LATE) for name in SCHEMES}
    calm = {name: largest(flights[f"{name}, healthy"], LATE) for name in SCHEMES}
    energy = {name: flights[name].energy() for name in SCHEMES}
    initial = {name: flights[name].energy(40.0) for name in SCHEMES}
    held = {name: flights[f"{name}, printed start"].energy() for name in SCHEMES}
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
            "abstract, sec. 5.3, conclusion", "the proposed scheme has the smallest steady-state error",
            f"largest |q_ev| from 160 to 200 s: {words(ends)}; healthy: {words(calm)}",
            judge(all(ends["FASMC"] < ends[name] for name in others)),
            "RAFTSMC is one of its class",
        ),
        Claim(
            "sec. 5.3", "it converges faster and ends better than PD and AISMC",
            f"|q_ev| below 0.01 after, first and second manoeuvre: {_times(flights, SCHEMES)}; and at the end "
            f"{words({name: ends[name] for name in ('FASMC', *rivals)})}",
            judge(faster and better, settling(flights["FASMC"], FIRST) < settling(flights["PD"], FIRST) and better),
            "faster than PD alone; AISMC is faster in the first manoeuvre, before the faults",
        ),
        Claim(
            "sec. 5.3", "RAFTSMC converges fastest",
            f"|q_ev| below 0.01 after, first and second manoeuvre: {_times(flights, SCHEMES)}",
            judge(False, all(settling(flights["RAFTSMC-class"], FIRST) < settling(flights[name], FIRST)
                             for name in SCHEMES if name != "RAFTSMC-class")),
            "one of its class, in the first manoeuvre; after the faults it does not come below 0.01 again",
        ),
        Claim(
            "abstract, sec. 5.3, Fig. 12", "the proposed scheme saves energy; AISMC and RAFTSMC spend more",
            f"integral of |u|^2 over 200 s: {words(energy, '.0f')}; over the first 40 s: {words(initial, '.0f')}; from "
            f"the printed start: {words(held, '.0f')} N^2 m^2 s",
            judge(energy["FASMC"] < min(energy["AISMC"], energy["RAFTSMC-class"])),
            "it spends the most in either reading of the start",
        ),
        Claim(
            "sec. 5.3", "PD takes little energy, converges slowly and ends worse",
            f"energy {energy['PD']:.0f} N^2 m^2 s, below 0.01 after {_times(flights, ('PD', 'PD gyroscopic'))}; at the "
            f"end {words({name: ends[name] for name in ('PD', 'PD gyroscopic')})}",
            judge(energy["PD"] < min(energy[name] for name in SCHEMES if name != "PD") and ends["PD"] > ends["FASMC"]),
            "taking off g(s) is what makes it slow: without, it is as fast as the others",
        ),
        Claim(
            "abstract, sec. 5.3, Fig. 4", "the vibration is counteracted in real time",
            "energy of the modes at 30 s and at 78 s: " + ", ".join(
                f"{name} {1e3 * energy_at(flights[name], 30.0):.2f}, {1e3 * energy_at(flights[name], 78.0):.3f} mJ"
                for name in (*SCHEMES, "pd_dob"))
            + "; torque of the modes from 160 to 200 s: "
            + words({name: shaking(flights[name], LATE) for name in SCHEMES}, ".3f", " N m"),
            judge(energy_at(flights["FASMC"], 78.0) < min(energy_at(flights[name], 78.0) for name in others)),
            "its torque is, the vibration is not: a hub held still leaves the modes to their own damping. The schemes "
            "that give way take the energy out",
        ),
    ]  # fmt: skip


def _limits(flights: Flights) -> list[Claim]:
    own, both = flights["FASMC"], flights["FASMC, sum"]
    sums = {
        name: float(np.abs(flight.command[:, 0]).sum(axis=1).max())
        for name, flight in (("wheel by wheel", own), ("sum", both))
    }
    start = swings(own)
    ways = {name: flights[f"FASMC, {name}"] for name in ("q", "-q", "-q, short way")}
    spent = {name: flight.energy() for name, flight in ways.items()}
    aligned, misaligned = largest(flights["FASMC, aligned"], LATE), largest(own, LATE)
    return [
        Claim(
            "sec. 5.3, Fig. 9", "the torque keeps to |u|_1 < 5 N m",
            f"largest sum of magnitudes: {words(sums, '.1f', ' N m')}; |q_ev| below 0.01 after "
            f"{_times(flights, ('FASMC', 'FASMC, sum'))}; share of time a wheel is at 5 N m "
            f"{100.0 * own.saturated():.1f} %",
            judge(sums["wheel by wheel"] <= 5.0 + 1e-9, sums["sum"] <= 5.0 + 1e-9),
            "the limit is on the sum; 5 root 3, the bound on v in the appendix, goes with 5 N m for each wheel",
        ),
        Claim(
            "Theorem 2, sec. 5.3", "the virtual control is bounded, |v| < 5 root 3 N m, for |s(0)| < 0.1",
            f"|w| + 2 |q_ev| at the start of a manoeuvre is up to {start:.2f} rad/s, so that |v| is up to "
            f"{start * 35.0:.0f} N m",
            judge(start < 0.1),
            "s(0) of the example is far outside, and the bound is void",
        ),
        Claim(
            "Theorem 2, sec. 4.2", "the loop is globally asymptotically stable",
            f"energy in 80 s without faults: {words(spent, '.0f', ' N^2 m^2 s')}; angle turned over the shortest: "
            + words({name: float(flight.path_ratio()[0]) for name, flight in ways.items()}, ".1f"),
            judge(spent["-q"] < 1.1 * spent["q"], spent["-q, short way"] < 1.1 * spent["q"]),
            "with the sign of q_e chosen; as printed, the same attitude as -q makes it go the long way round",
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
            f"{flights['FASMC, printed start'].energy(40.0):.0f} and {own.energy(40.0):.0f} N^2 m^2 s",
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
