"""Input of on-board software, the same for every policy."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import numpy.typing as npt

from ftac_gym.faults import FaultEffect
from ftac_gym.utils.parameters import FloatArray


@dataclass(frozen=True, eq=False)
class Measurement:
    """Measured state and commanded attitude of N spacecraft with m wheels, float64.

    Attributes
    ----------
    time
        (N,) time since the start of the episode [s].
    attitude
        (N, 4) measured quaternion, body relative to inertial, scalar first: the latest available sample of the star
        tracker, carried forward to now with the gyros.
    rate
        (N, 3) measured body rate in body axes [rad/s].
    wheel_momentum
        (N, m) wheel momenta as measured by the tachometers [N m s]; only the telemetry tier may use it.
    last_command
        (N, m) wheel torques commanded last, at the start of the period that has just ended, within the limits [N m];
        zero at the start.
    star_tracker_valid
        (N,) whether the star tracker works, not whether a sample is new; only the telemetry tier may use it.
    reference_attitude
        (N, 4) commanded quaternion.
    reference_rate
        (N, 3) rate of the reference, in the reference frame's axes [rad/s].
    reference_acceleration
        (N, 3) its derivative, in the same axes [rad/s^2].
    modal_displacement, modal_rate
        (N, k) displacement [kg^1/2 m] and rate [kg^1/2 m/s] of the vibration modes, from strain gauges; only the
        telemetry tier may use them. None or k = 0 for rigid spacecraft.
    command_in_effect
        (N, m) mean command that was in effect over that period, by the nominal loop delay, within the limits [N m]:
        the one that explains the motion. None stands for ``last_command``, which it is without a loop delay.
    attitude_age
        (N,) time since the sample of the star tracker was taken that ``attitude`` is from [s]: latency, and the time up
        to the next sample. With :class:`~ftac_gym.task.sensors.SensorErrors` it is zero unless the star tracker is out.
        None stands for zeros.
    truth
        Effect of the faults at this moment, which a spacecraft cannot measure. It is None except for an oracle, which
        has the word in its name.
    """

    time: FloatArray
    attitude: FloatArray
    rate: FloatArray
    wheel_momentum: FloatArray
    last_command: FloatArray
    star_tracker_valid: npt.NDArray[np.bool_]
    reference_attitude: FloatArray
    reference_rate: FloatArray
    reference_acceleration: FloatArray
    truth: FaultEffect | None = None
    modal_displacement: FloatArray | None = None
    modal_rate: FloatArray | None = None
    command_in_effect: FloatArray = None  # type: ignore[assignment]  # Never None once it is made.
    attitude_age: FloatArray = None  # type: ignore[assignment]  # Neither is this.

    def __post_init__(self) -> None:
        """Take the last command for that in effect, and an attitude without age, where there is no other."""
        if self.command_in_effect is None:
            object.__setattr__(self, "command_in_effect", self.last_command)
        if self.attitude_age is None:
            object.__setattr__(self, "attitude_age", np.zeros(len(self.time)))

    def take(self, rows: npt.NDArray[np.intp]) -> Measurement:
        """Return the measurement of some spacecraft, by their numbers (n,)."""
        given = {item.name: getattr(self, item.name) for item in fields(self) if item.name != "truth"}
        arrays: dict[str, Any] = {name: None if array is None else array[rows] for name, array in given.items()}
        truth = None if self.truth is None else FaultEffect._make(array[rows] for array in self.truth)
        return Measurement(**arrays, truth=truth)

    def __len__(self) -> int:
        """Return the number of spacecraft N."""
        return len(self.time)
