"""Hard-over: the wheel runs at full torque in one direction."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from ftac_gym.faults.fault import WheelFault, limited_wheels, random_signs
from ftac_gym.faults.table import FaultKind
from ftac_gym.utils.parameters import FloatArray, Interval, bounds, draw, interval, require


@dataclass(frozen=True, kw_only=True)
class HardOver(WheelFault):
    """The wheel applies a fraction of its torque limit, whatever is commanded, until its momentum limit stops it.

    Parameters
    ----------
    fraction
        Fraction of the torque limit, in [-1, 1]; 1 is the classical hard-over.
    random_sign
        Whether each draw takes either sign with equal chances.

    Raises
    ------
    ValueError
        If the fraction can leave [-1, 1], or the struck wheel has no torque limit.
    """

    kind: ClassVar[FaultKind] = FaultKind.HARD_OVER

    fraction: Interval = 1.0
    random_sign: bool = True

    def __post_init__(self) -> None:
        """Check and normalise the fields."""
        super().__post_init__()
        object.__setattr__(self, "fraction", interval(self.fraction, "fraction"))
        low, high = bounds(self.fraction)
        require(low >= -1.0 and high <= 1.0, "fraction", "must stay within [-1, 1]", self.fraction)

    def _fill(self, rows: npt.NDArray[np.void], uniform: FloatArray, torque_limit: FloatArray) -> None:
        limited_wheels(torque_limit, "HardOver")
        sign = random_signs(uniform[:, 1]) if self.random_sign else 1.0
        rows["effectiveness"] = 0.0
        rows["bias"] = sign * draw(self.fraction, uniform[:, 0]) * torque_limit
