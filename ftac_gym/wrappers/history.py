"""Observations of the past beside the present one."""

from typing import Any

import numpy as np
from gymnasium import spaces

from ftac_gym.task.measurement import Measurement
from ftac_gym.utils.parameters import require, whole
from ftac_gym.wrappers.transform import BoolArray, Observation, Transform, wrapper

LONGEST_HISTORY = 10_000
"""Limit of the control periods that a history covers."""


def check_length(steps: int, stride: int) -> tuple[int, int]:
    """Return the numbers of a history; raise a ValueError if one is not a positive integer or the history too long."""
    steps, stride = whole(steps, 1, "steps"), whole(stride, 1, "stride")
    rule = f"times stride must not exceed {LONGEST_HISTORY}"
    require(steps * stride <= LONGEST_HISTORY, "steps", rule, (steps, stride))
    return steps, stride


class History(Transform):
    """Show the observation and the ones before it, the newest first.

    At the start of an episode its first observation stands for the past.

    Parameters
    ----------
    env
        An environment of this package, single or vector.
    steps
        Number of observations that are shown; one is the present one alone.
    stride
        Control periods between them.

    Raises
    ------
    ValueError
        If the environment is not of this package, a number is not a positive integer, or their product exceeds
        :data:`LONGEST_HISTORY`.
    """

    def __init__(self, env: Any, steps: int = 4, stride: int = 1) -> None:
        super().__init__(env)
        steps, stride = check_length(steps, stride)
        space = self.observation_space
        self._ages = stride * np.arange(steps)
        # A ring that turns once per control period for all spacecraft.
        self._ring = np.zeros((int(self._ages[-1]) + 1, self.num_spacecraft, space.shape[0]), dtype=np.float32)
        self._newest = 0
        low, high = (np.tile(bound, steps).astype(np.float32) for bound in (space.low, space.high))
        self.observation_space = spaces.Box(low, high, dtype=np.float32)

    def observe(self, observation: Observation, mask: BoolArray) -> Observation:
        """Add an observation (N, size) for the spacecraft in the mask (N,), and return the history."""
        if mask.all():
            self._newest = (self._newest + 1) % len(self._ring)
            self._ring[self._newest] = observation

        def reset(started: BoolArray) -> None:
            self._ring[:, started] = observation[started]

        self.measure(mask, reset)
        return self._joined(self._ring[self._newest], self._newest)

    def preview(self, observation: Observation, measurement: Measurement) -> Observation:
        """Return the history with this observation (N, size) added."""
        return self._joined(observation, self._newest + 1)

    def _joined(self, latest: Observation, place: int) -> Observation:
        """Return the latest observation, at a place in the ring, and those before it."""
        earlier = [self._ring[(place - age) % len(self._ring)] for age in self._ages[1:]]
        return np.concatenate([latest, *earlier], axis=1)


ObservationHistory = wrapper("ObservationHistory", History)
