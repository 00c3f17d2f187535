"""Episodes from elsewhere as those of a scenario: checked, and with the labels of its duration and success.

Episodes hold what is drawn: start, inertia, modes, faults, external torque, sensor errors and reference. All else
is of the scenario that flies them, such as control period, duration and reward.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from ftac_gym.faults.checking import check_faults
from ftac_gym.task.disturbances import DISTURBANCE, HARMONIC
from ftac_gym.task.episodes import Episodes
from ftac_gym.task.gyro import LARGEST_SCALE_FACTOR, PART_PER_MILLION
from ftac_gym.task.inertia import INERTIA, InertiaUncertainty
from ftac_gym.task.initial_state import initial_dtype
from ftac_gym.task.reach import LARGEST_TURN, extreme_moments, fastest_rate, moment_ratios, push_time
from ftac_gym.task.references import REFERENCE, SET_POINT, ReferenceKind
from ftac_gym.task.scenario import LONGEST_EXTRA, Scenario
from ftac_gym.task.sensor_suite import SUITE, SensorSuite
from ftac_gym.task.sensors import LARGEST_MISALIGNMENT, SENSOR
from ftac_gym.task.vibration import LARGEST_PHASE, MODE, check_modes
from ftac_gym.utils.parameters import FloatArray, fields_named, require
from ftac_gym.utils.sizes import LARGEST_NUMBER
from ftac_gym.utils.tables import FLAG, NOT_NEGATIVE, UNIT_QUATERNION, Rule, check_fields, check_form, check_values


def fitted(episodes: Episodes, scenario: Scenario) -> Episodes:
    """Return episodes as those of a scenario.

    Parameters
    ----------
    episodes
        Episodes from any source, of this scenario or of another one with the same plant and reference.
    scenario
        The scenario that is to fly them.

    Returns
    -------
    The same episodes. Their labels of feasibility are kept if duration and criterion of success are the same, and
    computed anew otherwise.

    Raises
    ------
    ValueError
        If they are for another plant or reference, or an array is not one that the compiled plant can take. The message
        names the array and the field.
    """
    require(isinstance(episodes, Episodes), "episodes", "must be an Episodes object", episodes)
    _check_forms(episodes, scenario)
    if episodes.scenario_json == scenario.to_json():
        _check_numbers(episodes, scenario)
        return episodes
    drawn_from = Scenario.from_json(episodes.scenario_json)
    for part, of in _KEPT.items():
        rule = f"must be drawn for the same {part} as {scenario.name}'s"
        require(of(drawn_from) == of(scenario), "episodes", rule, drawn_from.name)
    _check_numbers(episodes, scenario)
    labelled = replace(episodes, scenario_json=scenario.to_json())
    if (drawn_from.duration, drawn_from.success) == (scenario.duration, scenario.success):
        return labelled
    return replace(labelled, feasible=scenario.feasibility(labelled))


_KEPT: Mapping[str, Callable[[Scenario], Any]] = {
    "spacecraft": lambda scenario: scenario.spacecraft,
    "reference": lambda scenario: scenario.reference,
    "misalignment": lambda scenario: scenario.misalignment,
    "rate_torque": lambda scenario: (scenario.inertia_uncertainty or InertiaUncertainty()).rate_torque,
}
"""Parts of a scenario to which the drawn numbers belong."""


def _check_forms(episodes: Episodes, scenario: Scenario) -> None:
    """Check the data types and shapes of all arrays but those of faults."""
    wheels, modes = scenario.spacecraft.wheels.count, scenario.spacecraft.modes
    for name, count, rule in (
        ("faults", wheels, f"must have {wheels} wheels"),
        ("modes", modes, f"must be of spacecraft with {modes} vibration modes"),
    ):
        given: tuple[int, ...] = getattr(getattr(episodes, name), "shape", ())
        require(given[1:2] == (count,), "episodes", rule, given[1] if len(given) > 1 else None)
    sensor = SUITE if isinstance(scenario.sensors, SensorSuite) else SENSOR
    given_sensor = getattr(getattr(episodes, "sensors", None), "dtype", None)
    if given_sensor in (SUITE, SENSOR):
        rule = f"must be drawn with a SensorSuite if and only if {scenario.name} has one, not with sensors of the form"
        require(given_sensor == sensor, "episodes", rule, given_sensor.names)
    torque = scenario.external_torque
    _, harmonics = torque.draw(np.zeros((0, torque.uniform_count)), np.zeros((0, 3, 3)))
    _, points = scenario.reference.draw(np.zeros((0, scenario.reference.uniform_count)))
    forms: Mapping[str, tuple[Any, tuple[int, ...]]] = {
        "key": (np.uint32, (2,)),
        "initial": (initial_dtype(wheels, modes), ()),
        "inertia": (INERTIA, ()),
        "disturbance": (DISTURBANCE, ()),
        "harmonics": (HARMONIC, harmonics.shape[1:]),
        "sensors": (sensor, ()),
        "reference": (REFERENCE, ()),
        "set_points": (SET_POINT, points.shape[1:]),
        "feasible": (np.bool_, ()),
        "modes": (MODE, (modes,)),
        "extra_delay": (np.int64, ()),
    }
    with fields_named("episodes must fit the scenario: "):
        check_form(episodes.index, np.int64, (None,), "index")
        for name, (dtype, shape) in forms.items():
            check_form(getattr(episodes, name), dtype, (len(episodes), *shape), name)


def _check_numbers(episodes: Episodes, scenario: Scenario) -> None:
    """Check the numbers in all arrays, and also the form of those of faults."""
    wheels = scenario.spacecraft.wheels
    kind = scenario.reference.draw(np.zeros((1, scenario.reference.uniform_count)))[0]["kind"]
    with fields_named("episodes."):
        check_values(episodes.index, NOT_NEGATIVE, "index")
        short: Rule = (
            lambda values: (values >= 0) & (values <= LONGEST_EXTRA),
            f"must be within [0, {LONGEST_EXTRA}] control periods",
        )
        check_values(episodes.extra_delay, short, "extra_delay")
        for name, rules in {**_RULES, "sensors": _sensor_rules(scenario)}.items():
            table = getattr(episodes, name)
            check_fields(table, rules, name)
            for field in table.dtype.names or ():
                check_values(table[field], _SIZE, f"{name}.{field}")
        same_kind: Rule = lambda values: values == kind, f"must be {kind[0]} for a {type(scenario.reference).__name__}"
        check_values(episodes.reference["kind"], same_kind, "reference.kind")
        inside: Rule = lambda values: np.abs(values) <= wheels.momentum_limits, "must stay within the momentum limits"
        check_values(episodes.initial["wheel_momentum"], inside, "initial.wheel_momentum")
        fastest = fastest_rate(scenario)
        slow: Rule = lambda values: np.linalg.norm(values, axis=-1) <= fastest, f"must be at most {fastest:.4g} rad/s"
        check_values(episodes.initial["rate"], slow, "initial.rate")
        varying = np.abs(episodes.inertia["amplitude"])[:, :, None] * np.eye(3)
        least = np.linalg.eigvalsh(episodes.inertia["constant"] - varying)[:, 0]
        definite: Rule = lambda values: values > 0.0, "must stay positive definite; the smallest eigenvalue [kg m^2]"
        check_values(least, definite, "inertia.constant")
        check_faults(episodes.drawn_faults, len(episodes), wheels.count)
        check_modes(episodes.modes, episodes.inertia, scenario.physics_step)
        moments = extreme_moments(scenario)
        _check_body(episodes, scenario, *moments)
        _check_torque(episodes, scenario, *moments)
        _check_frequencies(episodes, scenario)


def _check_body(episodes: Episodes, scenario: Scenario, least: float, most: float) -> None:
    """Check that each body nutates no faster than those of the scenario can, and the reference turns no faster."""
    limit = max(1.0, most / least - 1.0) * (1.0 + 1e-6)
    slow: Rule = lambda values: values <= limit, f"must have |Ja - Jb| / Jc of its principal moments within {limit:.4g}"
    check_values(moment_ratios(episodes.inertia["constant"]), slow, "inertia.constant")
    reference, fastest = episodes.reference, LARGEST_TURN / scenario.physics_step * (1.0 + 1e-9)
    swing = np.abs(reference["amplitude"])
    sinusoid = 4.0 * np.linalg.norm(swing * reference["frequency"], axis=1)
    profile = np.linalg.norm(np.abs(reference["constant"]) + swing, axis=1)
    still = np.zeros(len(reference))  # A sampled reference is that of the scenario.
    rates = np.select([reference["kind"] == kind for kind in ReferenceKind], [still, sinusoid, profile, still])
    turning: Rule = lambda values: values <= fastest, f"must make a reference of at most {fastest:.4g} rad/s"
    check_values(rates, turning, "reference.amplitude")


def _check_torque(episodes: Episodes, scenario: Scenario, least: float, most: float) -> None:
    """Check that the external torque is one of the scenario, or no more than what it takes to reach the fastest rate.

    A torque that grows with the rate may double 1 rad/s at most.
    """
    source = scenario.external_torque
    # A part of a series can be larger than the sum, about which the bound is.
    own = 4.0 * source.largest_torque(most)
    fastest, scaled = fastest_rate(scenario), episodes.disturbance["rate_scaled"] > 0.0
    limit = np.maximum(own, np.where(scaled, min(fastest, 1.0), fastest) * least / push_time(scenario))
    sizes = {
        f"harmonics.{name}": np.linalg.norm(np.abs(episodes.harmonics[name]).sum(axis=1), axis=1)
        for name in ("sine", "cosine")
    }
    sizes["disturbance.constant"] = np.linalg.norm(episodes.disturbance["constant"], axis=1)
    for name, torque in sizes.items():
        small: Rule = lambda values: values <= limit, f"must be at most {limit.min(initial=np.inf):.4g} N m"
        check_values(torque, small, name)
    offset = episodes.disturbance["rate_offset"]
    torque = sum(sizes.values()) * scaled * offset
    own *= source.rate_offset or 0.0
    most_torque = max(3.0 * own, fastest * least / push_time(scenario))
    slow: Rule = lambda values: values <= most_torque, f"times the torque must be at most {most_torque:.4g} N m"
    check_values(torque, slow, "disturbance.rate_offset")


def _check_frequencies(episodes: Episodes, scenario: Scenario) -> None:
    """Check that the step resolves everything that oscillates by itself."""
    highest = LARGEST_PHASE / scenario.physics_step * (1.0 + 1e-9)
    harmonics = episodes.harmonics
    waves: dict[str, tuple[FloatArray, FloatArray]] = {
        "inertia": (episodes.inertia["amplitude"], episodes.inertia["frequency"]),
        "harmonics": (
            np.abs(harmonics["sine"]).sum(axis=-1) + np.abs(harmonics["cosine"]).sum(axis=-1),
            harmonics["frequency"],
        ),
        "reference": (episodes.reference["amplitude"], episodes.reference["frequency"]),
    }
    resolved: Rule = lambda values: np.abs(values) <= highest, f"must be at most {highest:.4g} rad/s"
    for name, (size, frequency) in waves.items():
        check_values(np.where(size == 0.0, 0.0, frequency), resolved, f"{name}.frequency")


_MISALIGNMENT: Rule = (
    lambda values: np.linalg.norm(values, axis=-1) <= LARGEST_MISALIGNMENT * (1.0 + 1e-9),
    f"must be a rotation vector of at most {LARGEST_MISALIGNMENT:g} rad",
)


def _sensor_rules(scenario: Scenario) -> Mapping[str, Rule]:
    """Return the rules of the sensor records of a scenario."""
    suite, period = scenario.sensors, scenario.control_period
    if not isinstance(suite, SensorSuite):
        simple = dict.fromkeys(("attitude_noise", "rate_noise", "gyro_bias_walk"), NOT_NEGATIVE)
        return {**simple, "gyro_misalignment": _MISALIGNMENT}
    names = [name for name in SUITE.names or () if SUITE[name].ndim == 0]
    longest = (suite.fixes(period) * suite.tracker_periods(period) - 1.0 + 1e-9) * period
    largest = LARGEST_SCALE_FACTOR * PART_PER_MILLION * (1.0 + 1e-9)
    return {
        **dict.fromkeys(names, NOT_NEGATIVE),
        "latency": (
            lambda values: (values >= 0.0) & (values <= longest),
            f"must be within [0, {longest:.4g}] s: {scenario.name} stores no more samples of its star tracker",
        ),
        "correlation_time": (lambda values: np.isfinite(values) & (values > 0.0), "must be positive"),
        "boresight": (lambda values: np.abs(np.linalg.norm(values, axis=-1) - 1.0) < 1e-6, "must be a unit vector"),
        "scale_factor": (lambda values: np.abs(values) <= largest, f"must be within {largest:.4g} of zero"),
        "gyro_misalignment": _MISALIGNMENT,
    }


_SIZE: Rule = (
    lambda values: np.abs(values) <= 10.0 * LARGEST_NUMBER,
    f"must be within {10.0 * LARGEST_NUMBER:g} of zero",
)
"""Rule of every number: what a scenario draws is a little larger than its own numbers."""


_RULES: Mapping[str, Mapping[str, Rule]] = {
    "initial": {"attitude": UNIT_QUATERNION},
    "inertia": {
        "constant": (
            lambda values: np.isfinite(values) & np.isclose(values, values.swapaxes(1, 2), rtol=1e-9),
            "must be finite and symmetric",
        )
    },
    "disturbance": {"rate_scaled": FLAG, "rate_offset": NOT_NEGATIVE},
    "harmonics": {},
    "reference": {"attitude": UNIT_QUATERNION},
    "set_points": {
        "attitude": UNIT_QUATERNION,
        "time": (
            lambda values: np.isfinite(values) & (np.diff(values, axis=1, prepend=-1.0) > 0.0) & (values[:, :1] == 0.0),
            "must start at 0 and increase",
        ),
    },
    "modes": {"stiffness": NOT_NEGATIVE, "damping": NOT_NEGATIVE},
}
"""Rules of the fields of records for which it is not enough to be finite."""
