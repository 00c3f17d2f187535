"""A fault of each kind, strong enough to be seen."""

from __future__ import annotations

from collections.abc import Mapping
from math import radians
from types import MappingProxyType
from typing import Any

from ftac_gym.faults.table import FaultKind

EXAMPLES: Mapping[int, Mapping[str, Any]] = MappingProxyType(
    {
        FaultKind.LOSS_OF_EFFECTIVENESS: {"effectiveness": 0.1},
        FaultKind.DRIFTING_EFFECTIVENESS: {"effectiveness": 0.0, "rise": 30.0},
        FaultKind.BIAS: {"amplitude": 0.08, "frequency": 0.3},
        FaultKind.OUTAGE: {},
        FaultKind.LOCK_IN_PLACE: {},
        FaultKind.HARD_OVER: {"fraction": 0.5, "random_sign": False},
        FaultKind.FRICTION_RISE: {"factor": 100.0, "rise": 30.0},
        FaultKind.SEIZURE: {"brake": 2.0},
        FaultKind.INTERMITTENT_SHUTDOWN: {},
        FaultKind.COMMAND_DELAY: {"periods": 3.0},
        FaultKind.GYRO_BIAS_STEP: {"size": radians(0.05)},
        FaultKind.STAR_TRACKER_OUTAGE: {"duration": 60.0},
        FaultKind.ATTITUDE_SPIKE: {"angle": radians(2.0), "period": 15.0, "on_time": 0.3},
    }
)
"""Fields of the example of each kind, besides wheel and onset; for wheels like the flagship's."""
