"""Claims of Zhang and Zhou 2019, judged by flights of their example; ``claims.toml`` holds their texts."""

from __future__ import annotations

from ftac_gym.reproduction.inverse_dynamics import peak_wheel_torque
from ftac_gym.reproduction.recorder import Recording, Recordings
from ftac_gym.reproduction.verdicts import Claim, Finding, finding, written
from ftac_gym.reproduction.wording import listed, percent, settled
from ftac_gym.reproduction.zhang_zhou_2019.measures import (
    earlier,
    estimated,
    estimates_hold,
    more_precise,
    rate_mismatch,
    visible_bias,
)

ACCURACIES = {"sigma-1": 1.3e-4, "sigma-2": 3.2e-4, "sigma-3": 8.5e-4}
"""Accuracies of Table 1 [deg]."""


def claims(flights: Recordings) -> list[Claim]:
    """Return the claims of the abstract, of section 5, of Table 1 and of the conclusion."""
    needs = {
        "need": peak_wheel_torque(flights["tracking"].scenario),
        "need_printed": peak_wheel_torque(flights["as printed, 5 N m"].scenario),
    }
    topics = (_estimation, _control, _comparison, _table_1, _parts)
    findings = {name: item for topic in topics for name, item in topic(flights).items()}
    return written("zhang_zhou_2019", findings, needs)


def _accuracy(recording: Recording) -> str:
    return f"{settled(recording)}, {recording.steady():.3f} deg"


def _estimation(flights: Recordings) -> dict[str, Finding]:
    schemes = flights.chosen(("as printed, 5 N m", "tracking", "stabilisation"))
    mismatch = schemes.measured(rate_mismatch)
    variants = flights.relabelled({
        "printed": "as printed, 5 N m",
        "published": "tracking, printed observer",
        "usable": "printed, 5 N m",
        "tracking": "tracking",
        "rest": "stabilisation",
        "calm": "tracking, undisturbed",
    })  # fmt: skip
    hold, estimates = variants.measured(estimates_hold), variants.measured(estimated)
    slowed = flights.relabelled({
        "printed gains": "tracking, printed observer",
        "usable gains": "tracking",
        "E^ = I": "tracking, no observer",
        "exact": "tracking, oracle",
    })  # fmt: skip
    rest = flights.relabelled({"E^ = I": "stabilisation, no observer", "exact": "stabilisation, oracle"})
    return {
        "barrier": finding(
            False, max(mismatch.values()) < 0.05,
            mismatch=listed(mismatch, "{:.4f}"), tracking=estimates["tracking"], calm=estimates["calm"],
        ),
        "estimates": finding(
            hold["printed"], any(hold[name] for name in ("usable", "tracking", "rest", "calm")),
            visible=visible_bias(variants["tracking"]), **estimates,
        ),
        "compensation": finding(
            *(earlier(slowed[name], slowed["E^ = I"]) for name in ("printed gains", "usable gains")),
            slowed_times=listed(slowed.measured(settled)), rest=settled(variants["rest"]),
            rest_times=listed(rest.measured(settled)),
        ),
    }  # fmt: skip


def _control(flights: Recordings) -> dict[str, Finding]:
    printed, second = (flights[f"as printed, {limit} N m"] for limit in (5, 2))
    tracking, rest, sharp = (flights[name] for name in ("tracking", "stabilisation", "stabilisation, sign"))
    free, weak, dead = (flights[name] for name in ("printed, unlimited", "tracking, 2 N m", "tracking, dead wheel"))
    helped, weak_helped = flights["tracking, auxiliary"], flights["tracking, 2 N m, auxiliary"]
    return {
        "stabilisation": finding(
            False, rest.settling(0.1) < 60.0 and sharp.settling(0.1) < 60.0,
            rest=settled(rest), steady=rest.steady(), sharp=_accuracy(sharp),
        ),
        "tracking": finding(
            printed.settling(0.1) < 60.0 or second.settling(0.1) < 60.0, tracking.settling(0.1) < 60.0,
            steady=printed.steady(), steady_weak=second.steady(), free=settled(free), tracking=settled(tracking),
        ),
        "auxiliary": finding(
            earlier(helped, tracking) or earlier(weak_helped, weak),
            helped=settled(helped), tracking=settled(tracking), weak_helped=settled(weak_helped), weak=settled(weak),
        ),
        "input": finding(
            second.saturated() == 0.0, weak.saturated() == 0.0,
            printed=percent(second.saturated()), slow=percent(weak.saturated()), steady=weak.steady(),
        ),
        "outage": finding(False, dead.settling(0.1) < 60.0, dead=settled(dead), steady=dead.steady()),
    }  # fmt: skip


def _comparison(flights: Recordings) -> dict[str, Finding]:
    rivals = flights.relabelled({
        "shen": "Shen-class",
        "healthy": "Shen-class, healthy",
        "scaled": "Shen-class, scaled",
        "scaled_healthy": "Shen-class, scaled, healthy",
    })  # fmt: skip
    steady = rivals.measured(Recording.steady)
    ratios = steady["shen"] / steady["healthy"], steady["scaled"] / steady["scaled_healthy"]
    tracking, rest, scaled = flights["tracking"], flights["stabilisation"], rivals["scaled"]
    scaled_rest = flights["Shen-class, scaled, at rest"]
    return {
        "rival-healthy": finding(False, min(steady["healthy"], steady["scaled_healthy"]) < 1.0, **steady),
        "rival-faulty": finding(False, min(ratios) > 1.1, **steady),
        "rival": finding(
            False, more_precise(tracking, scaled) and more_precise(rest, scaled_rest), tracking=_accuracy(tracking),
            scaled=_accuracy(scaled), rest=_accuracy(rest), scaled_rest=_accuracy(scaled_rest),
        ),
    }  # fmt: skip


def _table_1(flights: Recordings) -> dict[str, Finding]:
    table = flights.relabelled({
        "as printed, 5 N m": "as printed, 5 N m",
        "unlimited": "printed, unlimited",
        "unlimited, sign": "printed, unlimited, sign",
        "slowed": "tracking",
        "slowed, sign, 10 ms": "tracking, sign",
        "slowed, sign, 1 ms": "tracking, 0.001 s, layer 0.0",
    })  # fmt: skip
    printed, free, tracking = (table[label] for label in ("as printed, 5 N m", "unlimited", "slowed"))
    scaled, shen = flights["Shen-class, scaled"], flights["Shen-class"]
    accuracy = table.measured(Recording.component_accuracy)
    found = {}
    for axis, (name, stated) in enumerate(ACCURACIES.items()):
        errors = {label: values[axis] for label, values in accuracy.items()}
        found[name] = finding(
            errors["as printed, 5 N m"] <= stated, min(errors.values()) <= stated,
            accuracy=listed(errors, "{:.2g} deg", link=": "),
        )  # fmt: skip
    return {
        **found,
        "settling": finding(
            printed.settling(0.1) <= 20.0, tracking.settling(0.1) <= 20.0, printed=settled(printed),
            free=settled(free), tracking=settled(tracking), rest=settled(flights["stabilisation"]),
        ),
        "rival-settling": finding(
            False, any(flight.settling(0.008) < 40.0 for flight in (shen, scaled)),
            printed=settled(flights["printed, Shen-class"]), shen=settled(shen), steady=shen.steady(),
            scaled=_accuracy(scaled),
        ),
    }  # fmt: skip


def _parts(flights: Recordings) -> dict[str, Finding]:
    tracking, without = flights["tracking"], flights["tracking, no network"]
    chatter = flights.relabelled({
        "free_sharp": "tracking, unlimited, sign",
        "free_constant": "tracking, unlimited, constant gain",
        "sharp": "tracking, sign",
        "constant": "tracking, constant gain",
    }).measured(Recording.chatter)  # fmt: skip
    return {
        "reaching": finding(
            chatter["sharp"] < 0.95 * chatter["constant"], chatter["free_sharp"] < 0.95 * chatter["free_constant"],
            **chatter,
        ),
        "network": finding(
            False, without.steady() > 1.1 * tracking.steady() or earlier(tracking, without), steady=tracking.steady(),
            steady_without=without.steady(), tracking=settled(tracking), without=settled(without),
        ),
    }  # fmt: skip
