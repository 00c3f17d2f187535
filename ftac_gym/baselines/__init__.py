"""Analytical policies, by name: batched NumPy, one law per file; and by class, for laws of your own."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from dataclasses import dataclass, field
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
from ftac_gym.baselines.controllers.nftsm import NFTSM
from ftac_gym.baselines.controllers.pd import PD, PDDisturbanceObserver
from ftac_gym.baselines.controllers.pd_shaped import ShapedPD
from ftac_gym.baselines.controllers.predefined_time import PredefinedTimeLaw
from ftac_gym.baselines.controllers.prescribed_performance import PrescribedPerformance
from ftac_gym.baselines.controllers.ptc import PTC
from ftac_gym.baselines.controllers.raftsmc_class import RAFTSMCClass
from ftac_gym.baselines.controllers.shen_class import ShenClass
from ftac_gym.baselines.controllers.shopd_plus import SHOPDPlus
from ftac_gym.baselines.controllers.tsmc_class import TSMCClass
from ftac_gym.baselines.controllers.zhang_zhou_stabilisation import ZhangZhouStabilisation
from ftac_gym.baselines.controllers.zhang_zhou_tracking import ZhangZhouTracking
from ftac_gym.baselines.estimate import FaultEstimate
from ftac_gym.baselines.gains import Range, SearchSpace, merged, nested
from ftac_gym.baselines.own import Law, imported, is_path, path_of
from ftac_gym.baselines.policy import BaselinePolicy, as_action, measurement_of
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import require

GAINS = ("default", "tuned")
"""Sets of gains that :func:`make` knows by name."""


@dataclass(frozen=True)
class _Entry:
    """A law under a name, with the gains that make it that variant."""

    law: type[Baseline]
    gains: Mapping[str, Any] = field(default_factory=dict)


def _variants(name: str, law: type[Baseline], observer: str, **gains: Any) -> dict[str, _Entry]:
    """Return a law under its name with its observer, as published, and without one and with the truth."""
    return {
        name: _Entry(law, {**gains, "faults": observer}),
        f"{name}_no_observer": _Entry(law, {**gains, "faults": "none"}),
        f"{name}_oracle": _Entry(law, {**gains, "faults": "oracle"}),
    }


def _sampled(name: str, law: type[Baseline], observer: str, gains: Mapping[str, Any]) -> dict[str, _Entry]:
    """Return a law for sampled craft without an observer, with one, with the wheels' telemetry, and with the truth."""
    return {
        name: _Entry(law),
        f"{name}_observer": _Entry(law, {"faults": observer, "observer": gains}),
        f"{name}_telemetry": _Entry(law, {"faults": "tachometer"}),
        f"{name}_oracle": _Entry(law, {"faults": "oracle"}),
    }


_PUBLISHED: dict[str, Any] = {"design": "published", "torque_bound": 2.0}

_ENTRIES: dict[str, _Entry] = {
    "pd": _Entry(PD),
    "pd_dob": _Entry(PDDisturbanceObserver),
    **_sampled("nftsm", NFTSM, "asmo", {}),
    **_sampled("predefined_time", PredefinedTimeLaw, "lo_corrected", {"first": 2.0, "second": 2.0, "full_torque": 0.1}),
    **_variants("zhang_zhou_stabilisation", ZhangZhouStabilisation, "asmo"),
    **_variants("zhang_zhou_tracking", ZhangZhouTracking, "asmo"),
    **_variants("ptc", PTC, "lo_corrected"),
    **_variants("ptc_printed", PTC, "lo", position_exponent=0.5, smallest_effectiveness=1e-4),
    # Table 1's exponent with the smallest change that makes it a controller.
    **_variants("ptc_regularised", PTC, "lo_corrected", position_exponent=0.5, position_regularisation=1e-4),
    # The comparators are built from their families, hence -class.
    "tsmc_class": _Entry(TSMCClass),
    "tsmc_class_oracle": _Entry(TSMCClass, {"faults": "oracle"}),
    "shen_class": _Entry(ShenClass),
    "hsfc": _Entry(HSFC),
    "hsfc_componentwise": _Entry(HSFC, {"compensation": "componentwise", "smallest_effectiveness": 0.6}),
    # The gains of section 5.2, for healthy wheels, with a floor.
    "hsfc_floor": _Entry(
        HSFC, {"adaptation": 0.1, "smoothing": 0.01, "smallest_effectiveness": 1.0, "gamma_floor": 1.0}
    ),
    "afntsmc": _Entry(AFNTSMC),
    "shopd_plus": _Entry(SHOPDPlus),
    "shopd_plus_zero_filter": _Entry(SHOPDPlus, {"filter_start": "zero"}),
    "chen_m1": _Entry(ChenM1),
    # Without what a hold of 0.05 to 0.2 s cannot bear.
    "chen_m1_sampled": _Entry(ChenM1, {"filter_substeps": 0, "rate_power_gain": 0.0, "rate_gain": 2.0}),
    "chen_m2": _Entry(ChenM2),
    "chen_m3": _Entry(ChenM3),
    # tau and rho for a body of 350 kg m^2 instead of one of 10 to 20.
    "chen_m3_scaled": _Entry(ChenM3, {"reaching_linear": 100.0, "reaching_power_gain": 10.0}),
    "prescribed_performance": _Entry(PrescribedPerformance),
    # Li et al. 2023, for flexible craft. As published: gains of the appendix, and the quaternion as its sign has it.
    "fuzzy_smc": _Entry(FuzzySMC, {"design": "published", "observer": _PUBLISHED, "short_way": False}),
    "fuzzy_smc_solved": _Entry(FuzzySMC),
    "fuzzy_smc_ilo_class": _Entry(FuzzySMC, {"design": "published", "faults": "ilo_class", "short_way": False}),
    "fuzzy_pd": _Entry(FuzzyPD, {"observer": _PUBLISHED, "short_way": False}),
    "fuzzy_pd_gyroscopic": _Entry(FuzzyPD, {"observer": _PUBLISHED, "short_way": False, "compensation": "gyroscopic"}),
    "aismc": _Entry(AISMC, {"design": "published", "short_way": False}),
    "raftsmc_class": _Entry(RAFTSMCClass),
    "pd_shaped": _Entry(ShapedPD),
}


def names() -> list[str]:
    """Return the names of all baselines of this package."""
    return sorted(_ENTRIES)


def is_law(name: str) -> bool:
    """Tell whether a text is the name of a baseline, or says where a law of your own is, as ``"module:Class"``."""
    return name in _ENTRIES or is_path(name)


def _registered(name: Law) -> TypeGuard[str]:
    return isinstance(name, str) and name in _ENTRIES


def _entry(name: Law) -> _Entry:
    if isinstance(name, type):
        require(issubclass(name, Baseline), "baseline", "must be a name or a class that derives from Baseline", name)
        return _Entry(name)
    if is_path(name):
        return _Entry(imported(name))
    rule = f'must be one of {names()}, or "module:Class" for a law of your own'
    require(name in _ENTRIES, "baseline", rule, name)
    return _ENTRIES[name]


def law(name: Law) -> type[Baseline]:
    """Return the class of a baseline.

    Parameters
    ----------
    name
        One of :func:`names`; for a law of your own its class, or where that is, as ``"module:Class"``.

    Raises
    ------
    ValueError
        If the name is unknown, or there is no such class.
    """
    return _entry(name).law


def chosen(name: Law, gains: str, changes: Mapping[str, Any]) -> dict[str, Any]:
    """Return what :func:`make` builds a law with, but for the law's own defaults: what tells two variants apart.

    Raises
    ------
    ValueError
        If the name or the set of gains is unknown, or there are no tuned gains.
    """
    entry = _entry(name)
    require(gains in GAINS, "gains", f"must be one of {list(GAINS)}", gains)
    rule = "must be 'default' for a law that is not of this package"
    require(_registered(name) or gains == "default", "gains", rule, gains)
    layers = [entry.gains, tuned.gains(name) if _registered(name) and gains == "tuned" else {}]
    if changes.get("faults", entry.gains.get("faults")) != entry.gains.get("faults"):
        # Gains of an observer mean nothing to another.
        layers = [{key: value for key, value in layer.items() if key != "observer"} for layer in layers]
    return merged(*layers, changes)


def make(name: Law, scenario: Scenario, num_spacecraft: int = 1, gains: str = "default", **changes: Any) -> Baseline:
    """Build a baseline.

    Parameters
    ----------
    name
        One of :func:`names`; for a law of your own its class, or where that is, as ``"module:Class"``.
    scenario
        The task.
    num_spacecraft
        Number of craft.
    gains
        ``"default"`` for the law's own, ``"tuned"`` for those that ``train/tune.py`` found (:mod:`.tuned`).
    **changes
        Parameters of the law that differ from these; see its class.

    Raises
    ------
    ValueError
        If the name or a gain is unknown, a gain breaks a rule, there are no tuned gains, or the law does not fit the
        scenario. What a law of your own raises is raised as it is.
    """
    if not _registered(name):
        # Whatever goes wrong in a law of someone's own, its author wants to see where.
        return law(name)(scenario, num_spacecraft, **chosen(name, gains, changes))
    known = sorted(defaults(name))
    for change in changes:
        require(change in known, f"gains of {name}:", f"must be among {known}", change)
    try:
        return law(name)(scenario, num_spacecraft, **chosen(name, gains, changes))
    except TypeError as error:  # an unknown gain of a part
        raise ValueError(f"gains of {name}: {error}") from None
    except ValueError as error:
        raise ValueError(f"{name}: {error}") from None


def defaults(name: Law) -> dict[str, Any]:
    """Return the default gains of a baseline, by name.

    Raises
    ------
    ValueError
        If the name is unknown.
    """
    entry = _entry(name)
    gains: dict[str, Any] = {}
    for base in entry.law.__mro__:
        parameters = inspect.signature(base.__init__).parameters.values()  # type: ignore[misc]
        for parameter in parameters:
            if parameter.default is not parameter.empty and parameter.name != "num_spacecraft":
                gains.setdefault(parameter.name, parameter.default)
        if not any(parameter.kind is parameter.VAR_KEYWORD for parameter in parameters):
            break
    return merged(gains, entry.gains)


def search_space(name: Law) -> SearchSpace:
    """Return where the gains of a baseline may lie, by the name of the gain.

    Raises
    ------
    ValueError
        If the name is unknown.
    """
    entry = _entry(name)
    return entry.law.space(**entry.gains)


__all__ = [
    "GAINS",
    "Baseline",
    "BaselinePolicy",
    "FaultEstimate",
    "Law",
    "Range",
    "as_action",
    "chosen",
    "defaults",
    "is_law",
    "law",
    "make",
    "measurement_of",
    "names",
    "nested",
    "path_of",
    "search_space",
]
