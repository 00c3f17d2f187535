"""Command delay: the wheel obeys late."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from ftac_gym.faults.fault import WheelFault
from ftac_gym.faults.table import FaultKind
from ftac_gym.utils.parameters import FloatArray, Interval, bounds, draw, interval, require

LONGEST_DELAY = 5
"""Control periods that the plant remembers commands for."""


@dataclass(frozen=True, kw_only=True)
class CommandDelay(WheelFault):
    """The wheel receives every command a whole number of control periods late.

    Parameters
    ----------
    periods
        The delay in control periods: a whole number from 1 to 5, or a pair of them, both included in the draw.

    Raises
    ------
    ValueError
        If the delay is no whole number within the bounds.
    """

    kind: ClassVar[FaultKind] = FaultKind.COMMAND_DELAY
    gradual: ClassVar[bool] = False

    periods: Interval = (1.0, 5.0)

    def __post_init__(self) -> None:
        """Check and normalise the fields."""
        super().__post_init__()
        object.__setattr__(self, "periods", interval(self.periods, "periods"))
        low, high = bounds(self.periods)
        whole = low.is_integer() and high.is_integer() and low >= 1.0 and high <= LONGEST_DELAY
        require(whole, "periods", f"must be whole numbers from 1 to {LONGEST_DELAY}", self.periods)

    def _fill(self, rows: npt.NDArray[np.void], uniform: FloatArray, torque_limit: FloatArray) -> None:
        low, high = bounds(self.periods)
        # The minimum is for the deviate just below one, from which rounding would make a delay too long to remember.
        rows["delay"] = np.minimum(np.floor(draw((low, high + 1.0), uniform[:, 0])), high)
