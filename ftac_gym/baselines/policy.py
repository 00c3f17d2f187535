"""A baseline in the clothes of an agent."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ftac_gym.faults import FaultEffect
from ftac_gym.task.measurement import Measurement
from ftac_gym.utils.parameters import FloatArray, require

if TYPE_CHECKING:
    from ftac_gym.baselines.baseline import Baseline


def measurement_of(env: Any, truth: bool = False) -> Measurement:
    """Return the measurement of all craft of an environment.

    Parameters
    ----------
    env
        A Gymnasium environment, a vector environment or an SB3 vector environment of this package, wrapped or not.
    truth
        Whether to add what the faults do, for an oracle.

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
    action: FloatArray = np.clip(command / torque_limits, -1.0, 1.0)
    return action


class BaselinePolicy:
    """Stable-Baselines3's ``predict`` for a baseline.

    The observation is ignored: a baseline reads the measurement behind it, which holds the same knowledge.

    Parameters
    ----------
    baseline
        The baseline; its number of craft must be that of the environment.
    env
        Where the measurements come from.
    """

    def __init__(self, baseline: Baseline, env: Any) -> None:
        self.baseline = baseline
        self.env = env
        self._torque_limits = baseline.scenario.spacecraft.wheels.torque_limits

    def predict(
        self,
        observation: npt.NDArray[Any],
        state: tuple[npt.NDArray[Any], ...] | None = None,
        episode_start: npt.NDArray[Any] | None = None,
        deterministic: bool = False,
    ) -> tuple[FloatArray, None]:
        """Return the action for the present measurement, batched exactly if the observation is.

        Parameters
        ----------
        observation
            (size,) or (N, size); only its number of axes is looked at.
        state
            Ignored: the state is in the baseline.
        episode_start
            (N,) which craft have just been reset, so that the measurement is the first of their episode; None takes
            those whose clock stands at zero. In NEXT_STEP mode that is one call after the one that ended the episode.
        deterministic
            Ignored: a baseline always is.
        """
        measurement = measurement_of(self.env, truth=self.baseline.information == "oracle")
        craft = self.baseline.num_spacecraft
        require(
            len(measurement) == craft, "num_spacecraft", f"must be that of the environment, {len(measurement)}", craft
        )
        started = measurement.time == 0.0 if episode_start is None else np.atleast_1d(episode_start).astype(np.bool_)
        if started.any():
            self.baseline.reset(started)
        action = as_action(self.baseline.act(measurement), self._torque_limits)
        return (action if np.ndim(observation) > 1 else action[0]), None
