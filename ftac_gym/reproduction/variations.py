"""Variations of a paper's scenario that its reproduction needs."""

from __future__ import annotations

from dataclasses import replace

from ftac_gym.task.scenario import Scenario

UNLIMITED = 1e9
"""Torque limit [N m] far above any command of the papers' laws."""


def with_limit(scenario: Scenario, torque_limit: float) -> Scenario:
    """Return a scenario with other torque limits [N m]."""
    wheels = replace(scenario.spacecraft.wheels, torque_limit=torque_limit)
    return scenario.replace(spacecraft=replace(scenario.spacecraft, wheels=wheels))


def sampled(scenario: Scenario, period: float, duration: float) -> Scenario:
    """Return a scenario with another control period and duration [s]; the plant's step is at most 10 ms."""
    return scenario.replace(control_period=period, physics_step=min(period, 0.01), duration=duration)
