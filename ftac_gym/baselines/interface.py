"""Measurements from an environment, and actions to it."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from ftac_gym.faults import FaultEffect
from ftac_gym.task.measurement import Measurement
from ftac_gym.utils.parameters import FloatArray, require


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
    source = getattr(env, "unwrapped", env)
    if callable(getattr(source, "measurement", None)):
        measurement: Measurement = source.measurement(truth=truth)
        return measurement
    # Stable-Baselines3's own vector environments hold single environments.
    require(callable(getattr(env, "env_method", None)), "env", "must have a measurement() method", env)
    parts = env.env_method("measurement", truth=truth)
    names = [field.name for field in dataclasses.fields(Measurement) if field.name != "truth"]
    effect = FaultEffect(*map(np.concatenate, zip(*(part.truth for part in parts), strict=True))) if truth else None
    arrays = {name: np.concatenate([getattr(part, name) for part in parts]) for name in names}
    return Measurement(**arrays, truth=effect)


def as_action(command: FloatArray, torque_limits: FloatArray) -> FloatArray:
    """Turn wheel torques [N m] into an action, (N, wheels) fractions of the limits within [-1, 1]."""
    return np.clip(command / torque_limits, -1.0, 1.0)
