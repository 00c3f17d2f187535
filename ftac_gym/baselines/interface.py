"""Measurements from an environment, and actions to it."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from ftac_gym.faults import FaultEffect
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, require


def source_of(env: Any) -> Any:
    """Return the environment with the measurements, inside of all wrappers.

    Raises
    ------
    ValueError
        If the environment has no measurement.
    """
    source = getattr(env, "unwrapped", env)
    known = callable(getattr(source, "measurement", None)) or callable(getattr(env, "env_method", None))
    require(known, "env", "must have a measurement() method", env)
    return source


def measurement_of(env: Any, truth: bool = False) -> Measurement:
    """Return the measurement of all spacecraft of an environment.

    Parameters
    ----------
    env
        A Gymnasium environment, a vector environment or an SB3 vector environment of this package, wrapped or not.
    truth
        Whether to add the fault effects, for an oracle.

    Raises
    ------
    ValueError
        If the environment has no measurement.
    """
    source = source_of(env)
    if callable(getattr(source, "measurement", None)):
        measurement: Measurement = source.measurement(truth=truth)
        return measurement
    # Stable-Baselines3's own vector environments hold single environments.
    parts = env.env_method("measurement", truth=truth)
    names = [field.name for field in dataclasses.fields(Measurement) if field.name != "truth"]
    effect = FaultEffect(*map(np.concatenate, zip(*(part.truth for part in parts), strict=True))) if truth else None
    arrays = {name: np.concatenate([getattr(part, name) for part in parts]) for name in names}
    return Measurement(**arrays, truth=effect)


def check_scenario(env: Any, scenario: Scenario, num_spacecraft: int) -> None:
    """Refuse an environment that differs in what a baseline is built from.

    Faults, disturbance, starts and uncertainties are the environment's own: no baseline is built from them. Sensors and
    loop delay may differ too, for studies of what a baseline is not told: it keeps its own models of them.

    Parameters
    ----------
    env
        The environment, as for :func:`measurement_of`.
    scenario, num_spacecraft
        Those of the baseline.

    Raises
    ------
    ValueError
        If the environment has no measurement, another number of spacecraft, or another nominal spacecraft, control
        period, motion of the reference or prescribed bound; or if a wrapper changes what an action means.
    """
    source = source_of(env)
    # Stable-Baselines3's vector environments answer for the environments inside.
    several = callable(getattr(env, "env_method", None))
    found = env.get_attr("scenario") if several else [getattr(source, "scenario", scenario)]
    count = getattr(source, "num_envs", 1)
    require(count == num_spacecraft, "num_spacecraft", f"must be that of the environment, {count}", num_spacecraft)
    for other in found:
        parts = [name for name, part in _parts(scenario).items() if part != _parts(other)[name]]
        rule = "must be built from the scenario of the environment, env.unwrapped.scenario"
        periods = f" ({scenario.control_period:g} and {other.control_period:g} s)" if "control_period" in parts else ""
        if parts:
            raise ValueError(f"baseline {rule}, got {scenario.name!r} with another {', '.join(parts)}{periods}")
    _check_actions(env, scenario.spacecraft.wheels.count)


def _check_actions(env: Any, wheels: int) -> None:
    """Refuse an environment whose actions are not commands to the wheels, as fractions of their limits."""
    rule = "must take commands to the wheels: no wrapper between it and the baseline may change what an action means"
    space = getattr(env, "single_action_space", getattr(env, "action_space", None))
    if space is not None:
        meant = space.shape == (wheels,) and bool((space.low == -1.0).all() and (space.high == 1.0).all())
        require(meant, "env", rule, space)
    layer = env
    while layer is not None:
        taken = getattr(getattr(layer, "__dict__", {}).get("transform"), "acts", False)
        require(not taken, "env", rule, layer)
        inside = getattr(layer, "__dict__", {})
        layer = inside.get("env") or inside.get("venv") or next(iter(inside.get("envs", ())), None)


def _parts(scenario: Scenario) -> dict[str, Any]:
    """Return the parts of a scenario that a baseline is built from, by name."""
    spacecraft, wheels = scenario.spacecraft, scenario.spacecraft.wheels
    return {
        "inertia": spacecraft.inertia,
        "appendages": spacecraft.appendages,
        **{name: getattr(wheels, name) for name in ("axes", "torque_limit", "momentum_limit", "momentum_coupling")},
        "control_period": scenario.control_period,
        "kind of reference (moving or at rest)": scenario.reference.moving,
        "prescribed_bound": scenario.prescribed_bound,
    }


def as_action(command: FloatArray, torque_limits: FloatArray) -> FloatArray:
    """Turn wheel torques [N m] into an action, (N, wheels) fractions of the limits within [-1, 1]."""
    return np.clip(command / torque_limits, -1.0, 1.0)
