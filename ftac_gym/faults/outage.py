"""Outage: the wheel gives no torque and floats."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from ftac_gym.faults.fault import WheelFault
from ftac_gym.faults.table import FaultKind
from ftac_gym.utils.parameters import FloatArray


@dataclass(frozen=True, kw_only=True)
class Outage(WheelFault):
    """Effectiveness zero, no bias."""

    kind: ClassVar[FaultKind] = FaultKind.OUTAGE

    def _fill(self, rows: npt.NDArray[np.void], uniform: FloatArray, torque_limit: FloatArray) -> None:
        rows["effectiveness"] = 0.0
