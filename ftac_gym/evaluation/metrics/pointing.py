"""Pointing error over the episode, and the scenario's prescribed bound.

===================== ==================================================================================================
``final_error``       root mean square of the pointing error over the window of the last ``success.hold`` seconds
``integrated_error``  integral of the pointing error over the episode
``path_ratio``        integral of the rate error over the initial angle: 1 is the shortest way
``bound_kept``        1 if the error stayed within the scenario's prescribed bound, else 0; NaN without a bound
``bound_margin``      least distance to a bound over the width between both; negative outside; NaN without a bound
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
    Metric("final_error", "deg"),
    Metric("integrated_error", "deg s"),
    Metric("path_ratio", "-"),
    Metric("bound_kept", "share", higher_is_better=True, share=True),
    Metric("bound_margin", "-", higher_is_better=True),
)


def measure(history: Rollout) -> dict[str, FloatArray]:
    """Return the metrics, arrays (N,) by name."""
    scenario, error = history.scenario, history.attitude_error
    period = scenario.control_period
    margin = np.full(error.shape[1], np.nan)
    if scenario.prescribed_bound is not None:
        inside = scenario.prescribed_bound.margin(history.error_mrp, history.time[:, None])
        margin = inside.min(axis=(0, 2))
    return {
        "final_error": np.sqrt(np.mean(np.degrees(error[history.window]) ** 2, axis=0)),
        "integrated_error": np.degrees(error[1:].sum(axis=0)) * period,
        "path_ratio": history.rate_error[1:].sum(axis=0) * period / np.maximum(error[0], 1e-3),
        "bound_kept": np.where(np.isnan(margin), np.nan, margin > 0.0),
        "bound_margin": margin,
    }
