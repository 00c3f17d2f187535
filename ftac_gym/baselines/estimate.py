"""What an observer believes about the faults."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ftac_gym.utils.parameters import FloatArray


@dataclass(frozen=True, eq=False)
class FaultEstimate:
    """Estimate for N craft with m wheels; None for what an observer does not estimate.

    Attributes
    ----------
    disturbance
        (N, 3) torque on the body that the commands do not explain, in body axes [N m].
    effectiveness
        (N, m) effectiveness of each wheel.
    bias
        (N, m) uncommanded torque of each wheel [N m]; what lies in the null space of the wheel axes cannot be seen.
    identifiable
        (N, m) whether each wheel has been given enough sustained torque of late to tell its effectiveness.
    vibration
        (N, 3) torque of the vibration modes on the body [N m], which is then no part of the disturbance.
    """

    disturbance: FloatArray | None = None
    effectiveness: FloatArray | None = None
    bias: FloatArray | None = None
    identifiable: npt.NDArray[np.bool_] | None = None
    vibration: FloatArray | None = None
