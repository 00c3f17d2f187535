"""Outage: the wheel gives no torque and floats."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ftac_gym.faults.fault import Fault
from ftac_gym.faults.table import FaultKind
from ftac_gym.parameters import FloatArray


@dataclass(frozen=True, kw_only=True)
class Outage(Fault):
    """Effectiveness zero, no bias."""

    kind: ClassVar[FaultKind] = FaultKind.OUTAGE

    def _fill(self, rows: np.ndarray, uniform: FloatArray, torque_limit: FloatArray) -> None:
        rows["effectiveness"] = 0.0
