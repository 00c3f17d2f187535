"""Claims of Zhang and Zhou 2019, judged by flights of their example; ``claims.toml`` holds their texts."""

from __future__ import annotations

from ftac_gym.reproduction.inverse_dynamics import peak_wheel_torque
from ftac_gym.reproduction.recordings import Recording, Recordings
from ftac_gym.reproduction.verdicts import Finding, Measure
from ftac_gym.reproduction.wording import listed, settled
from ftac_gym.reproduction.zhang_zhou_2019 import measures
from ftac_gym.reproduction.zhang_zhou_2019.measures import earlier, estimates_hold, more_precise

ACCURACIES = {"sigma-1": 1.3e-4, "sigma-2": 3.2e-4, "sigma-3": 8.5e-4}
"""Accuracies of Table 1 [deg]."""


MEASURES: dict[str, Measure] = {
    "accuracy": lambda recording: f"{settled(recording)}, {recording.steady():.3f} deg",
    "estimated": measures.estimated,
    "need": lambda recording: peak_wheel_torque(recording.scenario),
    "visible_bias": measures.visible_bias,
}
"""Measures for the texts."""


def findings(flights: Recordings) -> dict[str, Finding]:
    """Return the findings for the claims of the abstract, of section 5, of Table 1 and of the conclusion."""
    topics = (_estimation, _control, _comparison, _table_1, _parts)
    return {name: found for topic in topics for name, found in topic(flights).items()}


def _settle(*recordings: Recording) -> list[bool]:
    """Return whether each flight settles within the 60 s of the example."""
    return [recording.settling(0.1) < 60.0 for recording in recordings]


def _estimation(flights: Recordings) -> dict[str, Finding]:
    mismatch = flights.chosen(("as printed, 5 N m", "tracking", "stabilisation")).measured(measures.rate_mismatch)
    usable = flights.chosen(("printed, 5 N m", "tracking", "stabilisation", "tracking, undisturbed"))
    without = flights["tracking, no observer"]
    return {
        "barrier": Finding(False, max(mismatch.values()) < 0.05, mismatch=listed(mismatch, "{:.4f}")),
        "estimates": Finding(estimates_hold(flights["as printed, 5 N m"]), any(map(estimates_hold, usable.values()))),
        "compensation": Finding(
            earlier(flights["tracking, printed observer"], without), earlier(flights["tracking"], without)
        ),
    }


def _control(flights: Recordings) -> dict[str, Finding]:
    printed, second = (flights[f"as printed, {limit} N m"] for limit in (5, 2))
    tracking, weak, dead = (flights[name] for name in ("tracking", "tracking, 2 N m", "tracking, dead wheel"))
    helped, weak_helped = flights["tracking, auxiliary"], flights["tracking, 2 N m, auxiliary"]
    return {
        "stabilisation": Finding(False, all(_settle(flights["stabilisation"], flights["stabilisation, sign"]))),
        "tracking": Finding(any(_settle(printed, second)), all(_settle(tracking))),
        "auxiliary": Finding(earlier(helped, tracking) or earlier(weak_helped, weak)),
        "input": Finding(second.saturated() == 0.0, weak.saturated() == 0.0),
        "outage": Finding(False, all(_settle(dead))),
    }


def _comparison(flights: Recordings) -> dict[str, Finding]:
    steady = flights.measured(Recording.steady)
    healthy = [steady["Shen-class, healthy"], steady["Shen-class, scaled, healthy"]]
    ratios = [steady["Shen-class"] / healthy[0], steady["Shen-class, scaled"] / healthy[1]]
    pairs = (("tracking", "Shen-class, scaled"), ("stabilisation", "Shen-class, scaled, at rest"))
    return {
        "rival-healthy": Finding(False, min(healthy) < 1.0),
        "rival-faulty": Finding(False, min(ratios) > 1.1),
        "rival": Finding(False, all(more_precise(flights[ours], flights[theirs]) for ours, theirs in pairs)),
    }


def _table_1(flights: Recordings) -> dict[str, Finding]:
    accuracy = flights.relabelled({
        "as printed, 5 N m": "as printed, 5 N m",
        "unlimited": "printed, unlimited",
        "unlimited, sign": "printed, unlimited, sign",
        "slowed": "tracking",
        "slowed, sign, 10 ms": "tracking, sign",
        "slowed, sign, 1 ms": "tracking, 0.001 s, layer 0.0",
    }).measured(Recording.component_accuracy)  # fmt: skip
    found = {}
    for axis, (name, stated) in enumerate(ACCURACIES.items()):
        errors = {label: values[axis] for label, values in accuracy.items()}
        found[name] = Finding(
            errors["as printed, 5 N m"] <= stated, min(errors.values()) <= stated,
            errors=listed(errors, "{:.2g} deg", link=": "),
        )  # fmt: skip
    return {
        **found,
        "settling": Finding(*(flights[name].settling(0.1) <= 20.0 for name in ("as printed, 5 N m", "tracking"))),
        "rival-settling": Finding(
            False, any(flights[name].settling(0.008) < 40.0 for name in ("Shen-class", "Shen-class, scaled"))
        ),
    }


def _parts(flights: Recordings) -> dict[str, Finding]:
    tracking, without = flights["tracking"], flights["tracking, no network"]
    chatter = flights.measured(Recording.chatter)
    return {
        "reaching": Finding(
            chatter["tracking, sign"] < 0.95 * chatter["tracking, constant gain"],
            chatter["tracking, unlimited, sign"] < 0.95 * chatter["tracking, unlimited, constant gain"],
        ),
        "network": Finding(False, without.steady() > 1.1 * tracking.steady() or earlier(tracking, without)),
    }
