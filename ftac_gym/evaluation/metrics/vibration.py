"""Vibration modes, and the jitter of the pointing.

The window is that of the last ``success.hold`` seconds. Without modes all but the jitter are NaN.

==================== ===================================================================================================
``jitter``           root mean square of the pointing error about its mean over the window
``modal_energy``     integral of the energy of the vibration modes over the episode
``residual_energy``  mean of that energy over the window
``vibration_torque`` root mean square of the modes' torque on the body over the window
==================== ===================================================================================================
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ftac_gym.evaluation.metrics.metric import Metric
from ftac_gym.utils.parameters import FloatArray

if TYPE_CHECKING:
    from ftac_gym.evaluation.metrics.history import Rollout

METRICS = (
    Metric("jitter", "deg"),
    Metric("modal_energy", "J s"),
    Metric("residual_energy", "J"),
    Metric("vibration_torque", "N m"),
)


def measure(history: Rollout) -> dict[str, FloatArray]:
    """Return the metrics, arrays (N,) by name."""
    scenario, window = history.scenario, history.window
    vibration_energy, residual_energy, pull = (np.full(history.attitude_error.shape[1], np.nan) for _ in range(3))
    if scenario.spacecraft.modes:
        energy = history.modal_energy
        vibration_energy = energy[1:].sum(axis=0) * scenario.control_period
        residual_energy = energy[window].mean(axis=0)
        pull = np.sqrt((history.vibration_torque[window] ** 2).sum(axis=2).mean(axis=0))
    return {
        "jitter": np.degrees(np.sqrt((history.relative_error**2).mean(axis=0))),
        "modal_energy": vibration_energy,
        "residual_energy": residual_energy,
        "vibration_torque": pull,
    }
