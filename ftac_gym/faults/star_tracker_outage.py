"""Star-tracker outage: no stars, only gyros."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from ftac_gym.faults.fault import SensorFault
from ftac_gym.faults.table import FaultKind
from ftac_gym.utils.parameters import FloatArray


@dataclass(frozen=True, kw_only=True)
class StarTrackerOutage(SensorFault):
    """The star tracker delivers nothing; the measured attitude is the last one, carried forward with the gyros."""

    kind: ClassVar[FaultKind] = FaultKind.STAR_TRACKER_OUTAGE
    gradual: ClassVar[bool] = False

    def _fill(self, rows: npt.NDArray[np.void], uniform: FloatArray) -> None:
        rows["outage"] = 1.0
