"""Errors of the star tracker and of the gyros."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ftac_gym.utils.parameters import FloatArray, Interval, draw, interval, non_negative, normalise, uniform_directions
from ftac_gym.utils.serialization import serializable

SENSOR = np.dtype(
    [
        ("attitude_noise", "f8"),
        ("rate_noise", "f8"),
        ("gyro_bias", "f8", (3,)),
        ("gyro_bias_walk", "f8"),
        ("gyro_misalignment", "f8", (3,)),
    ]
)
"""Per spacecraft: noise [rad], noise [rad/s], initial bias [rad/s] and random walk [rad/s per square root of second].

The last field is the rotation vector [rad] by which the measured rate is turned in body axes.
"""

LARGEST_MISALIGNMENT = 0.1
"""Largest angle of a gyro triad against the body [rad]."""


@serializable
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
    gyro_misalignment
        Angle of the gyro triad against the body, about an axis drawn uniformly [rad]. It is at most 0.1, because the
        rate is turned to first order.

    Raises
    ------
    ValueError
        If a value is negative or the misalignment is not small.
    """

    attitude_noise: float = 0.0
    rate_noise: float = 0.0
    gyro_bias: Interval = 0.0
    gyro_bias_walk: float = 0.0
    gyro_misalignment: Interval = 0.0

    def __post_init__(self) -> None:
        """Check and normalise the fields."""
        normalise(self, non_negative, "attitude_noise", "rate_noise", "gyro_bias_walk")
        normalise(self, interval, "gyro_bias")
        normalise(self, lambda value, name: interval(value, name, 0.0, LARGEST_MISALIGNMENT), "gyro_misalignment")

    @property
    def uniform_count(self) -> int:
        """Number of uniform deviates that one episode needs."""
        return 6

    def draw(self, uniform: FloatArray) -> npt.NDArray[np.void]:
        """Draw the sensor parameters of N spacecraft from uniform deviates (N, 6); returns SENSOR records (N,)."""
        table = np.zeros(len(uniform), SENSOR)
        table["attitude_noise"] = self.attitude_noise
        table["rate_noise"] = self.rate_noise
        table["gyro_bias"] = draw(self.gyro_bias, uniform[:, 0:3])
        table["gyro_bias_walk"] = self.gyro_bias_walk
        angle = draw(self.gyro_misalignment, uniform[:, 3])
        table["gyro_misalignment"] = angle[:, None] * uniform_directions(uniform[:, 4:6])
        return table
