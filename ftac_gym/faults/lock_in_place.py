"""Lock in place: the wheel keeps the torque it had when the fault struck."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from ftac_gym.faults.fault import WheelFault
from ftac_gym.faults.table import FaultKind
from ftac_gym.utils.parameters import FloatArray


@dataclass(frozen=True, kw_only=True)
class LockInPlace(WheelFault):
    """The torque at the onset is held, whatever is commanded, until the wheel's momentum limit stops it."""

    kind: ClassVar[FaultKind] = FaultKind.LOCK_IN_PLACE
    gradual: ClassVar[bool] = False

    def _fill(self, rows: npt.NDArray[np.void], uniform: FloatArray, torque_limit: FloatArray) -> None:
        rows["effectiveness"] = 0.0
        rows["locked"] = 1.0
