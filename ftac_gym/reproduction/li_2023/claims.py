"""Claims of Li, Xu and Chang 2023, judged by flights of their example; ``claims.toml`` holds their texts."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ftac_gym.reproduction.li_2023 import measures
from ftac_gym.reproduction.li_2023.inequalities import inequalities, refused, symmetric_growth
from ftac_gym.reproduction.li_2023.measures import (
    CALM,
    FIRST,
    LATE,
    SECOND,
    final,
    largest,
    rate_error,
    vibration_error,
)
from ftac_gym.reproduction.li_2023.model import loop_errors, term_errors
from ftac_gym.reproduction.li_2023.plans import BOUNDS, FAST, SCHEMES
from ftac_gym.reproduction.recorder import Recording, Recordings
from ftac_gym.reproduction.verdicts import Claim, Finding, finding, written
from ftac_gym.reproduction.wording import listed, percent, seconds


def claims(flights: Recordings) -> list[Claim]:
    """Return the claims of the abstract, of sections 3 to 5 and of the conclusion."""
    findings = {**_model(), **_design(flights), **_observer(flights), **_comparisons(flights)}
    return written("li_2023", {**findings, **_vibration(flights), **_limits(flights)})


def _model() -> dict[str, Finding]:
    loops, terms = loop_errors(), term_errors()
    nearest, triangular = loops["nearest rule"], loops["triangular sets"]
    return {
        "model": finding(
            max(triangular, terms["triangular sets"]) < 1e-12,
            loops=listed(loops, "{:.2g}"), terms=listed(terms, "{:.2g}"),
        ),
        "few-rules": finding(False, nearest > 10.0 * triangular, nearest=nearest, triangular=triangular),
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
        "observer-gains": finding(
            *(item.holds and item.gamma <= 1.6563 for item in (plus, first)), gamma=first.gamma, reach=first.reach,
            rules=", ".join(str(rule) for rule in plus.outside), reach_plus=plus.reach,
        ),
        "controller-gains": finding(
            other.gamma <= 1.7919, second.holds and second.gamma <= 1.7919, gamma=second.gamma,
            gamma_plus=other.gamma, best=solved["Theorem 2, solved, delta(3,3) +"].gamma,
        ),
        "gamma": finding(solved["Theorem 1, solved, delta(3,3) -"].gamma ** 2 <= 0.1, refused=refused()),
        "solving": finding(
            False, all(item.holds for item in solved.values()), times=listed(times, "= {:.4f} in {:.1f} s", "; "),
        ),
        "proof": finding(growth < 0.0, growth=growth),
        "scheduling": finding(off > 0.01, off=off, rate=np.abs(own.rate).max()),
    }  # fmt: skip


def _observer(flights: Recordings) -> dict[str, Finding]:
    own, pd = flights["FASMC"], flights["PD gyroscopic"]
    assert own.disturbance is not None
    before, after, switching = (rate_error(own, window) for window in (CALM, LATE, SECOND))
    undisturbed, zero, zero_bounded, bounded = (
        rate_error(flights[f"FASMC, {name}"], CALM)
        for name in ("undisturbed", "from zero", "from zero, bounded", "bounded")
    )
    vibration = {name: vibration_error(own, window) for name, window in (("15 to 40 s", CALM), ("160 to 200 s", LATE))}
    healthy, size = vibration_error(flights["FASMC, healthy"], LATE)
    observers = flights.relabelled({
        "FAFEO": "FASMC",
        "FAFEO, weak faults": "FASMC, weak",
        "ILO-class": "FASMC with ILO-class",
        "ILO-class, weak": "FASMC with ILO-class, weak",
    })  # fmt: skip
    errors = observers.measured(lambda flight: measures.fault_error_norm(flight, LATE))
    quiet, quiet_ilo = (measures.fault_error_norm(observers[name], CALM) for name in ("FAFEO", "ILO-class"))
    channels, late = measures.fault_error(own, LATE), measures.during(own, LATE)[:-1]
    torque = measures.fault_torque(own)
    sizes = np.abs(torque[late]).max(axis=0)
    weaker = errors["FAFEO, weak faults"] < errors["ILO-class, weak"]
    halves = {f"f_max = {bound:g}": final(flights[f"FASMC, half, {bound:g} N m"]) for bound in BOUNDS}
    return {
        "rate": finding(
            before < 4e-7, rate_error(pd, (35.0, 40.0)) < 4e-7, before=before, undisturbed=undisturbed, zero=zero,
        ),
        "rate-with-faults": finding(switching < 3e-5, after < 3e-5, after=after, switching=switching),
        "vibration-estimate": finding(
            all(error < 0.1 * truth for error, truth in vibration.values()), healthy < 0.1 * size,
            vibration=listed(vibration, "error {:.3f} of {:.3f} N m", "; ", ": "), healthy=healthy, size=size,
        ),
        "fault-estimate": finding(
            bool((channels < 0.05).all()), bool((channels < 0.2).all()),
            channels=", ".join(f"{value:.3f}" for value in channels),
            sizes=", ".join(f"{value:.2f}" for value in sizes),
            biggest=np.abs(own.disturbance[:, 0] - torque)[late].max(), lag=measures.lag(own),
        ),
        "ilo": finding(
            errors["FAFEO"] < errors["ILO-class"] and weaker, weaker and quiet < quiet_ilo,
            errors=listed(errors, "{:.3f} N m"), quiet=quiet, quiet_ilo=quiet_ilo,
        ),
        "projections": finding(
            zero_bounded < 2.0 * zero and halves[f"f_max = {BOUNDS[0]:g}"] < 2e-3, bounded < 2.0 * before,
            zero=zero, bounded=zero_bounded, halves=listed(halves, "{:.1e}", link=": "),
        ),
    }  # fmt: skip


def _times(flights: Recordings, names: Iterable[str]) -> str:
    """Return the settling times of both manoeuvres as text."""
    both = flights.chosen(names).measured(
        lambda flight: tuple(seconds(measures.settling(flight, window)) for window in (FIRST, SECOND))
    )
    return listed(both, "{}, {}", "; ")


def _spent(flights: Recordings, until: float = np.inf) -> dict[str, float]:
    """Return the integrals of |u|^2 up to a time [s], by name [N^2 m^2 s]."""
    return flights.measured(lambda flight: flight.energy(until, commanded=True))


def _comparisons(flights: Recordings) -> dict[str, Finding]:
    schemes = flights.chosen(SCHEMES)
    ends, healthy = schemes.measured(final), flights.chosen(SCHEMES, "{}, healthy").measured(final)
    energy, initial, held = _spent(schemes), _spent(schemes, 40.0), _spent(flights.chosen(SCHEMES, "{}, printed start"))
    chatter, axes = schemes.measured(Recording.chatter), schemes.measured(measures.axis_errors)
    first = schemes.measured(lambda flight: measures.settling(flight, FIRST))
    times, ends_listed = _times(flights, SCHEMES), listed(ends, "{:.2g}")
    rivals, pds, classes = ("PD", "AISMC"), ("PD", "PD gyroscopic"), ("AISMC", "RAFTSMC-class")
    others = [name for name in SCHEMES if name != "FASMC"]
    gaps = {
        name: (initial["FASMC"] - initial[name], energy["FASMC"] - initial["FASMC"] - energy[name] + initial[name])
        for name in others
    }
    better = all(ends["FASMC"] < ends[name] for name in rivals)
    return {
        "stable": finding(max(ends.values()) < 0.01, max(ends.values()) < 0.1, ends=ends_listed),
        "smallest-error": finding(
            all(ends["FASMC"] < ends[name] for name in others), ends=ends_listed, healthy=listed(healthy, "{:.2g}"),
        ),
        "faster": finding(
            first["FASMC"] < min(first[name] for name in rivals) and better, first["FASMC"] < first["PD"] and better,
            times=times, ends=listed({name: ends[name] for name in ("FASMC", *rivals)}, "{:.2g}"),
        ),
        "fastest": finding(
            False, all(first["RAFTSMC-class"] < first[name] for name in SCHEMES if name != "RAFTSMC-class"),
            times=times,
        ),
        "energy": finding(
            energy["FASMC"] < min(energy[name] for name in classes),
            energy=listed(energy, "{:.0f}"), initial=listed(initial, "{:.0f}"), held=listed(held, "{:.0f}"),
        ),
        "pd": finding(
            energy["PD"] < min(energy[name] for name in SCHEMES if name != "PD") and ends["PD"] > ends["FASMC"],
            energy=energy["PD"], times=_times(flights, pds), ends=listed({name: ends[name] for name in pds}, "{:.2g}"),
        ),
        "gap": finding(
            all(initial[name] > 1.05 * initial["FASMC"] for name in classes),
            all(abs(gaps[name][0]) > abs(gaps[name][1]) for name in classes), gaps=listed(gaps, "{:+.0f}, {:+.0f}"),
        ),
        "fluctuation": finding(
            all(chatter["FASMC"] < chatter[name] for name in others), chatter=listed(chatter, "{:.2f} N m/s"),
        ),
        "axes": finding(
            all(varying > other for varying, other in axes.values()), axes["FASMC"][0] > axes["FASMC"][1],
            axes=listed(axes, "{:.1e} and {:.1e}"),
        ),
    }  # fmt: skip


def _vibration(flights: Recordings) -> dict[str, Finding]:
    healthy = flights["FASMC, healthy"]
    error, size = vibration_error(healthy, LATE)
    early_error, early_size = vibration_error(flights["FASMC"], CALM)
    energies = flights.chosen((*SCHEMES, "pd_dob", "pd_shaped")).measured(
        lambda flight: tuple(1e3 * measures.energy_at(flight, moment) for moment in (30.0, 78.0))
    )
    torques = flights.chosen(SCHEMES).measured(lambda flight: measures.shaking(flight, LATE))
    return {
        "counteraction": finding(
            error < 0.05 * size and final(healthy) < 1e-5, early_error < 0.05 * early_size,
            size=size, error=error, end=final(healthy),
            energies=listed(energies, "{:.2f}, {:.3f} mJ"), torques=listed(torques, "{:.3f} N m"),
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
    printed, used = (largest(flight, (0.0, 0.1)) for flight in (start, own))
    between = flights.chosen((*SCHEMES, "FASMC without observer")).measured(
        lambda flight: largest(flight, (45.0, 79.0))
    )
    return {
        "limit": finding(
            sums["wheel by wheel"] <= 5.0 + 1e-9, sums["sum"] <= 5.0 + 1e-9, sums=listed(sums, "{:.1f} N m"),
            times=_times(flights, ("FASMC", "FASMC, sum")), share=percent(measures.any_at_limit(own), 1),
        ),
        "virtual-control": finding(size < 0.1 and control < 5.0 * np.sqrt(3.0), size=size, control=control),
        "stability": finding(
            spent["-q"] < 1.1 * spent["q"] and lost["FASMC"] < 1.0, spent=listed(spent, "{:.0f} N^2 m^2 s"),
            turned=listed(turned, "{:.1f}"), rate=FAST, lost=listed(lost, "{:.1f} deg"),
        ),
        "misalignment": finding(
            final(own) < 1.5 * final(aligned), end=final(own), end_aligned=final(aligned),
            error=measures.fault_error_norm(own, CALM), error_aligned=measures.fault_error_norm(aligned, CALM),
        ),
        "manoeuvre": finding(
            printed > 0.1, used > 0.1, printed=printed, used=used,
            energy=start.energy(40.0, commanded=True), energy_used=own.energy(40.0, commanded=True),
        ),
        "between": finding(between["FASMC"] < 0.01, between["FASMC"] < 0.02, between=listed(between, "{:.2g}")),
    }  # fmt: skip
