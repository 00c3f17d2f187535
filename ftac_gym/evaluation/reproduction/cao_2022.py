"""What Cao, Gong and Han 2022 claim, and what their equations do in their example."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ftac_gym.attitude import mrp_derivative
from ftac_gym.baselines.predefined_time import PredefinedTime
from ftac_gym.evaluation.reproduction import figures
from ftac_gym.evaluation.reproduction.cao_2022_plans import EXPONENTS, OBSERVERS, PERIODS, TIMES, limit_name
from ftac_gym.evaluation.reproduction.claims import Claim, Reproduction, judge
from ftac_gym.evaluation.reproduction.flight import Flight
from ftac_gym.evaluation.reproduction.variations import UNLIMITED, seconds, settled
from ftac_gym.evaluation.tables import Cells
from ftac_gym.parameters import FloatArray

ONSETS = (5.0, 8.0, 10.0)
"""When the wheels weaken [s]."""

TOLERANCE = 0.05
"""Error of an effectiveness that counts as known."""

PRINTED_FIRST = np.array([[8.0, 0.0, 0.0], [0.0, 15.0, 0.0], [0.0, 0.0, 12.0], [10.0, 0.0, 1.2]])
PRINTED_SECOND = np.array([[20.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 8.0], [1.0, 0.5, 6.5]])
PRINTED_RATE_GAIN = 50.0
"""H1, H2 and the smallest eigenvalue of M of Table 1."""


def known_after(flight: Flight, wheel: int) -> float:
    """Return how long after its fault a wheel's effectiveness is known for good [s]; infinity if never."""
    assert flight.effectiveness is not None
    error = np.abs(flight.effectiveness - flight.true_effectiveness)[:, 0, wheel]
    wrong = np.flatnonzero(error > TOLERANCE)
    if len(wrong) == 0:
        return 0.0
    if wrong[-1] == len(error) - 1:
        return float("inf")
    return max(0.0, float(flight.time[wrong[-1] + 1]) - ONSETS[wheel])


def _known(flight: Flight) -> str:
    times = (known_after(flight, wheel) for wheel in range(3))
    return ", ".join(f"e{wheel + 1} {seconds(time)}" for wheel, time in enumerate(times))


def closed_forms(flight: Flight, time: float) -> tuple[float, float]:
    """Return when s and the error reach zero by the closed forms [s], from the flight's start and from its s = 0."""
    position, rate = PredefinedTime(0.25, time), PredefinedTime(0.3, time)
    reached = float(rate.reaching_time(0.5 * _square(_variable(flight, position)[0])))
    start = min(len(flight.time) - 1, round(reached / flight.scenario.control_period))
    return reached, reached + float(position.reaching_time(0.5 * _square(flight.attitude[start, 0])))


def _variable(flight: Flight, position: PredefinedTime) -> FloatArray:
    """Return s (T + 1, 3) [1/s] of the first craft."""
    sigma = flight.attitude[:, 0]
    gain = position.gain(0.5 * np.einsum("ti,ti->t", sigma, sigma)[:, None])
    variable: FloatArray = mrp_derivative(sigma, flight.rate[:, 0]) + gain * sigma
    return variable


def _square(vector: FloatArray) -> FloatArray:
    square: FloatArray = np.asarray(vector @ vector)
    return square


def theorem_bounds() -> tuple[float, float]:
    """Return upper bounds of c1 and c3 of Theorem 1 for the printed gains; both must be positive.

    Its b3 and b4, and the factor (1 + chi + ...), exceed one whatever its free numbers a_i are, and k > 0.
    """
    first, second = (float(np.linalg.norm(gain, 2)) for gain in (PRINTED_FIRST, PRINTED_SECOND))
    return PRINTED_RATE_GAIN - 1.0 - first**2, 1.0 - second**2


def claims(flights: Mapping[str, Flight]) -> list[Claim]:
    """Return the claims of the abstract, of section 5 and of the conclusion."""
    printed, usable, tsmc = flights["PTC as printed"], flights["PTC"], flights["TSMC-class"]
    turning = {label: flights[f"turning, {label}"] for label in OBSERVERS}
    resting = {"LO as printed": printed, "LO corrected": usable, "ASMO": flights["PTC, ASMO"]}
    slowest = {name: max(known_after(flight, wheel) for wheel in range(3)) for name, flight in turning.items()}
    at_rest = {name: max(known_after(flight, wheel) for wheel in range(3)) for name, flight in resting.items()}
    c1, c3 = theorem_bounds()
    starts = _arrivals(flights["starts, unlimited"])
    limited, weak = (_arrivals(flights[f"starts, {limit} N m"]) for limit in (5, 1))
    times = {time: flights[f"T1 = T2 = {time:g} s, unlimited"].settling(0.1) for time in TIMES}
    mismatch = {name: _mismatch(flight) for name, flight in turning.items()}
    moving = "reference moving all the time, so that there is torque to learn from"

    def found(flown: Mapping[str, Flight]) -> str:
        return "; ".join(f"{name}: {_known(flight)}" for name, flight in flown.items())

    layered = flights["PTC, layer 0.05"]
    quiet, quiet_layered = _quiet(usable), _quiet(layered)
    after, after_layered = _shaken(usable), _shaken(layered)
    gentle = {name: (np.abs(flight.command[:, 0]).max(), flight.chatter()) for name, flight in
              (("PTC", usable), ("PTC, layer 0.05", flights["PTC, layer 0.05"]), ("TSMC-class", tsmc))}  # fmt: skip
    return [
        Claim(
            "abstract, sec. 5, Fig. 2", "the learning observer estimates the effectiveness quickly and accurately",
            "known to 0.05 after its fault, moving reference: " + found(turning),
            judge(np.isfinite(slowest["LO as printed"]), np.isfinite(slowest["LO corrected"])),
            f"corrected form (sign of the torque, no forgetting, no sign term, a tenth of the gains); {moving}",
        ),
        Claim(
            "sec. 5", "the learning observer finds every fault within 3 s",
            "at rest, as in the paper: " + found(resting) + "; moving: " + _known(turning["LO corrected"]),
            judge(at_rest["LO as printed"] <= 3.0, slowest["LO corrected"] <= 3.0),
            f"corrected form; {moving}",
        ),
        Claim(
            "sec. 5", "the adaptive sliding-mode observer takes about 8 s for constant faults",
            "moving: " + _known(turning["ASMO"]) + "; at rest: " + _known(resting["ASMO"]),
            judge(
                all(known_after(resting["ASMO"], wheel) < 12.0 for wheel in (0, 1)),
                all(known_after(turning["ASMO"], wheel) < 12.0 for wheel in (0, 1)),
            ),
            f"its gains are not printed; with our usable ones it is about as fast as the learning observer; {moving}",
        ),
        Claim(
            "sec. 5", "the adaptive sliding-mode observer estimates varying faults poorly, the learning observer well",
            f"moving, largest error of e3 in the last 10 s: ASMO {turning['ASMO'].estimate_error()[2]:.3f}, LO as "
            f"printed {turning['LO as printed'].estimate_error()[2]:.3f}, corrected "
            f"{turning['LO corrected'].estimate_error()[2]:.3f}",
            judge(
                turning["LO as printed"].estimate_error()[2] < 0.5 * turning["ASMO"].estimate_error()[2],
                turning["LO corrected"].estimate_error()[2] < 0.5 * turning["ASMO"].estimate_error()[2],
            ),
            f"corrected form; {moving}",
        ),
        Claim(
            "sec. 5, Fig. 4", "both observers follow the rate closely",
            "moving, largest |w~| in the last 10 s: "
            + ", ".join(f"{name} {value:.1e} rad/s" for name, value in mismatch.items()),
            judge(
                mismatch["LO as printed"] < 1e-2 and mismatch["ASMO"] < 1e-2,
                mismatch["LO corrected"] < 1e-2 and mismatch["ASMO"] < 1e-2,
            ),
            "corrected form; a small rate error is no sign of a good estimate",
        ),
        Claim(
            "Theorem 1", "with the gains of Table 1 the errors of the learning observer converge to a small interval",
            f"c1 < {c1:.0f} and c3 < {c3:.0f} whatever the free numbers are; printed observer: "
            + _known(turning["LO as printed"]),
            judge(c1 > 0.0 and c3 >= 0.0),
            "the theorem asks for c1 > 0 and c3 >= 0",
        ),
        Claim(
            "abstract, Theorem 2, Fig. 5", "the attitude follows its command within the predefined time, here 20 s",
            f"as printed: 0.1 deg {settled(printed)}, steady up to {printed.steady():.1f} deg; h1 = 0.5 with E^ = I: "
            f"{settled(flights['PTC h1 = 0.5, E^ = I'])}; regularised: "
            f"{settled(flights['PTC h1 = 0.5, regularised'])}; h1 = 0.25: {settled(usable)}",
            judge(printed.settling(0.1) <= 20.0, usable.settling(0.1) <= 20.0),
            "h1 = 0.25; h1 = 0.5 asks for infinite torque at the target and has a limit cycle there",
        ),
        Claim(
            "abstract, sec. 1", "the convergence time can be set by one parameter",
            ", ".join(f"T1 = T2 = {time:g} s: 0.1 deg after {value:.2f} s" for time, value in times.items()),
            judge(False, bool(np.ptp([value / time for time, value in times.items()]) < 0.1)),
            "h1 = 0.25, unlimited torque: the time is in proportion to T, and well below it",
        ),
        Claim(
            "abstract, sec. 1", "the convergence time does not depend on the initial state",
            f"64 random starts, unlimited: {starts.min():.2f} to {starts.max():.2f} s; 5 N m: {limited.min():.1f} to "
            f"{limited.max():.1f} s",
            judge(bool(np.ptp(starts) < 0.1)),
            "the bound T1 + T2 does not; the time does, by the closed forms T (1 - exp(-V^h)) (study)",
        ),
        Claim(
            "Theorem 2", "T1 + T2 bounds the time from every start",
            f"64 random starts, unlimited: at most {starts.max():.1f} s of 20; 5 N m: at most "
            f"{seconds(float(limited.max()))}; 1 N m: at most {seconds(float(weak.max()))}",
            judge(bool(starts.max() <= 20.0 and weak.max() <= 20.0), bool(starts.max() <= 20.0)),
            "h1 = 0.25 and wheels that do not saturate",
        ),
        Claim(
            "sec. 5, Fig. 6", "without a fault the rates are near zero after 3 s",
            f"h1 = 0.25, below 0.1 deg/s until the first fault at 5 s from: sign {seconds(quiet)}, layer 0.05 "
            f"{seconds(quiet_layered)}",
            judge(quiet <= 3.0, quiet_layered <= 3.0),
            "the slew is not over after 3 s; with the sign the rates chatter",
        ),
        Claim(
            "sec. 5, Fig. 6", "after each fault the rates move little and recover within 2 s",
            "largest rate in the 2 s after each fault: sign "
            + ", ".join(f"{value:.3f}" for value in after)
            + " deg/s; layer 0.05 "
            + ", ".join(f"{value:.3f}" for value in after_layered),
            judge(max(after) < 0.1, max(after_layered) < 0.1),
            "h1 = 0.25 and a layer; the craft is at rest by then and needs no torque",
        ),
        Claim(
            "sec. 5, Figs. 6, 7", "the torque of the scheme is gentle compared with TSMC",
            "largest torque and total variation: "
            + ", ".join(f"{name} {peak:.1f} N m, {change:.1f} N m/s" for name, (peak, change) in gentle.items()),
            judge(gentle["PTC"] < gentle["TSMC-class"] and gentle["PTC"][1] < gentle["TSMC-class"][1]),
            "TSMC-class, with our gains",
        ),
        Claim(
            "conclusion", "the estimate of the effectiveness makes the controller tolerate the faults",
            f"0.1 deg after: E^ = I {settled(flights['PTC, E^ = I'])}, observer {settled(usable)}, exact E "
            f"{settled(flights['PTC, oracle'])}; struck in the slew: "
            f"{settled(flights['PTC, struck in the slew, E^ = I'])}, {settled(flights['PTC, struck in the slew'])}, "
            f"{settled(flights['PTC, struck in the slew, oracle'])}",
            judge(
                usable.settling(0.1) < 0.95 * flights["PTC, E^ = I"].settling(0.1),
                flights["PTC, struck in the slew"].settling(0.1)
                < 0.95 * flights["PTC, struck in the slew, E^ = I"].settling(0.1),
            ),
            "the switching term and the feedback do it without an estimate",
        ),
    ]  # fmt: skip


def _arrivals(flight: Flight) -> FloatArray:
    return np.array([flight.settling(0.1, craft) for craft in range(flight.error.shape[1])])


def _quiet(flight: Flight) -> float:
    """Return from when on the rate stays below 0.1 deg/s until the first fault [s]; infinity if it does not."""
    rate = np.degrees(np.linalg.norm(flight.rate[:, 0], axis=1))[flight.time < ONSETS[0] - 1e-9]
    last = int(np.flatnonzero(rate > 0.1)[-1])
    return float(flight.time[last + 1]) if last + 1 < len(rate) else float("inf")


def _shaken(flight: Flight) -> list[float]:
    """Return the largest rate in the two seconds after each fault [deg/s]."""
    rate, time = np.degrees(np.linalg.norm(flight.rate[:, 0], axis=1)), flight.time
    return [float(rate[(time >= onset) & (time < onset + 2.0)].max()) for onset in ONSETS]


def _mismatch(flight: Flight) -> float:
    assert flight.rate_mismatch is not None
    late = flight.time[1:] >= flight.time[-1] - 10.0
    return float(np.linalg.norm(flight.rate_mismatch[late, 0], axis=1).max())


def studies(flights: Mapping[str, Flight]) -> dict[str, Cells]:
    """Return the tables that settle the claims."""
    schemes: Cells = [["flight", "0.1 deg after", "steady [deg]", "largest torque [N m]", "chatter [N m/s]"]]
    for name, flight in flights.items():
        if name.startswith(("PTC", "TSMC", "turning")):
            row = [settled(flight), f"{flight.steady():.5f}", f"{np.abs(flight.command).max():.1f}"]
            schemes.append([name, *row, f"{flight.chatter():.1f}"])
    forms: Cells = [["T1 = T2", "s = 0 by closed form", "measured", "error = 0 by closed form", "0.01 deg, measured"]]
    for time in TIMES:
        flight = flights[f"T1 = T2 = {time:g} s, unlimited"]
        reached, arrived = closed_forms(flight, time)
        size = np.linalg.norm(_variable(flight, PredefinedTime(0.25, time)), axis=1)
        first = float(flight.time[np.argmax(size < 1e-6)])
        row = [f"{reached:.3f} s", f"{first:.3f} s", f"{arrived:.3f} s", f"{flight.settling(0.01):.3f} s"]
        forms.append([f"{time:g} s", *row])
    steps: Cells = [["h1", "torque limit", "10 ms", "1 ms"]]
    for exponent in EXPONENTS:
        for limit in (UNLIMITED, 5.0):
            pair = [flights[f"step: h1 = {exponent}, {limit_name(limit)}, {period} s"] for period in (0.01, 0.001)]
            cells = [f"{settled(c, 1.0)}, {c.steady(5.0):.1e} deg, {np.abs(c.command).max():.3g} N m" for c in pair]
            steps.append([f"{exponent}", limit_name(limit), *cells])
    holds: Cells = [["period [ms]", "unlimited, sign", "unlimited, layer 0.1", "5 N m, sign", "5 N m, layer 0.1"]]
    for period in PERIODS:
        cells = []
        for limit in (UNLIMITED, 5.0):
            for layer in (0.0, 0.1):
                flight = flights[f"hold: {period} s, {limit_name(limit)}, {layer}"]
                cells.append(f"{settled(flight, 1.0)}, {flight.steady():.1e} deg")
        holds.append([f"{1000 * period:g}", *cells])
    return {
        "All schemes and comparators": schemes,
        "Closed forms of the predefined times (h1 = 0.25, no switching term, 1 ms)": forms,
        "Step size (no fault, no disturbance): 1 deg after, steady error, largest torque": steps,
        "Sampling (faults and disturbance as printed, E^ = I, h1 = 0.25)": holds,
    }


def evaluate(flights: Mapping[str, Flight]) -> Reproduction:
    """Judge the claims and draw the figures."""
    compared = {name: flights[name] for name in ("PTC as printed", "PTC", "TSMC-class")}
    observed = {label: flights[f"turning, {label}"] for label in OBSERVERS}
    drawn = {
        "attitude": figures.attitude(compared),
        "rates": figures.rates(compared),
        "torque": figures.torque(compared),
        "estimates": figures.estimates({**observed, "PTC, at rest": flights["PTC"]}),
        "schemes": figures.errors(
            {name: flights[name] for name in ("PTC as printed", "PTC", "PTC, E^ = I", "PTC, oracle", "TSMC-class")}
        ),
    }
    return Reproduction(claims(flights), studies(flights), drawn)
