"""Friction rise: the bearing runs dry."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from ftac_gym.faults.fault import WheelFault
from ftac_gym.faults.table import FaultKind
from ftac_gym.utils.parameters import FloatArray, Interval, bounds, draw, interval, require

DIRECTIONS = ("both", "forward", "backward", "either")


@dataclass(frozen=True, kw_only=True)
class FrictionRise(WheelFault):
    """The dry friction of the wheel grows by a factor, as on FUSE and Kepler before their wheels stopped.

    Only for wheels that have friction.

    Parameters
    ----------
    factor
        Factor on the Coulomb and the breakaway torque, at least 1.
    direction
        Sense of rotation in which it grows: ``"both"``, ``"forward"`` (positive momentum), ``"backward"``, or
        ``"either"``, which draws one of the two.
    rise
        How long the growth takes [s].

    Raises
    ------
    ValueError
        If the factor can be below 1 or the direction is unknown.
    """

    kind: ClassVar[FaultKind] = FaultKind.FRICTION_RISE

    factor: Interval = (2.0, 20.0)
    direction: str = "both"
    rise: Interval = (20.0, 60.0)

    def __post_init__(self) -> None:
        """Check and normalise the fields."""
        super().__post_init__()
        object.__setattr__(self, "factor", interval(self.factor, "factor"))
        require(bounds(self.factor)[0] >= 1.0, "factor", "must not be below 1", self.factor)
        require(self.direction in DIRECTIONS, "direction", f"must be one of {list(DIRECTIONS)}", self.direction)

    def _fill(self, rows: npt.NDArray[np.void], uniform: FloatArray, torque_limit: FloatArray) -> None:
        factor = draw(self.factor, uniform[:, 0])
        forward = self.direction in ("both", "forward") or (self.direction == "either") & (uniform[:, 1] < 0.5)
        backward = self.direction in ("both", "backward") or (self.direction == "either") & (uniform[:, 1] >= 0.5)
        rows["friction_forward"] = np.where(forward, factor, 1.0)
        rows["friction_backward"] = np.where(backward, factor, 1.0)
