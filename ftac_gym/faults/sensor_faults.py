"""Fault kinds of star tracker and gyros."""

import math
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from ftac_gym.faults.fault import SensorFault, magnitude
from ftac_gym.faults.table import FaultKind
from ftac_gym.utils.parameters import FloatArray, Interval, draw, uniform_directions
from ftac_gym.utils.serialization import serializable


@serializable
@dataclass(frozen=True, kw_only=True)
class GyroBiasStep(SensorFault):
    """A constant added to the measured rate, in a direction drawn uniformly.

    Parameters
    ----------
    size
        Magnitude of the step [rad/s], not negative.
    """

    kind: ClassVar[FaultKind] = FaultKind.GYRO_BIAS_STEP
    size: Interval = field(default=1e-4, metadata=magnitude(low=0.0))

    def _fill(self, rows: npt.NDArray[np.void], uniform: FloatArray) -> None:
        rows["rate_bias"] = draw(self.size, uniform[:, 0])[:, None] * uniform_directions(uniform[:, 1:3])


@serializable
@dataclass(frozen=True, kw_only=True)
class StarTrackerOutage(SensorFault):
    """The star tracker delivers nothing; the measured attitude is the last one, carried forward with the gyros."""

    kind: ClassVar[FaultKind] = FaultKind.STAR_TRACKER_OUTAGE
    gradual: ClassVar[bool] = False
    constants: ClassVar = {"outage": 1.0}


@serializable
@dataclass(frozen=True, kw_only=True)
class AttitudeSpike(SensorFault):
    """A wrong match of stars: the measured attitude is turned about an axis drawn uniformly, for a few samples.

    Parameters
    ----------
    angle
        Angle of the turn [rad], in [0, pi].
    duration
        Length of the spike [s]; ``period`` and ``on_time`` make it recur.
    """

    kind: ClassVar[FaultKind] = FaultKind.ATTITUDE_SPIKE
    angle: Interval = field(default=0.02, metadata=magnitude(low=0.0, high=math.pi))

    def _fill(self, rows: npt.NDArray[np.void], uniform: FloatArray) -> None:
        rows["attitude_turn"] = draw(self.angle, uniform[:, 0])[:, None] * uniform_directions(uniform[:, 1:3])
