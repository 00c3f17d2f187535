"""Claims of Li, Xu and Chang 2023, judged by flights of their example; ``claims.toml`` holds their texts."""

from __future__ import annotations

from functools import partial

import numpy as np

from ftac_gym.reproduction.li_2023 import measures
from ftac_gym.reproduction.li_2023.inequalities import inequalities, refused, symmetric_growth
from ftac_gym.reproduction.li_2023.measures import CALM, FIRST, LATE, SECOND, final, rate_error, vibration_error
from ftac_gym.reproduction.li_2023.model import loop_errors, term_errors
from ftac_gym.reproduction.li_2023.plans import FAST, SCHEMES
from ftac_gym.reproduction.recordings import Recording, Recordings
from ftac_gym.reproduction.verdicts import Finding, Measure
from ftac_gym.reproduction.wording import listed, percent, seconds

MEASURES: dict[str, Measure] = {
    "final": final,
    "initial": partial(measures.largest, window=(0.0, 0.1)),
    "rate_calm": partial(rate_error, window=CALM),
    "fault_calm": partial(measures.fault_error_norm, window=CALM),
    "fault_late": partial(measures.fault_error_norm, window=LATE),
    "shaking": partial(measures.shaking, window=LATE),
    "vibration_late": partial(vibration_error, window=LATE),
    "spent": partial(Recording.energy, commanded=True),
    "spent_40": partial(Recording.energy, until=40.0, commanded=True),
    "times": lambda flight: ", ".join(seconds(measures.settling(flight, window)) for window in (FIRST, SECOND)),
    "at_limit": lambda flight: percent(measures.any_at_limit(flight), 1),
}
"""Measures for the texts."""


def findings(flights: Recordings) -> dict[str, Finding]:
    """Return the findings for the claims of the abstract, of sections 3 to 5 and of the conclusion."""
    return {**_model(), **_design(flights), **_observer(flights), **_comparisons(flights), **_limits(flights)}


def _model() -> dict[str, Finding]:
    loops, terms = loop_errors(), term_errors()
    nearest, triangular = loops["nearest rule"], loops["triangular sets"]
    return {
        "model": Finding(
            max(triangular, terms["triangular sets"]) < 1e-12,
            loops=listed(loops, "{:.2g}"), terms=listed(terms, "{:.2g}"),
        ),
        "few-rules": Finding(False, nearest > 10.0 * triangular, nearest=nearest, triangular=triangular),
    }  # fmt: skip


def _design(flights: Recordings) -> dict[str, Finding]:
    found = inequalities()
    first, second, plus, other = (
        found[f"Theorem {number}, published, delta(3,3) {sign}"] for sign in "-+" for number in (1, 2)
    )
    solved = {name: item for name, item in found.items() if "solved" in name}
    times = {
        f"{name.split(',')[0]} gamma": (item.gamma, item.seconds) for name, item in solved.items() if name.endswith("-")
    }
    own, growth = flights["FASMC"], symmetric_growth()
    off = float(np.abs(own.attitude - flights["FASMC, mean gains"].attitude).max())
    return {
        "observer-gains": Finding(
            *(item.holds and item.gamma <= 1.6563 for item in (plus, first)), gamma=first.gamma, reach=first.reach,
            rules=", ".join(str(rule) for rule in plus.outside), reach_plus=plus.reach,
        ),
        "controller-gains": Finding(
            other.gamma <= 1.7919, second.holds and second.gamma <= 1.7919, gamma=second.gamma,
            gamma_plus=other.gamma, best=solved["Theorem 2, solved, delta(3,3) +"].gamma,
        ),
        "gamma": Finding(solved["Theorem 1, solved, delta(3,3) -"].gamma ** 2 <= 0.1, refused=refused()),
        "solving": Finding(
            False, all(item.holds for item in solved.values()), times=listed(times, "= {:.4f} in {:.1f} s", "; "),
        ),
        "proof": Finding(growth < 0.0, growth=growth),
        "scheduling": Finding(off > 0.01, off=off, rate=np.abs(own.rate).max()),
    }  # fmt: skip


def _observer(flights: Recordings) -> dict[str, Finding]:
    def calm(name: str) -> float:
        return rate_error(flights[name], CALM)

    own = flights["FASMC"]
    assert own.disturbance is not None
    after, switching = rate_error(own, LATE), rate_error(own, SECOND)
    vibration = {name: vibration_error(own, window) for name, window in (("15 to 40 s", CALM), ("160 to 200 s", LATE))}
    healthy, size = vibration_error(flights["FASMC, healthy"], LATE)
    observers = flights.chosen(("FASMC", "FASMC, weak", "FASMC with ILO-class", "FASMC with ILO-class, weak"))
    errors, weak, ilo, ilo_weak = observers.measured(MEASURES["fault_late"]).values()
    quiet, _, ilo_quiet, _ = observers.measured(MEASURES["fault_calm"]).values()
    channels, torque = measures.fault_error(own, LATE), measures.fault_torque(own)
    late = measures.during(own, LATE)[:-1]
    energies = flights.chosen((*SCHEMES, "pd_dob", "pd_shaped")).measured(
        lambda flight: tuple(1e3 * measures.energy_at(flight, moment) for moment in (30.0, 78.0))
    )
    return {
        "rate": Finding(calm("FASMC") < 4e-7, rate_error(flights["PD gyroscopic"], (35.0, 40.0)) < 4e-7),
        "rate-with-faults": Finding(switching < 3e-5, after < 3e-5, after=after, switching=switching),
        "vibration-estimate": Finding(
            all(error < 0.1 * truth for error, truth in vibration.values()), healthy < 0.1 * size,
            vibration=listed(vibration, "error {:.3f} of {:.3f} N m", "; ", ": "),
        ),
        "counteraction": Finding(
            healthy < 0.05 * size and final(flights["FASMC, healthy"]) < 1e-5,
            vibration["15 to 40 s"][0] < 0.05 * vibration["15 to 40 s"][1],
            energies=listed(energies, "{:.2f}, {:.3f} mJ"),
        ),
        "fault-estimate": Finding(
            *(bool((channels < limit).all()) for limit in (0.05, 0.2)),
            channels=", ".join(f"{value:.3f}" for value in channels), lag=measures.lag(own),
            sizes=", ".join(f"{value:.2f}" for value in np.abs(torque[late]).max(axis=0)),
            biggest=np.abs(own.disturbance[:, 0] - torque)[late].max(),
        ),
        "ilo": Finding(errors < ilo and weak < ilo_weak, weak < ilo_weak and quiet < ilo_quiet),
        "projections": Finding(
            calm("FASMC, from zero, bounded") < 2.0 * calm("FASMC, from zero")
            and final(flights["FASMC, half, 2 N m"]) < 2e-3,
            calm("FASMC, bounded") < 2.0 * calm("FASMC"),
        ),
    }  # fmt: skip


def _spent(flights: Recordings, until: float = np.inf) -> dict[str, float]:
    """Return the integrals of ``|u|^2`` up to a time [s], by name [N^2 m^2 s]."""
    return flights.measured(partial(Recording.energy, until=until, commanded=True))


def _comparisons(flights: Recordings) -> dict[str, Finding]:
    schemes = flights.chosen(SCHEMES)
    ends, healthy = schemes.measured(final), flights.chosen(SCHEMES, "{}, healthy").measured(final)
    energy, initial, held = _spent(schemes), _spent(schemes, 40.0), _spent(flights.chosen(SCHEMES, "{}, printed start"))
    chatter, axes = schemes.measured(Recording.chatter), schemes.measured(measures.axis_errors)
    first, times = schemes.measured(partial(measures.settling, window=FIRST)), schemes.measured(MEASURES["times"])
    classes, others = ("AISMC", "RAFTSMC-class"), [name for name in SCHEMES if name != "FASMC"]
    gaps = {
        name: (initial["FASMC"] - initial[name], energy["FASMC"] - initial["FASMC"] - energy[name] + initial[name])
        for name in others
    }
    better = all(ends["FASMC"] < ends[name] for name in ("PD", "AISMC"))
    listed_ends, listed_times = listed(ends, "{:.2g}"), listed(times, separator="; ")
    return {
        "stable": Finding(max(ends.values()) < 0.01, max(ends.values()) < 0.1, ends=listed_ends),
        "smallest-error": Finding(
            all(ends["FASMC"] < ends[name] for name in others), ends=listed_ends, healthy=listed(healthy, "{:.2g}"),
        ),
        "faster": Finding(
            first["FASMC"] < min(first["PD"], first["AISMC"]) and better, first["FASMC"] < first["PD"] and better,
            all_times=listed_times,
        ),
        "fastest": Finding(
            False, all(first["RAFTSMC-class"] < first[name] for name in SCHEMES if name != "RAFTSMC-class"),
            all_times=listed_times,
        ),
        "energy": Finding(
            energy["FASMC"] < min(energy[name] for name in classes),
            energy=listed(energy, "{:.0f}"), initial=listed(initial, "{:.0f}"), held=listed(held, "{:.0f}"),
        ),
        "pd": Finding(
            energy["PD"] < min(energy[name] for name in SCHEMES if name != "PD") and ends["PD"] > ends["FASMC"]
        ),
        "gap": Finding(
            all(initial[name] > 1.05 * initial["FASMC"] for name in classes),
            all(abs(gaps[name][0]) > abs(gaps[name][1]) for name in classes), gaps=listed(gaps, "{:+.0f}, {:+.0f}"),
        ),
        "fluctuation": Finding(
            all(chatter["FASMC"] < chatter[name] for name in others), chatter=listed(chatter, "{:.2f} N m/s"),
        ),
        "axes": Finding(
            all(varying > other for varying, other in axes.values()), axes["FASMC"][0] > axes["FASMC"][1],
            axes=listed(axes, "{:.1e} and {:.1e}"),
        ),
    }  # fmt: skip


def _limits(flights: Recordings) -> dict[str, Finding]:
    own, aligned, start = (flights[name] for name in ("FASMC", "FASMC, aligned", "FASMC, printed start"))
    sums = flights.relabelled({"wheel by wheel": "FASMC", "sum": "FASMC, sum"}).measured(
        lambda flight: float(np.abs(flight.command[:, 0]).sum(axis=1).max())
    )
    size, control = measures.virtual_control(own)
    lost = flights.chosen(SCHEMES, "{}, fast start").measured(lambda flight: float(flight.error[-1, 0]))
    ways = flights.chosen(("q", "-q", "-q, short way"), "FASMC, {}")
    spent, turned = _spent(ways), ways.measured(lambda flight: float(flight.path_ratio()[0]))
    between = flights.chosen((*SCHEMES, "FASMC without observer")).measured(
        partial(measures.largest, window=(45.0, 79.0))
    )
    return {
        "limit": Finding(*(value <= 5.0 + 1e-9 for value in sums.values()), sums=listed(sums, "{:.1f} N m")),
        "virtual-control": Finding(size < 0.1 and control < 5.0 * np.sqrt(3.0), size=size, control=control),
        "stability": Finding(
            spent["-q"] < 1.1 * spent["q"] and lost["FASMC"] < 1.0,
            turned=listed(turned, "{:.1f}"), rate=FAST, lost=listed(lost, "{:.1f} deg"),
        ),
        "misalignment": Finding(final(own) < 1.5 * final(aligned)),
        "manoeuvre": Finding(*(measures.largest(flight, (0.0, 0.1)) > 0.1 for flight in (start, own))),
        "between": Finding(*(between["FASMC"] < limit for limit in (0.01, 0.02)), between=listed(between, "{:.2g}")),
    }  # fmt: skip
