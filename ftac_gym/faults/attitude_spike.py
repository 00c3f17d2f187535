"""Attitude spike: the star tracker mistakes the stars."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from ftac_gym.faults.fault import SensorFault
from ftac_gym.faults.table import FaultKind
from ftac_gym.utils.parameters import FloatArray, Interval, bounds, draw, interval, require, uniform_directions


@dataclass(frozen=True, kw_only=True)
class AttitudeSpike(SensorFault):
    """The measured attitude is turned about an axis drawn uniformly, usually for a few samples only.

    Parameters
    ----------
    angle
        Angle of the turn [rad], in [0, pi].
    duration
        How long the spike lasts [s]; ``period`` and ``on_time`` make it come back.

    Raises
    ------
    ValueError
        If the angle can leave [0, pi].
    """

    kind: ClassVar[FaultKind] = FaultKind.ATTITUDE_SPIKE

    angle: Interval = 0.02

    def __post_init__(self) -> None:
        """Check and normalise the fields."""
        super().__post_init__()
        object.__setattr__(self, "angle", interval(self.angle, "angle"))
        low, high = bounds(self.angle)
        require(low >= 0.0 and high <= np.pi, "angle", "must stay within [0, pi]", self.angle)

    def _fill(self, rows: npt.NDArray[np.void], uniform: FloatArray) -> None:
        rows["attitude_turn"] = draw(self.angle, uniform[:, 0])[:, None] * uniform_directions(uniform[:, 1:3])
