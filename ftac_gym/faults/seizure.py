"""Seizure: the bearing stops the wheel within seconds and does not let go."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from ftac_gym.faults.fault import WheelFault, limited_wheels
from ftac_gym.faults.table import FaultKind
from ftac_gym.utils.parameters import FloatArray, Interval, bounds, draw, interval, require


@dataclass(frozen=True, kw_only=True)
class Seizure(WheelFault):
    """Dry friction beyond what the motor can overcome: the momentum of the wheel goes into the body.

    The brake torque b stops a wheel of momentum h in h / b seconds, a little later or earlier if the motor pulls, and
    holds it at rest from then on, whatever is commanded.

    Parameters
    ----------
    brake
        Brake torque over the torque limit; above 1.

    Raises
    ------
    ValueError
        If the brake can be no stronger than the motor, or the struck wheel has no torque limit.
    """

    kind: ClassVar[FaultKind] = FaultKind.SEIZURE
    gradual: ClassVar[bool] = False

    brake: Interval = (1.5, 4.0)

    def __post_init__(self) -> None:
        """Check and normalise the fields."""
        super().__post_init__()
        object.__setattr__(self, "brake", interval(self.brake, "brake"))
        require(bounds(self.brake)[0] > 1.0, "brake", "must exceed 1: the motor must not overcome it", self.brake)

    def _fill(self, rows: npt.NDArray[np.void], uniform: FloatArray, torque_limit: FloatArray) -> None:
        limited_wheels(torque_limit, "Seizure")
        rows["brake"] = draw(self.brake, uniform[:, 0]) * torque_limit
