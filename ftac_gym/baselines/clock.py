"""Check of the time between two calls of what runs once per control period."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from ftac_gym.baselines.estimators.navigator import Navigated
from ftac_gym.task.measurement import Measurement
from ftac_gym.utils.parameters import FloatArray

if TYPE_CHECKING:
    from ftac_gym.baselines.baseline import Baseline

Act = Callable[[Any, Measurement], FloatArray]

TOLERANCE = 1e-6
"""Of the time between two calls, as a share of the control period."""


def check_elapsed(name: str, time: FloatArray, last: FloatArray, period: float) -> None:
    """Refuse measurements that are neither those of the last call nor those of one control period later.

    Parameters
    ----------
    name
        Name of what runs once per control period.
    time, last
        (N,) times of the measurements and of the last call [s]; NaN before the first call of an episode.
    period
        Control period [s].

    Raises
    ------
    ValueError
        If the time since the last call is neither zero nor the control period, for any spacecraft.
    """
    elapsed = time - last
    # The product is zero for both times that are right.
    wrong = np.abs(elapsed * (elapsed - period)) > TOLERANCE * period**2
    if wrong.any():
        spacecraft = int(np.argmax(wrong))
        raise ValueError(
            f"time since the last call of {name} must be its control period, {period:g} s: nothing may hold or skip "
            "steps between its calls (ActionHold, hold of SB3VecEnv, frame skips), and a new episode starts with a "
            f"reset, got {elapsed[spacecraft]:g} s for spacecraft {spacecraft}"
        )


def timed(act: Act) -> Act:
    """Return the ``act`` of a baseline that checks the measurement first, and stores time and command."""

    @functools.wraps(act)
    def checked(self: Baseline, measurement: Measurement) -> FloatArray:
        if isinstance(measurement, Navigated):
            # The call of a subclass: the measurement has been checked and has passed the estimators.
            return act(self, measurement)
        memory, time = self.memory, measurement.time
        if time.shape != (self.num_spacecraft,):
            raise ValueError(f"measurement must be of {self.num_spacecraft} spacecraft, got {len(measurement)}")
        check_elapsed(type(self).__name__, time, memory["called_at"], self.scenario.control_period)
        command = act(self, self._navigated(measurement))
        memory["called_at"], memory["command"] = time, command
        return command

    return checked
