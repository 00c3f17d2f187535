"""Claims of Cao, Gong and Han 2022, judged by flights of their example; ``claims.toml`` holds their texts."""

from __future__ import annotations

import numpy as np

from ftac_gym.reproduction.cao_2022 import measures
from ftac_gym.reproduction.cao_2022.measures import TOLERANCE
from ftac_gym.reproduction.cao_2022.plans import OBSERVERS, TIMES
from ftac_gym.reproduction.recordings import Recording, Recordings
from ftac_gym.reproduction.verdicts import Finding, Measure
from ftac_gym.reproduction.wording import listed, listed_times, seconds, settled

LEARNING = ("LO as printed", "LO corrected")
USABLE = ("h1 = 0.25, sign", "layer 0.05")


MEASURES: dict[str, Measure] = {
    "accuracy": lambda flight: f"{settled(flight)}, {flight.steady():.4f} deg",
    "estimated": measures.estimated,
}
"""Measures for the texts."""


def findings(flights: Recordings) -> dict[str, Finding]:
    """Return the findings for the claims of the abstract, of section 5 and of the conclusion."""
    return {**_observers(flights), **_times(flights), **_controller(flights)}


def _about_eight(recording: Recording) -> bool:
    return all(4.0 < measures.estimated_after(recording, wheel) < 12.0 for wheel in (0, 1))


def _observers(flights: Recordings) -> dict[str, Finding]:
    turning = flights.chosen(OBSERVERS, "turning, {}")
    rest = flights.relabelled({"LO as printed": "PTC as printed", "LO corrected": "PTC", "ASMO": "PTC, ASMO"})
    times, times_rest = (listed(group.measured(measures.estimated), "{}", "; ", ": ") for group in (turning, rest))
    slow, slow_rest = (group.measured(measures.all_estimated_after) for group in (turning, rest))
    third = turning.measured(lambda recording: float(recording.estimate_error()[2]))
    early, mismatch = rest.measured(measures.error_before_faults), turning.measured(measures.rate_mismatch)
    c1, c3 = measures.theorem_bounds()
    return {
        "sooner": Finding(
            slow_rest["LO as printed"] < slow_rest["ASMO"], slow["LO corrected"] < slow["ASMO"],
            moving_times=times, rest_times=times_rest,
        ),
        "three-seconds": Finding(slow_rest["LO as printed"] <= 3.0, slow["LO corrected"] <= 3.0),
        "eight-seconds": Finding(_about_eight(rest["ASMO"]), _about_eight(turning["ASMO"])),
        "varying": Finding(
            *(third[name] < TOLERANCE < third["ASMO"] for name in LEARNING), errors=listed(third, "{:.3f}"),
        ),
        "before": Finding(
            *(early["ASMO"] > max(TOLERANCE, early[name]) for name in LEARNING), errors=listed(early, "{:.1e}"),
        ),
        "rate": Finding(
            *(max(mismatch[name], mismatch["ASMO"]) < 1e-2 for name in LEARNING),
            errors=listed(mismatch, "{:.1e} rad/s"),
        ),
        "theorem-1": Finding(c1 > 0.0 and c3 >= 0.0, c1=c1, c3=c3),
    }  # fmt: skip


def _times(flights: Recordings) -> dict[str, Finding]:
    printed, usable = (flights[name].settling(0.1) <= 20.0 for name in ("PTC as printed", "PTC"))
    free, limited, weak = (flights[f"starts, {name}"].arrivals() for name in ("unlimited", "5 N m", "1 N m"))
    times = flights.chosen([f"T1 = T2 = {time:g} s" for time in TIMES]).measured(lambda flight: flight.settling(0.1))
    ratios = [value / time for value, time in zip(times.values(), TIMES, strict=True)]
    return {
        "predefined": Finding(printed, usable),
        "parameter": Finding(
            False, bool(np.ptp(ratios) < 0.1), times=listed(times, "0.1 deg after {:.2f} s", link=": "),
        ),
        "initial-state": Finding(
            False, bool(np.ptp(free) < 0.1),
            first=free.min(), last=free.max(), first_limited=limited.min(), last_limited=seconds(limited.max()),
        ),
        "theorem-2": Finding(
            printed and weak.max() <= 20.0, bool(free.max() <= 20.0),
            free=free.max(), limited=seconds(limited.max()), weak=seconds(weak.max()),
        ),
    }  # fmt: skip


def _controller(flights: Recordings) -> dict[str, Finding]:
    compared = flights.relabelled({
        "as printed": "PTC as printed",
        "h1 = 0.25, sign": "PTC",
        "layer 0.05": "PTC, layer 0.05",
        "TSMC-class": "TSMC-class",
    })  # fmt: skip
    settling = compared.measured(lambda flight: flight.settling(0.1))
    torque = compared.measured(measures.torque_at_faults)
    ours = compared.chosen(("as printed", *USABLE))
    quiet, moved = ours.measured(measures.quiet_from), ours.measured(measures.disturbed)
    little = {name: max(raised) < 0.1 and recovered for name, (raised, recovered) in moved.items()}
    rises = {
        name: (", ".join(f"{value:.3f}" for value in raised), "" if recovered else ", not recovered")
        for name, (raised, recovered) in moved.items()
    }
    steady = flights.chosen(("E^ = I", *LEARNING), "turning, {}").measured(Recording.steady)
    return {
        "quiet": Finding(
            quiet["as printed"] <= 3.0, min(quiet[name] for name in USABLE) <= 3.0, times=listed_times(quiet),
        ),
        "recovery": Finding(
            little["as printed"], any(little[name] for name in USABLE), rises=listed(rises, "{} deg/s{}", "; "),
        ),
        "gentle": Finding(
            torque["as printed"][1] < torque["TSMC-class"][1],
            min(torque[name][1] for name in USABLE) < torque["TSMC-class"][1],
            torques=listed(torque, "{:.1f} N m, {:.1f} N m/s"),
        ),
        "better": Finding(*(settling[name] < settling["TSMC-class"] for name in ("as printed", "h1 = 0.25, sign"))),
        "tolerance": Finding(*(steady[name] < 0.5 * steady["E^ = I"] for name in LEARNING)),
    }  # fmt: skip
