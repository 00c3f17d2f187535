"""The estimate of the faults by an observer."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
import numpy.typing as npt

from ftac_gym.utils.parameters import FloatArray, require


class WheelCondition(IntEnum):
    """Condition of a wheel by an estimator."""

    HEALTHY = 0
    EFFECTIVENESS = 1
    """A share of the command is missing."""
    BIAS = 2
    """A torque is added to the command."""
    LOCK = 3
    """The torque does not depend on the command."""
    OUTAGE = 4
    """There is no torque."""
    DELAY = 5
    """The command takes effect late."""
    UNKNOWN = 6
    """The wheel is faulty, and the kind of its fault is not identifiable."""


@dataclass(frozen=True, eq=False)
class FaultEstimate:
    """Estimate for N spacecraft with m wheels; None for parts that an observer does not estimate.

    The estimates along a flight of T control periods have arrays with a further first axis, (T, N, ...).

    Attributes
    ----------
    disturbance
        (N, 3) torque on the body beyond that of the commands, in body axes [N m].
    effectiveness
        (N, m) effectiveness of each wheel.
    bias
        (N, m) uncommanded torque of each wheel [N m]; its part in the null space of the wheel axes is not observable.
    identifiable
        (N, m) flags of the wheels whose recent sustained torque suffices to identify their effectiveness; by the
        multiple-model estimator, of those whose condition is not ``UNKNOWN``.
    vibration
        (N, 3) torque of the vibration modes on the body [N m], which the disturbance then excludes.
    alarm
        (N, m) flags of the wheels that the estimator declares faulty, by a decision of its own.
    condition
        (N, m) condition of each wheel, a :class:`WheelCondition` as a whole number.
    delay
        (N, m) delay of each wheel's command [control periods].
    """

    disturbance: FloatArray | None = None
    effectiveness: FloatArray | None = None
    bias: FloatArray | None = None
    identifiable: npt.NDArray[np.bool_] | None = None
    vibration: FloatArray | None = None
    alarm: npt.NDArray[np.bool_] | None = None
    condition: npt.NDArray[np.int64] | None = None
    delay: npt.NDArray[np.int64] | None = None

    def check(self, count: int, wheels: int) -> None:
        """Check that the estimate is that of N spacecraft with m wheels at one time.

        Raises
        ------
        ValueError
            If a part has another shape; the message names it.
        """
        for item in dataclasses.fields(self):
            values = getattr(self, item.name)
            shape = count, 3 if item.name in ("disturbance", "vibration") else wheels
            if values is not None:
                require(
                    np.shape(values) == shape, f"estimate.{item.name}", f"must have shape {shape}", np.shape(values)
                )
