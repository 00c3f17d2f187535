"""Limits of what the plant integrates: a scenario beyond them is refused before anything flies."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from ftac_gym.faults.sensor_faults import GyroBiasStep
from ftac_gym.faults.wheel_faults import Bias
from ftac_gym.task.inertia import InertiaUncertainty, exact_inertia
from ftac_gym.task.reach import LARGEST_TURN, check_reach
from ftac_gym.task.references import MRPSinusoid, RateProfile
from ftac_gym.task.sensor_suite import SensorSuite
from ftac_gym.task.vibration import LARGEST_PHASE, AppendageUncertainty, check_modes
from ftac_gym.utils.parameters import FloatArray, Interval, fields_named, largest, require
from ftac_gym.utils.sizes import LARGEST_NUMBER, check_size

if TYPE_CHECKING:
    from ftac_gym.task.scenario import Scenario

SMALLEST_SCALE = 1e-15
"""Limit of numbers that others are divided by: quotients too stay within double precision."""

SHORTEST_STEP = 1e-6
"""Limit of the steps [s]: the plant takes times as equal that are 1e-9 s apart."""

MOST_SUBSTEPS = 100_000
"""Limit of the physics steps of a control period: the torques at all of them are held in memory."""

MOST_PERIODS = 2**32
"""Limit of the control periods of an episode: the noise of the sensors counts them in 32 bits."""


def check_numbers(scenario: Scenario) -> None:
    """Check each number of a scenario for itself.

    Raises
    ------
    ValueError
        If a number is too large, or a step is too short.
    """
    check_size(scenario, "")
    for name in ("physics_step", "control_period"):
        value = getattr(scenario, name)
        require(value >= SHORTEST_STEP, name, f"must be at least {SHORTEST_STEP:g} s", value)
    wheels = scenario.spacecraft.wheels
    scales: dict[str, FloatArray | float] = {
        f"spacecraft.wheels.{name}": np.array(value)
        for name in ("torque_limit", "momentum_limit", "spin_inertia", "speed_limit", "lag", "power_limit")
        if (value := getattr(wheels, name)) is not None
    }
    for index, friction in enumerate(wheels.frictions):
        if friction is not None:
            scales[f"spacecraft.wheels.friction[{index}].breakaway_speed"] = friction.breakaway_speed
    if (appendages := scenario.spacecraft.appendages) is not None:
        scales["spacecraft.appendages.frequencies"] = np.array(appendages.frequencies)
    for part, names in (("success", ("angle", "rate")), ("reward", ("rate_scale", "vibration_scale"))):
        scales |= {f"{part}.{name}": getattr(getattr(scenario, part), name) for name in names}
    for path, fault in _faults(scenario):
        if isinstance(fault, Bias):
            torque = float(fault.largest_torque(scenario.duration, wheels.torque_limits)[0])
            rule = f"must stay within {LARGEST_NUMBER:g} N m until the end of the episode"
            require(torque <= LARGEST_NUMBER, path, rule, torque)
    for name, values in scales.items():
        least = float(np.min(values))
        require(least >= SMALLEST_SCALE, name, f"must be at least {SMALLEST_SCALE:g}", least)


def check_motion(scenario: Scenario) -> None:
    """Check that the plant can integrate whatever the numbers of a scenario make together.

    Raises
    ------
    ValueError
        If a part is too fast for the physics step, or a sensor error is larger than what it measures.
    """
    rule = f"must fit at most {MOST_SUBSTEPS} times into a control_period"
    require(scenario.substeps <= MOST_SUBSTEPS, "physics_step", rule, scenario.physics_step)
    rule = f"must be at most {MOST_PERIODS} control periods"
    require(scenario.horizon <= MOST_PERIODS, "duration", rule, scenario.duration)
    _check_body(scenario)
    check_reach(scenario)
    _check_sensors(scenario)
    _check_frequencies(scenario)


def _check_sensors(scenario: Scenario) -> None:
    """Check that sensor errors are not larger than what they measure."""
    # A gyro need not report more than the plant integrates.
    fastest = LARGEST_TURN / scenario.physics_step
    rates: dict[str, Interval] = {}
    sensors = scenario.sensors
    if isinstance(sensors, SensorSuite):
        with fields_named("sensors."):
            sensors.check(scenario.control_period, scenario.duration, fastest)
    elif sensors is not None:
        require(
            sensors.attitude_noise <= math.pi, "sensors.attitude_noise", "must be at most pi", sensors.attitude_noise
        )
        rates["sensors.rate_noise"], rates["sensors.gyro_bias"] = sensors.rate_noise, sensors.gyro_bias
        longest = fastest / math.sqrt(scenario.duration)
        rule = f"must be at most {longest:.4g}: by the end of the episode it adds up to {fastest:.4g} rad/s"
        require(sensors.gyro_bias_walk <= longest, "sensors.gyro_bias_walk", rule, sensors.gyro_bias_walk)
    for path, fault in _faults(scenario):
        if isinstance(fault, GyroBiasStep):
            rates[f"{path}.size"] = fault.size
    for name, value in rates.items():
        rule = f"must be at most {fastest:.4g} rad/s, {LARGEST_TURN:g} rad in a physics_step"
        require(largest(value) <= fastest, name, rule, value)


def _check_frequencies(scenario: Scenario) -> None:
    """Check that the step resolves everything that oscillates by itself, and the turning of the reference."""
    step, reference = scenario.physics_step, scenario.reference
    waves: list[tuple[str, Interval, Interval]] = []
    if isinstance(reference, (MRPSinusoid, RateProfile)):
        for axis, (amplitude, frequency) in enumerate(zip(reference.amplitude, reference.frequency, strict=True)):
            waves.append((f"reference.frequency[{axis}]", amplitude, frequency))
    for path, source in scenario.external_torque.paths:
        for index, harmonic in enumerate(getattr(source, "harmonics", ())):
            swing = max(map(largest, harmonic.amplitude))
            waves.append((f"{path}.harmonics[{index}].frequency", swing, harmonic.frequency))
    if (inertia := scenario.inertia_uncertainty) is not None:
        for axis, (size, rate) in enumerate(zip(inertia.amplitude, inertia.frequency, strict=True)):
            waves.append((f"inertia_uncertainty.frequency[{axis}]", size, rate))
    for path, fault in _faults(scenario):
        if hasattr(fault, "frequency"):
            waves.append((f"{path}.frequency", getattr(fault, "amplitude", 1.0), fault.frequency))
    highest = LARGEST_PHASE / step
    for name, amplitude, frequency in waves:
        rule = f"must be at most {highest:.4g} rad/s, {LARGEST_PHASE:g} rad in a physics_step of {step:g} s"
        require(largest(amplitude) == 0.0 or largest(frequency) <= highest, name, rule, frequency)
    rule = f"must turn at {LARGEST_TURN / step:.4g} rad/s at most, {LARGEST_TURN:g} rad in a physics_step of {step:g} s"
    require(reference.largest_rate * step <= LARGEST_TURN, "reference", rule, reference.largest_rate)


def _check_body(scenario: Scenario) -> None:
    """Check that the largest uncertainties leave a body, and modes that the step resolves.

    Modes are checked with the nominal inertia where it is random: the extremes are rare, and what is drawn is checked
    when it is drawn.
    """
    uncertainty, nominal = scenario.inertia_uncertainty or InertiaUncertainty(), scenario.spacecraft.inertia_matrix
    extremes = np.array(list(product((0.0, 1.0), repeat=uncertainty.uniform_count)))
    uncertainty.draw(nominal, extremes)
    inertia = exact_inertia(nominal, 1)
    if uncertainty.relative == 0.0:
        inertia = uncertainty.draw(nominal, np.full((1, uncertainty.uniform_count), 0.5))
    if (appendages := scenario.spacecraft.appendages) is not None:
        modes = (scenario.appendage_uncertainty or AppendageUncertainty()).extreme(appendages)
        check_modes(modes, inertia, scenario.physics_step)


def _faults(scenario: Scenario) -> Iterator[tuple[str, Any]]:
    """Iterate over paths and faults."""
    for path, fault in () if scenario.faults is None else scenario.faults.paths:
        yield f"faults.{path}", fault
