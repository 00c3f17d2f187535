"""True state of N spacecraft."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ftac_gym.utils.parameters import FloatArray


@dataclass(frozen=True, eq=False)
class State:
    """True state of N spacecraft with m wheels; the arrays are the simulator's own and change with every step.

    Attributes
    ----------
    attitude
        (N, 4) quaternion, body relative to inertial, scalar first.
    rate
        (N, 3) body rate in body axes [rad/s].
    wheel_momentum
        (N, m) [N m s].
    wheel_torque
        (N, m) torque of each wheel on the body at the end of the last physics step [N m].
    motor_torque
        (N, m) torque of each motor behind its lag, before faults and friction [N m]; without meaning for an ideal
        wheel, which has no such state.
    modal_displacement, modal_rate
        (N, k) displacement [kg^1/2 m] and rate [kg^1/2 m/s] of each vibration mode; k = 0 for rigid spacecraft.
    """

    attitude: FloatArray
    rate: FloatArray
    wheel_momentum: FloatArray
    wheel_torque: FloatArray
    motor_torque: FloatArray
    modal_displacement: FloatArray
    modal_rate: FloatArray

    @classmethod
    def at_rest(cls, count: int, wheels: int, modes: int) -> State:
        """Return the state of so many spacecraft at rest, aligned with the inertial axes."""
        widths = (3, wheels, wheels, wheels, modes, modes)
        return cls(identity_quaternions(count), *(np.zeros((count, width)) for width in widths))


def identity_quaternions(count: int) -> FloatArray:
    """Return quaternions (count, 4) of no rotation."""
    return np.tile([1.0, 0.0, 0.0, 0.0], (count, 1))
