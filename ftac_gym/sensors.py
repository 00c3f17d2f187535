"""Errors of the star tracker and of the gyros."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ftac_gym.parameters import FloatArray, Interval, draw, interval, non_negative

SENSOR = np.dtype([("attitude_noise", "f8"), ("rate_noise", "f8"), ("gyro_bias", "f8", (3,)), ("gyro_bias_walk", "f8")])
"""Per craft: noise [rad], noise [rad/s], initial bias [rad/s], random walk [rad/s per square root of second]."""


@dataclass(frozen=True)
class SensorErrors:
    """White noise on attitude and rate, and a gyro bias that walks.

    Parameters
    ----------
    attitude_noise
        Standard deviation of the measured attitude about each body axis [rad].
    rate_noise
        Standard deviation of a rate sample on each axis [rad/s].
    gyro_bias
        Bias of each gyro at the start [rad/s].
    gyro_bias_walk
        Intensity of the random walk of the bias [rad/s per square root of second].
    """

    attitude_noise: float = 0.0
    rate_noise: float = 0.0
    gyro_bias: Interval = 0.0
    gyro_bias_walk: float = 0.0

    def __post_init__(self) -> None:
        """Check and normalise the fields."""
        for name in ("attitude_noise", "rate_noise", "gyro_bias_walk"):
            object.__setattr__(self, name, non_negative(getattr(self, name), name))
        object.__setattr__(self, "gyro_bias", interval(self.gyro_bias, "gyro_bias"))

    @property
    def uniform_count(self) -> int:
        """How many uniform deviates one episode needs."""
        return 3

    def draw(self, uniform: FloatArray) -> npt.NDArray[np.void]:
        """Draw the sensor parameters of N craft from uniform deviates (N, 3); returns SENSOR records (N,)."""
        table = np.zeros(len(uniform), SENSOR)
        table["attitude_noise"] = self.attitude_noise
        table["rate_noise"] = self.rate_noise
        table["gyro_bias"] = draw(self.gyro_bias, uniform)
        table["gyro_bias_walk"] = self.gyro_bias_walk
        return table
