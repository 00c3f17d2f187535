"""Compiled prediction of attitude and rate over the loop delay."""

from __future__ import annotations

from typing import Any

import numpy as np

from ftac_gym.baselines.estimators import attitude_kernel
from ftac_gym.baselines.estimators.attitude_kernel import symmetric_inverse
from ftac_gym.utils import algebra
from ftac_gym.utils.algebra import cross3, quaternion_product, rotation, rotation_change, unit
from ftac_gym.utils.compiling import entry_point


@entry_point(algebra, attitude_kernel)
def predict(
    attitude: Any,
    rate: Any,
    inertia: Any,
    momentum: Any,
    torque: Any,
    commands: Any,
    response: Any,
    level: Any,
    late: Any,
    axes: Any,
    first: float,
    period: float,
    whole: int,
) -> None:
    """Carry attitude, rate and momentum of N spacecraft over the loop delay, in place.

    Over each span the body has the acceleration J^-1 (D u + d - w x H) of its middle, with the momentum H of body and
    wheels constant in inertial axes.

    Parameters
    ----------
    attitude
        (N, 4) quaternions.
    rate
        (N, 3) rates [rad/s].
    inertia
        (N, 3, 3) inertia [kg m^2].
    momentum
        (N, 3) total angular momentum in body axes [N m s].
    torque
        (N, 3) torque d beyond that of the wheels, in body axes [N m].
    commands
        (N, Q, m) commands given up to now, the last one last [N m].
    response, level
        (N, m) torque of each wheel over its command, and besides it [N m].
    late
        (N,) delay of the loop beyond the nominal one [control periods].
    axes
        (m, 3) wheel axes.
    first
        Time that the oldest command on its way is still in effect [s]; zero where the delay is of whole periods.
    period
        Control period [s].
    whole
        Whole control periods of the nominal delay.
    """
    inverse = np.zeros((3, 3))
    for i in range(len(attitude)):
        symmetric_inverse(inertia[i], inverse)
        q = (attitude[i, 0], attitude[i, 1], attitude[i, 2], attitude[i, 3])
        w = (rate[i, 0], rate[i, 1], rate[i, 2])
        stored = (momentum[i, 0], momentum[i, 1], momentum[i, 2])
        split = 1 if first > 0.0 else 0
        spans = split + whole + late[i]
        for p in range(spans):
            span = first if p < split else period
            oldest = commands.shape[1] - spans
            x, y, z = torque[i, 0], torque[i, 1], torque[i, 2]
            for j in range(axes.shape[0]):
                given = response[i, j] * commands[i, oldest + p, j] + level[i, j]
                x, y, z = x + given * axes[j, 0], y + given * axes[j, 1], z + given * axes[j, 2]
            middle = w
            for _ in range(2):
                # The momentum turns against the body.
                half = rotation((0.5 * span * middle[0], 0.5 * span * middle[1], 0.5 * span * middle[2]))
                change = rotation_change(half[0], (half[1], half[2], half[3]), stored)
                turned = cross3(middle, (stored[0] + change[0], stored[1] + change[1], stored[2] + change[2]))
                a, b, c = x - turned[0], y - turned[1], z - turned[2]
                gain = (
                    span * (inverse[0, 0] * a + inverse[0, 1] * b + inverse[0, 2] * c),
                    span * (inverse[1, 0] * a + inverse[1, 1] * b + inverse[1, 2] * c),
                    span * (inverse[2, 0] * a + inverse[2, 1] * b + inverse[2, 2] * c),
                )
                middle = (w[0] + 0.5 * gain[0], w[1] + 0.5 * gain[1], w[2] + 0.5 * gain[2])
            turn = rotation((span * middle[0], span * middle[1], span * middle[2]))
            change = rotation_change(turn[0], (turn[1], turn[2], turn[3]), stored)
            stored = (stored[0] + change[0], stored[1] + change[1], stored[2] + change[2])
            q = quaternion_product(q, turn)
            w = (w[0] + gain[0], w[1] + gain[1], w[2] + gain[2])
        q = unit(q)
        momentum[i, 0], momentum[i, 1], momentum[i, 2] = stored
        attitude[i, 0], attitude[i, 1], attitude[i, 2], attitude[i, 3] = q
        rate[i, 0], rate[i, 1], rate[i, 2] = w
