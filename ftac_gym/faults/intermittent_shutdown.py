"""Intermittent shut-down: the wheel switches itself off and is restarted, again and again."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from ftac_gym.faults.fault import WheelFault
from ftac_gym.faults.table import FaultKind
from ftac_gym.utils.parameters import FloatArray, require


@dataclass(frozen=True, kw_only=True)
class IntermittentShutdown(WheelFault):
    """No motor torque while shut down; the times of shut-down and restart are a two-state Markov chain.

    Parameters
    ----------
    mean_acting
        Mean time from shut-down to restart [s].
    mean_resting
        Mean time from restart to the next shut-down [s].

    Raises
    ------
    ValueError
        If the chain is left out.
    """

    kind: ClassVar[FaultKind] = FaultKind.INTERMITTENT_SHUTDOWN

    mean_acting: float | None = 5.0
    mean_resting: float | None = 15.0

    def __post_init__(self) -> None:
        """Check and normalise the fields."""
        super().__post_init__()
        require(self.random_chain, "mean_acting", "must be given: without it the fault is an Outage", self.mean_acting)

    def _fill(self, rows: npt.NDArray[np.void], uniform: FloatArray, torque_limit: FloatArray) -> None:
        rows["effectiveness"] = 0.0
