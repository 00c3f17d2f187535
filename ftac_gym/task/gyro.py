"""Gyros as data sheets describe them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ftac_gym.task.sensors import LARGEST_MISALIGNMENT
from ftac_gym.utils.parameters import (
    FloatArray,
    Interval,
    draw,
    interval,
    largest,
    non_negative_interval,
    normalise,
    positive,
    require,
    uniform_directions,
)
from ftac_gym.utils.serialization import serializable

DEGREE = math.pi / 180.0
DEGREE_PER_HOUR = DEGREE / 3600.0
"""One degree per hour [rad/s]."""

DEGREE_PER_ROOT_HOUR = DEGREE / 60.0
"""One degree per square root of an hour [rad per square root of second]."""

DEGREE_PER_HOUR_PER_ROOT_HOUR = DEGREE_PER_HOUR / 60.0
"""One degree per hour per square root of an hour [rad/s per square root of second]."""

PART_PER_MILLION = 1e-6

LARGEST_SCALE_FACTOR = 1e5
"""Largest error of a gyro's scale factor [ppm]."""


@serializable
@dataclass(frozen=True, kw_only=True)
class Gyro:
    """Triad of gyros whose rate has white noise, three kinds of bias, and errors of scale and alignment.

    A sample of the rate w is (1 + scale factor) (w + misalignment x w) + bias + noise on each axis. The noise has the
    standard deviation ``angle_random_walk`` over the square root of the control period. The drift of an angle that is
    integrated from the samples thus does not depend on that period. The bias is the sum of a constant, of a random
    walk, and of a first-order Gauss-Markov process that starts stationary.

    Parameters
    ----------
    angle_random_walk
        White noise of the rate, N [deg per square root of hour]. Its Allan deviation over a time tau is N / sqrt(tau).
    rate_random_walk
        Random walk of the bias, K [deg/h per square root of hour], with the Allan deviation K sqrt(tau / 3). Each axis
        walks every third control period, by as much as three periods make.
    bias
        Bias of each gyro at the start [deg/h].
    bias_instability
        Standard deviation of the Gauss-Markov process [deg/h]. Its Allan deviation has a maximum of 0.618 times this,
        at 1.89 correlation times. That of flicker noise, which data sheets mean, is 0.664 times its coefficient.
    correlation_time
        Correlation time of the Gauss-Markov process [s].
    scale_factor
        Relative error of the scale factor of each gyro [ppm], within 100 000 of zero.
    misalignment
        Angle of the triad against the body, about an axis drawn uniformly [deg]. It is at most 0.1 rad, 5.7 deg,
        because the rate is turned to first order.

    Raises
    ------
    ValueError
        If a value is negative that must not be, or too large.
    """

    angle_random_walk: Interval = 0.0
    rate_random_walk: Interval = 0.0
    bias: Interval = 0.0
    bias_instability: Interval = 0.0
    correlation_time: float = 3600.0
    scale_factor: Interval = 0.0
    misalignment: Interval = 0.0

    def __post_init__(self) -> None:
        """Check and normalise the fields."""
        normalise(self, non_negative_interval, "angle_random_walk", "rate_random_walk", "bias_instability")
        normalise(self, interval, "bias")
        normalise(self, positive, "correlation_time")
        scale, angle = LARGEST_SCALE_FACTOR, LARGEST_MISALIGNMENT / DEGREE
        normalise(self, lambda value, name: interval(value, name, -scale, scale), "scale_factor")
        normalise(self, lambda value, name: interval(value, name, 0.0, angle), "misalignment")

    def _fill(self, table: npt.NDArray[np.void], uniform: FloatArray) -> None:
        table["angle_random_walk"] = DEGREE_PER_ROOT_HOUR * draw(self.angle_random_walk, uniform[:, 0])
        table["rate_random_walk"] = DEGREE_PER_HOUR_PER_ROOT_HOUR * draw(self.rate_random_walk, uniform[:, 1])
        table["bias_instability"] = DEGREE_PER_HOUR * draw(self.bias_instability, uniform[:, 2])
        table["correlation_time"] = self.correlation_time
        table["gyro_bias"] = DEGREE_PER_HOUR * draw(self.bias, uniform[:, 3:6])
        table["scale_factor"] = PART_PER_MILLION * draw(self.scale_factor, uniform[:, 6:9])
        angle = DEGREE * draw(self.misalignment, uniform[:, 9])
        table["gyro_misalignment"] = angle[:, None] * uniform_directions(uniform[:, 10:12])

    def check(self, control_period: float, duration: float, fastest: float) -> None:
        """Check that no error reaches the fastest rate that the plant integrates [rad/s].

        Raises
        ------
        ValueError
            If one does; the message names the field.
        """
        errors = {
            "angle_random_walk": DEGREE_PER_ROOT_HOUR / math.sqrt(control_period),
            "rate_random_walk": DEGREE_PER_HOUR_PER_ROOT_HOUR * math.sqrt(duration),
            "bias": DEGREE_PER_HOUR,
            "bias_instability": DEGREE_PER_HOUR,
        }
        for name, unit in errors.items():
            value = getattr(self, name)
            rule = f"must be at most {fastest / unit:.4g}: a rate error then reaches {fastest:.4g} rad/s"
            require(unit * largest(value) <= fastest, name, rule, value)
