"""The claims of Li, Xu and Chang 2023, and what their equations do in their example."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ftac_gym.reproduction.claims import Claim, judge
from ftac_gym.reproduction.flight import Flight
from ftac_gym.reproduction.li_2023.control_claims import control_claims
from ftac_gym.reproduction.li_2023.measures import (
    CALM,
    LATE,
    SECOND,
    during,
    fault_error,
    fault_torque,
    inequalities,
    lag,
    largest,
    rate_error,
    refused,
    symmetric_growth,
    vibration_error,
    words,
)
from ftac_gym.reproduction.li_2023.model import loop_errors, term_errors
from ftac_gym.reproduction.li_2023.plans import BOUNDS

Flights = Mapping[str, Flight]


def claims(flights: Flights) -> list[Claim]:
    """Return the claims of the abstract, of sections 3 to 5 and of the conclusion."""
    return [*_model(), *_design(flights), *_observer(flights), *control_claims(flights)]


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
            "sec. 5.1, remark 6", "models in which fewer rules fire are worse",
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
            "conclusion, sec. 5.2", "the matrix inequalities are easily solved, with high numerical stability",
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
            f"rates stay below {float(np.abs(own.rate).max()):.2f} rad/s of 0.7: all rules fire nearly alike",
        ),
    ]  # fmt: skip


def _observer(flights: Flights) -> list[Claim]:
    own, weak, calm = flights["FASMC"], flights["FASMC, weak"], flights["FASMC, healthy"]
    assert own.disturbance is not None
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
    channels, late = fault_error(own, LATE), during(own, LATE)[:-1]
    size = np.abs(fault_torque(own)[late]).max(axis=0)
    biggest = float(np.abs(own.disturbance[:, 0] - fault_torque(own))[late].max())
    zero = rate_error(flights["FASMC, from zero"], CALM)
    quiet = [float(np.linalg.norm(fault_error(flight, CALM))) for flight in (own, learning)]
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
            f"faults of up to {', '.join(f'{value:.2f}' for value in size)} N m; largest {biggest:.3f} N m",
            judge(bool((channels < 0.05).all()), bool((channels < 0.2).all())),
            f"small: below 0.2 N m in the root mean square. The time-varying fault is followed {lag(own):.2f} s late",
        ),
        Claim(
            "sec. 5.2, Figs. 7, 8", "the observer errs less on faults than an ILO, most for weak ones",
            f"root mean square of f^ - f from 160 to 200 s: {words(errors, '.3f', ' N m')}; before the "
            f"faults: FAFEO {quiet[0]:.4f}, ILO-class {quiet[1]:.3f} N m",
            judge(errors["FAFEO"] < errors["ILO-class"] and errors["FAFEO, weak faults"] < errors["ILO-class, weak"],
                  errors["FAFEO, weak faults"] < errors["ILO-class, weak"] and quiet[0] < quiet[1]),
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
