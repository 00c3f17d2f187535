"""Gyro bias step: the gyros suddenly see a rotation that is not there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from ftac_gym.faults.fault import SensorFault
from ftac_gym.faults.table import FaultKind
from ftac_gym.utils.parameters import FloatArray, Interval, bounds, draw, interval, require, uniform_directions


@dataclass(frozen=True, kw_only=True)
class GyroBiasStep(SensorFault):
    """A constant added to the measured rate, in a direction drawn uniformly.

    Parameters
    ----------
    size
        Magnitude of the step [rad/s].

    Raises
    ------
    ValueError
        If the size can be negative.
    """

    kind: ClassVar[FaultKind] = FaultKind.GYRO_BIAS_STEP

    size: Interval = 1e-4

    def __post_init__(self) -> None:
        """Check and normalise the fields."""
        super().__post_init__()
        object.__setattr__(self, "size", interval(self.size, "size"))
        require(bounds(self.size)[0] >= 0.0, "size", "must not be negative", self.size)

    def _fill(self, rows: npt.NDArray[np.void], uniform: FloatArray) -> None:
        rows["rate_bias"] = draw(self.size, uniform[:, 0])[:, None] * uniform_directions(uniform[:, 1:3])
