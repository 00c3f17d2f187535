"""Time on target, the first measures of every table.

*On target* means inside the cone and below the rate limit of ``success``. The window is that of the last
``success.hold`` seconds. A sample stands for the control period that it ends.

================== ====================================================================================================
``availability``   share of the control periods on target
``success``        1 if on target for ``success.share`` of the window and never beyond ``success.limit`` cones in it,
                   else 0
``settling_time``  time after which the spacecraft stays on target to the end; the duration if it never does
================== ====================================================================================================
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from ftac_gym.evaluation.metrics.metric import Metric
from ftac_gym.task.scenario import success_steps
from ftac_gym.utils.parameters import FloatArray

if TYPE_CHECKING:
    from ftac_gym.evaluation.metrics.history import Rollout

METRICS = (
    Metric("availability", "share", higher_is_better=True, share=True),
    Metric("success", "share", higher_is_better=True, share=True),
    Metric("settling_time", "s"),
)


def measure(history: Rollout) -> dict[str, FloatArray]:
    """Return the metrics, arrays (N,) by name."""
    scenario = history.scenario
    period, success = scenario.control_period, scenario.success
    on_target, window = history.on_target, history.window
    steps = len(on_target) - 1
    beyond = (history.attitude_error[window] > success.largest_error).sum(axis=0)
    reached = success.reached(success_steps(scenario), steps, on_target[window].sum(axis=0), beyond)
    return {
        "availability": on_target[1:].mean(axis=0),
        "success": reached.astype(np.float64),
        "settling_time": np.minimum(_settled_from(on_target), steps) * period,
    }


def _settled_from(on_target: npt.NDArray[np.bool_]) -> npt.NDArray[np.int64]:
    """Return the first step after which each spacecraft (steps, N) stays on target; the number of steps if none."""
    outside = ~on_target
    last_outside = len(outside) - 1 - np.argmax(outside[::-1], axis=0)
    return np.where(outside.any(axis=0), last_outside + 1, 0)
