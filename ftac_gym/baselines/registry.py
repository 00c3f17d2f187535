"""Baselines of this package by name, and those of a user by class or ``"module:Class"``."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from dataclasses import dataclass, field
from difflib import get_close_matches
from typing import Any, TypeGuard

from ftac_gym.baselines import tuned
from ftac_gym.baselines.baseline import Baseline
from ftac_gym.baselines.controllers.afntsmc import AFNTSMC
from ftac_gym.baselines.controllers.aismc import AISMC
from ftac_gym.baselines.controllers.chen_m1 import ChenM1
from ftac_gym.baselines.controllers.chen_m2 import ChenM2
from ftac_gym.baselines.controllers.chen_m3 import ChenM3
from ftac_gym.baselines.controllers.fuzzy_pd import FuzzyPD
from ftac_gym.baselines.controllers.fuzzy_smc import FuzzySMC
from ftac_gym.baselines.controllers.hsfc import HSFC
from ftac_gym.baselines.controllers.indi import INDI
from ftac_gym.baselines.controllers.lqr import LQR
from ftac_gym.baselines.controllers.nftsm import NFTSM
from ftac_gym.baselines.controllers.pd import PD, PDDisturbanceObserver
from ftac_gym.baselines.controllers.pd_shaped import ShapedPD
from ftac_gym.baselines.controllers.predefined_time import PredefinedTimeController
from ftac_gym.baselines.controllers.prescribed_performance import PrescribedPerformance
from ftac_gym.baselines.controllers.ptc import PTC
from ftac_gym.baselines.controllers.raftsmc_class import RAFTSMCClass
from ftac_gym.baselines.controllers.shen_class import ShenClass
from ftac_gym.baselines.controllers.shopd_plus import SHOPDPlus
from ftac_gym.baselines.controllers.super_twisting import SuperTwisting
from ftac_gym.baselines.controllers.tsmc_class import TSMCClass
from ftac_gym.baselines.controllers.zhang_zhou_stabilisation import ZhangZhouStabilisation
from ftac_gym.baselines.controllers.zhang_zhou_tracking import ZhangZhouTracking
from ftac_gym.baselines.custom import BaselineLike, baseline_at
from ftac_gym.baselines.gains import SearchSpace, merged
from ftac_gym.baselines.sampling import warn_of_long_period
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.importing import is_path
from ftac_gym.utils.parameters import broken, require, require_keywords

GAINS = ("default", "tuned")
"""Sets of gains that :func:`make` takes by name."""


@dataclass(frozen=True)
class Entry:
    """A baseline under a name, with the gains that make it that variant."""

    baseline: type[Baseline]
    gains: Mapping[str, Any] = field(default_factory=dict)


def _published(name: str, baseline: type[Baseline], observer: str, **gains: Any) -> dict[str, Entry]:
    """Return the variants of a published scheme: with its observer, without an observer, with the true faults."""
    sources = {"": observer, "_no_observer": "none", "_oracle": "oracle"}
    return {name + suffix: Entry(baseline, {**gains, "faults": source}) for suffix, source in sources.items()}


def _sampled(name: str, baseline: type[Baseline], observer: str) -> dict[str, Entry]:
    """Return the variants for sampled control: without an observer, with one, with telemetry, with the true faults."""
    return {
        name: Entry(baseline),
        f"{name}_observer": Entry(baseline, {"faults": observer}),
        f"{name}_telemetry": Entry(baseline, {"faults": "tachometer"}),
        f"{name}_oracle": Entry(baseline, {"faults": "oracle"}),
        f"{name}_isolation": Entry(baseline, {"isolation": "rate"}),
    }


_PUBLISHED: dict[str, Any] = {"design": "published", "torque_bound": 2.0}

ENTRIES: dict[str, Entry] = {
    "pd": Entry(PD),
    "pd_dob": Entry(PDDisturbanceObserver),
    # Gentle: a wheel that locks keeps little torque. Chosen by success on the validation lists of the flagship family.
    "pd_dob_robust": Entry(
        PDDisturbanceObserver,
        {
            "rate_gain": 1.9,
            "position_gain": 1.138,
            "bandwidth": 0.1606,
            "calm_share": 0.6,
            "rate_limit": 0.68,
            "torque_share": 0.45,
            "braking_share": 0.45,
        },
    ),
    "lqr": Entry(LQR),
    "indi": Entry(INDI),
    "super_twisting": Entry(SuperTwisting),
    **_sampled("nftsm", NFTSM, "asmo_scaled"),
    **_sampled("predefined_time", PredefinedTimeController, "lo_scaled"),
    **_published("zhang_zhou_stabilisation", ZhangZhouStabilisation, "asmo"),
    **_published("zhang_zhou_tracking", ZhangZhouTracking, "asmo"),
    **_published("ptc", PTC, "lo_corrected"),
    **_published("ptc_printed", PTC, "lo", position_exponent=0.5, smallest_effectiveness=1e-4),
    # Table 1's exponent with the smallest change that makes it a controller.
    **_published("ptc_regularised", PTC, "lo_corrected", position_exponent=0.5, position_regularisation=1e-4),
    # The comparators are built from their families, hence -class.
    "tsmc_class": Entry(TSMCClass),
    "tsmc_class_oracle": Entry(TSMCClass, {"faults": "oracle"}),
    "shen_class": Entry(ShenClass),
    "hsfc": Entry(HSFC),
    "hsfc_componentwise": Entry(HSFC, {"compensation": "componentwise", "smallest_effectiveness": 0.6}),
    # The gains of section 5.2, for healthy wheels, with a floor.
    "hsfc_floor": Entry(
        HSFC, {"adaptation": 0.1, "smoothing": 0.01, "smallest_effectiveness": 1.0, "gamma_floor": 1.0}
    ),
    "afntsmc": Entry(AFNTSMC),
    "shopd_plus": Entry(SHOPDPlus),
    "shopd_plus_zero_filter": Entry(SHOPDPlus, {"filter_start": "zero"}),
    "chen_m1": Entry(ChenM1),
    # Without the terms that a hold of 0.05 to 0.2 s makes unstable.
    "chen_m1_sampled": Entry(ChenM1, {"filter_substeps": 0, "rate_power_gain": 0.0, "rate_gain": 2.0}),
    "chen_m2": Entry(ChenM2),
    "chen_m3": Entry(ChenM3),
    # tau and rho for a body of 350 kg m^2 instead of one of 10 to 20.
    "chen_m3_scaled": Entry(ChenM3, {"reaching_linear": 100.0, "reaching_power_gain": 10.0}),
    "prescribed_performance": Entry(PrescribedPerformance),
    # Li et al. 2023, flexible spacecraft. Published: gains of the appendix, quaternion of either sign.
    "fuzzy_smc": Entry(FuzzySMC, {"design": "published", "observer": _PUBLISHED, "short_way": False}),
    "fuzzy_smc_solved": Entry(FuzzySMC),
    "fuzzy_smc_ilo_class": Entry(FuzzySMC, {"design": "published", "faults": "ilo_class", "short_way": False}),
    "fuzzy_pd": Entry(FuzzyPD, {"observer": _PUBLISHED, "short_way": False}),
    "fuzzy_pd_gyroscopic": Entry(FuzzyPD, {"observer": _PUBLISHED, "short_way": False, "compensation": "gyroscopic"}),
    "aismc": Entry(AISMC, {"design": "published", "short_way": False}),
    "raftsmc_class": Entry(RAFTSMCClass),
    "pd_shaped": Entry(ShapedPD),
}


def names() -> list[str]:
    """Return the names of all baselines of this package."""
    return sorted(ENTRIES)


def known_names(name: str) -> str:
    """Return text for messages about an unknown name: where all names are, and those nearest to it."""
    return f"one of ftac_gym.baselines.names(), such as {', '.join(get_close_matches(name[:40], names(), 5, 0.0))}"


def is_baseline(name: str) -> bool:
    """Tell whether a text is the name of a baseline or the path ``"module:Class"`` of a custom one."""
    return name in ENTRIES or is_path(name)


def _registered(name: BaselineLike) -> TypeGuard[str]:
    return isinstance(name, str) and name in ENTRIES


def _entry(name: BaselineLike) -> Entry:
    if not isinstance(name, str):
        known = isinstance(name, type) and issubclass(name, Baseline)
        require(known, "baseline", "must be a name or a class that derives from Baseline, not an object of one", name)
        return Entry(name)
    if is_path(name):
        return Entry(baseline_at(name))
    if name not in ENTRIES:
        raise broken("baseline", f'must be {known_names(name)}, or "module:Class" for a custom baseline', name)
    return ENTRIES[name]


def baseline_class(name: BaselineLike) -> type[Baseline]:
    """Return the class of a baseline.

    Parameters
    ----------
    name
        One of :func:`names`; for a custom baseline its class or ``"module:Class"``.

    Raises
    ------
    ValueError
        If the name is unknown, or there is no such class.
    """
    return _entry(name).baseline


def chosen(name: BaselineLike, gains: str, changes: Mapping[str, Any]) -> dict[str, Any]:
    """Return the gains that :func:`make` passes to the class: all that differ from the defaults of the class.

    Raises
    ------
    ValueError
        If the name or the set of gains is unknown, or there are no tuned gains.
    """
    entry = _entry(name)
    known = gains in GAINS or tuned.is_file(gains)
    require(known, "gains", f"must be one of {list(GAINS)}, or a file FILE.json of ftac-tune", gains)
    rule = "must be 'default' for a baseline not of this package"
    require(_registered(name) or gains == "default", "gains", rule, gains)
    layers = [entry.gains, tuned.gains(name, gains) if _registered(name) and gains != "default" else {}]
    if changes.get("faults", entry.gains.get("faults")) != entry.gains.get("faults"):
        # Gains of one observer have no meaning for another.
        layers = [{key: value for key, value in layer.items() if key != "observer"} for layer in layers]
    return merged(*layers, changes)


def make(
    name: BaselineLike, scenario: Scenario, num_spacecraft: int = 1, gains: str = "default", **changes: Any
) -> Baseline:
    """Build a baseline and check its linear loop with the nominal spacecraft.

    Parameters
    ----------
    name
        One of :func:`names`; for a custom baseline its class or ``"module:Class"``.
    scenario
        The task.
    num_spacecraft
        Number of spacecraft N.
    gains
        ``"default"`` for the gains of the entry, ``"tuned"`` for those tuned for a task of the package, or the file
        ``FILE.json`` of a search by ``ftac-tune`` (:mod:`.tuned`).
    **changes
        Gains that differ from these; see the class.

    Raises
    ------
    TypeError
        If a gain is unknown.
    ValueError
        If the name is unknown, a gain breaks a rule, there are no tuned gains, or the baseline does not fit
        the scenario. Errors of a custom baseline are raised unchanged.

    Warns
    -----
    SampledInstability
        If the control period is too long for the gains.
    """
    baseline = build(name, scenario, num_spacecraft, gains, **changes)
    warn_of_long_period(baseline)
    return baseline


def build(
    name: BaselineLike, scenario: Scenario, num_spacecraft: int = 1, gains: str = "default", **changes: Any
) -> Baseline:
    """Build a baseline as :func:`make` does, without the check: for trials of a search, whose gains may be any."""
    baseline = baseline_class(name)
    if not _registered(name):
        return baseline(scenario, num_spacecraft, **chosen(name, gains, changes))
    known = sorted(defaults(name))
    require_keywords(changes, known, "baselines.make", f"gains of {name}")
    found = chosen(name, gains, changes)
    for gain in found:
        require(gain in known, f"tuned gains of {name}", f"must be among {known}", gain)
    try:
        return baseline(scenario, num_spacecraft, **found)
    except ValueError as error:
        raise ValueError(f"{name}: {error}") from None


def defaults(name: BaselineLike) -> dict[str, Any]:
    """Return the default gains of a baseline, by name.

    Raises
    ------
    ValueError
        If the name is unknown.
    """
    entry = _entry(name)
    parameters = inspect.signature(entry.baseline).parameters.values()
    gains = {item.name: item.default for item in parameters if item.default is not item.empty}
    gains.pop("num_spacecraft", None)
    return merged(gains, entry.gains)


def search_space(name: BaselineLike) -> SearchSpace:
    """Return the ranges that a tuner searches for a baseline, by the name of the gain.

    Raises
    ------
    ValueError
        If the name is unknown.
    """
    entry = _entry(name)
    return entry.baseline.space(**entry.gains)
