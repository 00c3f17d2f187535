"""Use of the wheels.

===================== ==================================================================================================
``energy``            integral of the sum of squared applied wheel torques (means over control periods)
``chatter``           total variation of the wheel commands, summed over wheels, per second
``saturation``        share of wheel commands at their limit
``momentum_headroom`` least of 1 - ``|h|`` / limit over wheels and time; NaN if no wheel has a momentum limit
``final_headroom``    the same at the end of the episode
===================== ==================================================================================================
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ftac_gym.evaluation.metrics.metric import Metric
from ftac_gym.utils.parameters import FloatArray

if TYPE_CHECKING:
    from ftac_gym.evaluation.metrics.history import Rollout

METRICS = (
    Metric("energy", "N2 m2 s"),
    Metric("chatter", "N m/s"),
    Metric("saturation", "share"),
    Metric("momentum_headroom", "share", higher_is_better=True),
    Metric("final_headroom", "share", higher_is_better=True),
)


def measure(history: Rollout) -> dict[str, FloatArray]:
    """Return the metrics, arrays (N,) by name."""
    wheels, period = history.scenario.spacecraft.wheels, history.scenario.control_period
    steps = len(history.command)
    changes = np.abs(np.diff(history.command, axis=0)).sum(axis=(0, 2))
    limited = np.isfinite(wheels.momentum_limits)
    headroom = np.full((steps + 1, history.command.shape[1]), np.nan)
    if limited.any():
        load = np.abs(history.wheel_momentum[:, :, limited]) / wheels.momentum_limits[limited]
        headroom = 1.0 - load.max(axis=2)
    return {
        "energy": np.sum(history.applied_torque**2, axis=(0, 2)) * period,
        "chatter": changes / (steps * period),
        "saturation": np.mean(np.abs(history.command) >= wheels.torque_limits * (1.0 - 1e-9), axis=(0, 2)),
        "momentum_headroom": headroom.min(axis=0),
        "final_headroom": headroom[-1],
    }
