"""Lock in place: the wheel keeps the torque it had when the fault struck."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ftac_gym.faults.fault import Fault
from ftac_gym.faults.table import FaultKind
from ftac_gym.parameters import FloatArray


@dataclass(frozen=True, kw_only=True)
class LockInPlace(Fault):
    """The torque at the onset is held, whatever is commanded, until the wheel's momentum limit stops it."""

    kind: ClassVar[FaultKind] = FaultKind.LOCK_IN_PLACE

    def _fill(self, rows: np.ndarray, uniform: FloatArray, torque_limit: FloatArray) -> None:
        rows["effectiveness"] = 0.0
        rows["locked"] = 1.0
