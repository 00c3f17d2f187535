"""What the code does not say of the baselines: what each is, what it is made for, and where the reports speak of it."""

from __future__ import annotations

from dataclasses import dataclass

from ftac_gym.utils.parameters import require


@dataclass(frozen=True)
class Flown:
    """Where a baseline is flown for its figure.

    Parameters
    ----------
    scenario
        Name of the scenario.
    duration
        How long [s]; None for its own duration.
    hold
        Length of the last part by which the flight is judged [s]; None for its own.
    """

    scenario: str
    duration: float | None = None
    hold: float | None = None


@dataclass(frozen=True)
class Reported:
    """Where a report speaks of a baseline.

    Parameters
    ----------
    report
        Folder of the report.
    flights
        Pattern of the whole name of its flights in the tables of all schemes.
    claims
        Pattern that is found in the rows of its claims; None if no claim is about it.
    """

    report: str
    flights: str
    claims: str | None


@dataclass(frozen=True)
class About:
    """What a page says that follows from no code.

    Parameters
    ----------
    summary
        What the baseline is, in a sentence without its full stop.
    made_for
        Scenarios that it is made for.
    flown
        The one of the figure.
    reported
        Where a report speaks of it; None if none does.
    """

    summary: str
    made_for: tuple[str, ...]
    flown: Flown
    reported: Reported | None = None


FLAGSHIP = ("flagship",)
REST, TURNING = "zhang_zhou_2019_stabilisation", "zhang_zhou_2019_feasible"
ZHANG_ZHOU, CAO, MA, CHEN, LI = "zhang_zhou_2019", "cao_2022", "ma_2023", "chen_2018", "li_2023"
BEFORE, TRUTH = "taking every wheel for healthy", "told the true faults: a bound, no contestant"


def _flagship(summary: str, reported: Reported | None = None) -> About:
    return About(summary, FLAGSHIP, Flown("flagship"), reported)


def _rest(summary: str, flights: str, claims: str) -> About:
    return About(summary, (REST,), Flown(REST, 20.0, 5.0), Reported(ZHANG_ZHOU, flights, claims))


def _turning(summary: str, flights: str, claims: str) -> About:
    scenarios = (TURNING, "zhang_zhou_2019", "zhang_zhou_2019_2nm")
    return About(summary, scenarios, Flown(TURNING, 22.0, 5.0), Reported(ZHANG_ZHOU, flights, claims))


def _cao(summary: str, flights: str, claims: str | None, duration: float = 16.0) -> About:
    return About(summary, (CAO,), Flown(CAO, duration, 5.0), Reported(CAO, flights, claims))


def _ma(summary: str, scenario: str, flights: str, claims: str) -> About:
    return About(summary, (scenario,), Flown(scenario, 20.0, 5.0), Reported(MA, flights, claims))


def _chen(summary: str, flights: str, claims: str) -> About:
    return About(summary, (CHEN,), Flown(CHEN, 40.0, 5.0), Reported(CHEN, flights, claims))


def _li(summary: str, flights: str, claims: str, *more: str) -> About:
    return About(summary, (LI, *more), Flown(LI, 135.0, 5.0), Reported(LI, flights, claims))


_ABOUT: dict[str, About] = {
    "pd": _flagship("Proportional-derivative control with a braking profile, which knows nothing of faults"),
    "pd_dob": _flagship(
        "The law of `pd` less the torque that a disturbance observer sees: the base of the shipped residual agents",
        Reported(LI, "pd_dob", "pd_dob"),
    ),
    "nftsm": _flagship(f"Non-singular fast terminal sliding mode for a sampled craft, {BEFORE}"),
    "nftsm_observer": _flagship("The law of `nftsm` on the effectiveness and bias that the observer `asmo` finds"),
    "nftsm_telemetry": _flagship("The law of `nftsm` on the bias that the tachometer of each wheel shows"),
    "nftsm_oracle": _flagship(f"The law of `nftsm` {TRUTH}"),
    "predefined_time": _flagship(f"Predefined-time sliding mode for a sampled craft, {BEFORE}"),
    "predefined_time_observer": _flagship(
        "The law of `predefined_time` on the effectiveness and the unexplained torque that `lo_corrected` finds"
    ),
    "predefined_time_telemetry": _flagship(
        "The law of `predefined_time` on the bias that the tachometer of each wheel shows"
    ),
    "predefined_time_oracle": _flagship(f"The law of `predefined_time` {TRUTH}"),
    "prescribed_performance": _flagship(
        "Prescribed performance for a sampled craft, with bounds that its wheels can follow",
        Reported(CHEN, "prescribed performance", None),
    ),
    "zhang_zhou_stabilisation": _rest(
        "Stabilisation by terminal sliding mode and network on the faults that `asmo` finds, as published",
        r"stabilisation(?!, (no observer|oracle)).*",
        "at rest|stabilis",
    ),
    "zhang_zhou_stabilisation_no_observer": _rest(
        f"The stabilising law {BEFORE}", "stabilisation, no observer", r"at rest: .*E\^ = I"
    ),
    "zhang_zhou_stabilisation_oracle": _rest(
        f"The stabilising law {TRUTH}", "stabilisation, oracle", "at rest: .*exact"
    ),
    "zhang_zhou_tracking": _turning(
        "Tracking by backstepping, terminal sliding mode and network on the faults that `asmo` finds, as published",
        r"(as )?printed, (?!Shen).*|tracking(?!, (no observer|oracle)).*",
        "slowed|printed",
    ),
    "zhang_zhou_tracking_no_observer": _turning(f"The tracking law {BEFORE}", "tracking, no observer", r"E\^ = I"),
    "zhang_zhou_tracking_oracle": _turning(f"The tracking law {TRUTH}", "tracking, oracle", "exact"),
    "shen_class": About(
        "Inertia-free control within the limits of the wheels, of the family of Zhang and Zhou's comparator",
        ("shen_2019",),
        Flown("shen_2019", hold=5.0),
        Reported(ZHANG_ZHOU, "(printed, )?Shen-class.*", "Shen-class"),
    ),
    "ptc": _cao(
        "Predefined-time control on the effectiveness that `lo_corrected` finds, with an exponent that can be flown",
        r"PTC(, (LO|ASMO|sign|layer).*|, struck in the slew)?|turning, LO corrected",
        r"h1 = 0\.25|corrected|h1 = 0\.5 asks",
    ),
    "ptc_no_observer": _cao(
        f"The usable law {BEFORE}",
        r"PTC, (.*E\^ = I|5 N m|unlimited)|PTC h1 = 0\.5, 5 N m|turning, E\^ = I",
        r"E\^ = I|unlimited",
    ),
    "ptc_oracle": _cao(f"The usable law {TRUTH}", "PTC.*oracle|turning, oracle", "oracle|exact"),
    "ptc_printed": _cao(
        "Predefined-time control with the exponent, the observer and the division of the paper",
        "PTC as printed",
        "rinted",
    ),
    "ptc_printed_no_observer": _cao(f"The printed law {BEFORE}", r"PTC h1 = 0\.5, E\^ = I", r"h1 = 0\.5 with E\^ = I"),
    "ptc_printed_oracle": _cao(f"The printed law {TRUTH}", "", None),
    "ptc_regularised": _cao(
        "The exponent of the paper with the smallest change that makes it a controller, on what `lo_corrected` finds",
        r"PTC h1 = 0\.5, regularised",
        "regularised",
    ),
    "ptc_regularised_no_observer": _cao(f"The regularised law {BEFORE}", "", None),
    "ptc_regularised_oracle": _cao(f"The regularised law {TRUTH}", "", None),
    "tsmc_class": _cao(
        f"Terminal sliding mode of the family of Cao's comparator, with gains of ours, {BEFORE}",
        "TSMC-class.*",
        "TSMC",
        30.0,
    ),
    "tsmc_class_oracle": _cao(f"The comparator's law {TRUTH}", "", None, 30.0),
    "hsfc": _ma(
        "Hybrid control within a bound of the torque, as printed with the gains of section 5.1",
        "ma_2023_faulty",
        r"5\.1, (printed|sign|without u2).*|5\.2, gains of 5\.1.*",
        "printed|gains of 5.1",
    ),
    "hsfc_componentwise": _ma(
        "HSFC with |u1_i| in the term that answers faults, and a bound on the loss that holds",
        "ma_2023_faulty",
        r"5\.1, \|u1_i\|, g0 = 0\.6.*",
        r"\|u1_i\|",
    ),
    "hsfc_floor": _ma(
        "HSFC with the gains of section 5.2 and a floor under the adaptive gain",
        "ma_2023_unwinding",
        r"5\.[12], floor.*",
        "floor",
    ),
    "afntsmc": _ma(
        "Adaptive non-singular terminal sliding mode, comparator of Ma et al.",
        "ma_2023_unwinding",
        r"5\.[12], AFNTSMC.*",
        "AFNTSMC",
    ),
    "shopd_plus": _ma(
        "Saturated hybrid output feedback without a rate, comparator of Ma et al.",
        "ma_2023_unwinding",
        r"5\.[12], SHOPD\+(?!, q_c = 0).*",
        r"SHOPD\+",
    ),
    "shopd_plus_zero_filter": _ma(
        "The law of `shopd_plus` with its filter started at zero",
        "ma_2023_unwinding",
        r"5\.[12], SHOPD\+, q_c = 0.*",
        "q_c = 0",
    ),
    "chen_m1": _chen(
        "Prescribed performance with command filter and adaptive fuzzy system, as printed",
        r"M1(?! sampled).*",
        r"\bM1\b(?! sampled)",
    ),
    "chen_m1_sampled": _chen(
        "The law of `chen_m1` without what a hold of 0.05 to 0.2 s cannot bear",
        "M1 sampled",
        "M1 sampled|M1 without filter",
    ),
    "chen_m2": _chen("Backstepping with an adaptive fuzzy system, comparator of Chen et al.", "M2.*", r"\bM2\b"),
    "chen_m3": _chen(
        "Adaptive terminal sliding mode, comparator of Chen et al., with its printed gains",
        "M3(?! scaled).*",
        r"\bM3\b",
    ),
    "chen_m3_scaled": _chen(
        "The law of `chen_m3` with two gains for a body of this size", "M3 scaled.*", "M3 scaled|scaled M3|scaled gains"
    ),
    "fuzzy_smc": _li(
        "Fuzzy sliding mode on the torques of faults and vibration that `fafeo` finds, with the published gains",
        r"FASMC(?!.*(solved|ILO|without)).*",
        "FASMC|observer|fuzzy|gamma|model|estimated",
    ),
    "fuzzy_smc_solved": _li(
        "The law of `fuzzy_smc` with gains solved for the craft, and always the short way round",
        "FASMC solved",
        "solving says|Theorem [12] gamma",
        "flexible",
    ),
    "fuzzy_smc_ilo_class": _li(
        "The law of `fuzzy_smc` on an iterative learning observer, which knows nothing of the appendages",
        "FASMC with ILO-class",
        "ILO",
    ),
    "fuzzy_pd": _li("PD control on the observer `fafeo`, comparator of Li et al.", "PD(?! gyroscopic).*", r"\bPD\b"),
    "fuzzy_pd_gyroscopic": _li(
        "The law of `fuzzy_pd`, but with the gyroscopic torque alone instead of all that is printed",
        "PD gyroscopic.*",
        "PD gyroscopic",
    ),
    "aismc": _li("Adaptive integral sliding mode, comparator of Li et al.", "AISMC.*", "AISMC"),
    "raftsmc_class": _li(
        "Fixed-time terminal sliding mode of the family of Li's comparator", "RAFTSMC-class.*", "RAFTSMC", "flexible"
    ),
    "pd_shaped": About(
        "`pd_dob` along an input-shaped slew, which leaves the modes of the panels at rest",
        ("flexible",),
        Flown("flexible"),
        Reported(LI, "pd_shaped", "pd_shaped"),
    ),
}


def about(name: str) -> About:
    """Return what is known of a baseline.

    Raises
    ------
    ValueError
        If nothing is.
    """
    require(name in _ABOUT, "baseline", "must be described in docs/scripts/baseline_facts.py", name)
    return _ABOUT[name]
