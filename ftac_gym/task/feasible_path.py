"""Compiled turns to the target: which axis, and how far."""

import math
from typing import Any

from ftac_gym.task.feasible_torque import add3, cross3, dot3, quaternion_product, rotation_change, scaled3
from ftac_gym.utils.compiling import called


@called
def in_body(q: Any, a: Any) -> Any:
    """Return a vector of the reference frame in body axes, for the attitude q of the body in that frame."""
    return add3(a, 1.0, rotation_change(q[0], (q[1], q[2], q[3]), a))


@called
def rotation_vector(q: Any) -> Any:
    """Return the rotation vector of an attitude [rad], at most half a turn."""
    sine = math.sqrt(q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    angle = 2.0 * math.atan2(sine, abs(q[0]))
    unit = math.copysign(angle, q[0]) / sine if sine > 1e-12 else 0.0
    return scaled3(unit, (q[1], q[2], q[3]))


@called
def about_momentum(q: Any, total: Any) -> Any:
    """Return an attitude as a tilt of the stored momentum plus a turn about it, one vector [rad] in body axes.

    The momentum keeps its direction in space. A tilt takes it to where it is in the body at the target: it moves least,
    and takes the least gyroscopic torque. The turn about it takes none.
    """
    size = math.sqrt(dot3(total, total))
    aimed = in_body((q[0], -q[1], -q[2], -q[3]), total)
    normal = cross3(total, aimed)
    sine, cosine = math.sqrt(dot3(normal, normal)), dot3(total, aimed)
    if size < 1e-9 or sine < 1e-6 * size * size:
        return rotation_vector(q)
    tilt = math.atan2(sine, cosine)
    tilted = scaled3(tilt / sine, normal)
    ratio = -math.sin(0.5 * tilt) / sine
    rest = quaternion_product(q, (math.cos(0.5 * tilt), ratio * normal[0], ratio * normal[1], ratio * normal[2]))
    return add3(tilted, dot3(rotation_vector(rest), aimed) / (size * size), total)
