"""Variations of a paper's scenario that its reproduction needs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ftac_gym.reproduction.flight import Flight
from ftac_gym.task.scenario import Scenario

UNLIMITED = 1e9
"""Torque limit [N m] that no law here comes near."""


def with_limit(scenario: Scenario, torque_limit: float) -> Scenario:
    """Return a scenario with other torque limits [N m]."""
    wheels = replace(scenario.spacecraft.wheels, torque_limit=torque_limit)
    return scenario.replace(spacecraft=replace(scenario.spacecraft, wheels=wheels))


def sampled(scenario: Scenario, period: float, duration: float) -> Scenario:
    """Return a scenario with another control period and duration [s]; the plant's step is at most 10 ms."""
    return scenario.replace(control_period=period, physics_step=min(period, 0.01), duration=duration)


def settled(flight: Flight, angle: float = 0.1) -> str:
    """Say when the error falls below an angle [deg] for good."""
    return seconds(flight.settling(angle))


def seconds(time: float) -> str:
    """Return a time [s] in words; infinity is never."""
    return f"{time:.1f} s" if np.isfinite(time) else "never"
