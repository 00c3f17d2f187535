"""Compiled rigid body: external torque, inertia, Euler's equation and kinematics."""

import math
from typing import Any

from ftac_gym.utils.algebra import add3, cross3, symmetric_times
from ftac_gym.utils.compiling import inlined, merged


@merged
def fill_disturbance(torque: Any, steady: Any, harmonics: Any, time: float, step: float) -> None:
    """Write the external torque at every half step, (2 * substeps + 1, 3) [N m], before any scaling with the rate.

    The sine and cosine of a harmonic advance by a fixed rotation, at four multiplications instead of two transcendental
    functions; both restart from exact values at every call.
    """
    for stage in range(torque.shape[0]):
        torque[stage, 0] = steady.constant[0]
        torque[stage, 1] = steady.constant[1]
        torque[stage, 2] = steady.constant[2]
    for index in range(harmonics.shape[0]):
        harmonic = harmonics[index]
        turn = 0.5 * step * harmonic.frequency
        turn_sine, turn_cosine = math.sin(turn), math.cos(turn)
        sine, cosine = math.sin(harmonic.frequency * time), math.cos(harmonic.frequency * time)
        for stage in range(torque.shape[0]):
            torque[stage, 0] += harmonic.sine[0] * sine + harmonic.cosine[0] * cosine
            torque[stage, 1] += harmonic.sine[1] * sine + harmonic.cosine[1] * cosine
            torque[stage, 2] += harmonic.sine[2] * sine + harmonic.cosine[2] * cosine
            sine, cosine = sine * turn_cosine + cosine * turn_sine, cosine * turn_cosine - sine * turn_sine


@inlined
def inertia_at(record: Any, carried: Any, varying: bool, rate_torque: bool, time: float) -> Any:
    """Inertia (xx, yy, zz, xy, xz, yz), its inverse in the same order, and J' (xx, yy, zz) if it makes a torque.

    ``carried`` is what flexible modes take along, in the same order, and no part of the inertia returned.
    """
    xx, yy, zz = (
        record.constant[0, 0] - carried[0],
        record.constant[1, 1] - carried[1],
        record.constant[2, 2] - carried[2],
    )
    xy, xz, yz = (
        record.constant[0, 1] - carried[3],
        record.constant[0, 2] - carried[4],
        record.constant[1, 2] - carried[5],
    )
    change_x, change_y, change_z = 0.0, 0.0, 0.0
    if varying:
        angle_x = record.frequency[0] * time + record.phase[0]
        angle_y = record.frequency[1] * time + record.phase[1]
        angle_z = record.frequency[2] * time + record.phase[2]
        xx += record.amplitude[0] * math.sin(angle_x)
        yy += record.amplitude[1] * math.sin(angle_y)
        zz += record.amplitude[2] * math.sin(angle_z)
        if rate_torque:
            change_x = record.amplitude[0] * record.frequency[0] * math.cos(angle_x)
            change_y = record.amplitude[1] * record.frequency[1] * math.cos(angle_y)
            change_z = record.amplitude[2] * record.frequency[2] * math.cos(angle_z)
    minor_x, minor_y, minor_z = yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy
    scale = 1.0 / (xx * minor_x + xy * minor_y + xz * minor_z)
    inverse = (
        scale * minor_x,
        scale * (xx * zz - xz * xz),
        scale * (xx * yy - xy * xy),
        scale * minor_y,
        scale * minor_z,
        scale * (xy * xz - xx * yz),
    )
    return (xx, yy, zz, xy, xz, yz), inverse, (change_x, change_y, change_z)


@inlined
def angular_acceleration(w: Any, stored: Any, wheel: Any, external: Any, body: Any, steady: Any) -> Any:
    """Euler's equation: J w' = -w x (J w + stored) + wheel + external - J' w, all in body axes.

    ``external`` is multiplied by (``|w|^2`` + c) where the disturbance asks for it.
    """
    inertia, inverse, change = body
    momentum = add3(symmetric_times(inertia, w), 1.0, stored)
    scale = 1.0
    if steady.rate_scaled > 0.5:
        scale = w[0] * w[0] + w[1] * w[1] + w[2] * w[2] + steady.rate_offset
    turning = cross3(w, momentum)
    x = wheel[0] + scale * external[0] - turning[0] - change[0] * w[0]
    y = wheel[1] + scale * external[1] - turning[1] - change[1] * w[1]
    z = wheel[2] + scale * external[2] - turning[2] - change[2] * w[2]
    return symmetric_times(inverse, (x, y, z))


@merged
def twice_attitude_rate(w: Any, q: Any) -> Any:
    """Return 2 q' = q (x) [0, w]."""
    return (
        -q[1] * w[0] - q[2] * w[1] - q[3] * w[2],
        q[0] * w[0] + q[2] * w[2] - q[3] * w[1],
        q[0] * w[1] + q[3] * w[0] - q[1] * w[2],
        q[0] * w[2] + q[1] * w[1] - q[2] * w[0],
    )
