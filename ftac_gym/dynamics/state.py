"""The true state of many craft."""

from __future__ import annotations

from dataclasses import dataclass

from ftac_gym.utils.parameters import FloatArray


@dataclass(frozen=True, eq=False)
class State:
    """True state of N craft with m wheels; the arrays are the simulator's own and change with every step.

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
        (N, m) torque of each motor behind its lag, before faults and friction [N m]; for an ideal wheel, which has no
        such state, of no meaning.
    modal_displacement, modal_rate
        (N, k) displacement [kg^1/2 m] and rate [kg^1/2 m/s] of each vibration mode; k = 0 for rigid craft.
    """

    attitude: FloatArray
    rate: FloatArray
    wheel_momentum: FloatArray
    wheel_torque: FloatArray
    motor_torque: FloatArray
    modal_displacement: FloatArray
    modal_rate: FloatArray
