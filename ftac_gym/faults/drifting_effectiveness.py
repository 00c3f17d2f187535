"""Drifting effectiveness: the wheel loses its grip little by little."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from ftac_gym.faults.fault import WheelFault
from ftac_gym.faults.table import FaultKind
from ftac_gym.utils.parameters import FloatArray, Interval, bounds, draw, interval, positive, require


@dataclass(frozen=True, kw_only=True)
class DriftingEffectiveness(WheelFault):
    """Effectiveness that falls from one to ``effectiveness`` over ``rise`` seconds and stays there.

    Parameters
    ----------
    effectiveness
        Where the drift ends, in [0, 1].
    rise
        How long the drift lasts [s]; above zero.

    Raises
    ------
    ValueError
        If the effectiveness can leave [0, 1] or the rise can be zero.
    """

    kind: ClassVar[FaultKind] = FaultKind.DRIFTING_EFFECTIVENESS

    effectiveness: Interval = 0.2
    rise: Interval = (20.0, 60.0)

    def __post_init__(self) -> None:
        """Check and normalise the fields."""
        super().__post_init__()
        object.__setattr__(self, "effectiveness", interval(self.effectiveness, "effectiveness"))
        low, high = bounds(self.effectiveness)
        require(low >= 0.0 and high <= 1.0, "effectiveness", "must stay within [0, 1]", self.effectiveness)
        positive(bounds(self.rise)[0], "rise")

    def _fill(self, rows: npt.NDArray[np.void], uniform: FloatArray, torque_limit: FloatArray) -> None:
        rows["effectiveness"] = draw(self.effectiveness, uniform[:, 0])
