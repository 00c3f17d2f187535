"""Compiled multiplicative extended Kalman filter of attitude and gyro bias, and its records."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ftac_gym.utils import algebra
from ftac_gym.utils.algebra import cross3, norm3, quaternion_product, rotation, unit
from ftac_gym.utils.compiling import entry_point, merged

ATTITUDE_STATE = np.dtype(
    [
        ("started", "?"),
        ("rejected", "i8"),
        ("fixes", "i8"),
        ("fix_time", "f8"),
        ("innovation_square", "f8"),
        ("attitude", "f8", (4,)),
        ("bias", "f8", (3,)),
        ("measured_rate", "f8", (3,)),
        ("offset", "f8", (3,)),
        ("covariance", "f8", (6, 6)),
    ]
)
"""State of the filter of one spacecraft.

Whether it has started; samples of the star tracker rejected in a row, and accepted ones; the time of the newest sample
[s]; the squared normalised innovation of the newest sample; estimated attitude and gyro bias [rad/s]; the measured rate
of the last period [rad/s]; the last rejected innovation [rad]; covariance of the errors of attitude [rad] and bias.
"""

CONFIRMING = 5
"""Rejected samples in a row that agree with each other, after which the next one is accepted."""


class AttitudeModel(NamedTuple):
    """Errors of star tracker and gyros, as the filter assumes them; SI units.

    Attributes
    ----------
    period
        Control period [s].
    angle_walk
        Variance of the angle per second [rad^2/s]: the squared angle random walk.
    bias_walk
        Variance of the bias per second [(rad/s)^2/s].
    bias_start
        Variance of each bias at the start [(rad/s)^2].
    linear_error
        Variance of the errors in proportion to the rate, of scale and alignment [-].
    cross_variance, boresight_variance
        Variance of a sample of the star tracker across and about the boresight [rad^2].
    boresight
        (3,) direction of the boresight in body axes.
    gate
        Largest squared normalised innovation that is accepted; infinite for no gate.
    """

    period: float
    angle_walk: float
    bias_walk: float
    bias_start: float
    linear_error: float
    cross_variance: float
    boresight_variance: float
    boresight: Any
    gate: float


@merged
def symmetric_inverse(matrix: Any, out: Any) -> float:
    """Write the inverse of a symmetric positive (3, 3) matrix, and return its determinant."""
    a, b, c = matrix[0, 0], matrix[0, 1], matrix[0, 2]
    d, e, f = matrix[1, 1], matrix[1, 2], matrix[2, 2]
    x, y, z = d * f - e * e, c * e - b * f, b * e - c * d
    determinant = a * x + b * y + c * z
    scale = 1.0 / determinant
    out[0, 0], out[0, 1], out[0, 2] = scale * x, scale * y, scale * z
    out[1, 0], out[1, 1], out[1, 2] = scale * y, scale * (a * f - c * c), scale * (b * c - a * e)
    out[2, 0], out[2, 1], out[2, 2] = scale * z, out[1, 2], scale * (a * d - b * b)
    return float(determinant)


@merged
def propagate(covariance: Any, turn: Any, model: Any, growth: float) -> None:
    """Carry a covariance (6, 6) over one control period, in place.

    Parameters
    ----------
    covariance
        Covariance of the errors of attitude and bias.
    turn
        Rotation vector of the period [rad].
    model
        Its :class:`AttitudeModel`.
    growth
        Variance that is added to each bias [(rad/s)^2].
    """
    period = model.period
    q = rotation(turn)
    s, x, y, z = q[0], q[1], q[2], q[3]
    # The transpose of the rotation: errors are in body axes, which turn with the body.
    rows = (
        (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + s * z), 2.0 * (x * z - s * y)),
        (2.0 * (x * y - s * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + s * x)),
        (2.0 * (x * z + s * y), 2.0 * (y * z - s * x), 1.0 - 2.0 * (x * x + y * y)),
    )
    for k in range(6):
        a, b, c = covariance[0, k], covariance[1, k], covariance[2, k]
        for i in range(3):
            row = rows[i]
            covariance[i, k] = row[0] * a + row[1] * b + row[2] * c - period * covariance[3 + i, k]
    for k in range(6):
        a, b, c = covariance[k, 0], covariance[k, 1], covariance[k, 2]
        for i in range(3):
            row = rows[i]
            covariance[k, i] = row[0] * a + row[1] * b + row[2] * c - period * covariance[k, 3 + i]
    walk = period * model.bias_walk
    for i in range(3):
        covariance[i, i] += period * (model.angle_walk + period * walk / 3.0)
        covariance[i, 3 + i] -= 0.5 * period * walk
        covariance[3 + i, i] -= 0.5 * period * walk
        covariance[3 + i, 3 + i] += walk + growth


@merged
def restart(state: Any, model: Any, innovation: Any, spread: float) -> None:
    """Widen a covariance so that the next update takes an innovation (3 numbers) [rad] for real."""
    size = innovation[0] * innovation[0] + innovation[1] * innovation[1] + innovation[2] * innovation[2]
    for i in range(6):
        for k in range(6):
            state.covariance[i, k] = 0.0
    for i in range(3):
        state.covariance[i, i] = size + model.cross_variance + model.boresight_variance
        state.covariance[3 + i, 3 + i] = model.bias_start + spread


@merged
def correct(state: Any, model: Any, attitude: Any, age: float, rate: Any, work: Any) -> None:
    """Update the state by a sample of the star tracker that was carried forward with the gyros for its age.

    The error of the carried sample and that of the estimate share the gyro noise over the age. With H = [I, age I] the
    innovation y = phi - age b^ has the covariance H P H' - age N^2 I + R, and its covariance with the state is P H' -
    [age N^2 I; 0]: exactly that of the innovation when the sample was taken.

    Parameters
    ----------
    state
        The ATTITUDE_STATE record.
    model
        The :class:`AttitudeModel`.
    attitude
        Measured quaternion.
    age
        Age of the sample [s].
    rate
        Rate of the body [rad/s].
    work
        (4, 6, 6) scratch.
    """
    covariance, cross, inside, inverse = state.covariance, work[0], work[1], work[2]
    q = state.attitude
    difference = quaternion_product((q[0], -q[1], -q[2], -q[3]), (attitude[0], attitude[1], attitude[2], attitude[3]))
    half = math.sqrt(difference[1] ** 2 + difference[2] ** 2 + difference[3] ** 2)
    angle = 2.0 * math.atan2(half, abs(difference[0]))
    factor = math.copysign(angle / half if half > 1e-9 else 2.0, difference[0])
    innovation = (
        factor * difference[1] - age * state.bias[0],
        factor * difference[2] - age * state.bias[1],
        factor * difference[3] - age * state.bias[2],
    )
    shared = age * model.angle_walk
    # The boresight at the time of the sample, in body axes of now.
    back = cross3((model.boresight[0], model.boresight[1], model.boresight[2]), rate)
    sight = (
        model.boresight[0] + age * back[0],
        model.boresight[1] + age * back[1],
        model.boresight[2] + age * back[2],
    )
    more = model.boresight_variance - model.cross_variance
    jumped = state.rejected >= CONFIRMING
    if jumped:
        elapsed = CONFIRMING * model.period
        size = innovation[0] ** 2 + innovation[1] ** 2 + innovation[2] ** 2
        restart(state, model, innovation, size / (elapsed * elapsed) * 0.01)
    for i in range(6):
        for k in range(3):
            cross[i, k] = covariance[i, k] + age * covariance[i, 3 + k]
        if i < 3:
            cross[i, i] -= shared
    for i in range(3):
        for k in range(3):
            inside[i, k] = cross[i, k] + age * cross[3 + i, k] + more * sight[i] * sight[k]
        inside[i, i] += model.cross_variance
    symmetric_inverse(inside, inverse)
    square = 0.0
    for i in range(3):
        for k in range(3):
            square += innovation[i] * inverse[i, k] * innovation[k]
    state.innovation_square = square
    if square > model.gate and not jumped:
        change = (innovation[0] - state.offset[0], innovation[1] - state.offset[1], innovation[2] - state.offset[2])
        agreed = norm3(change) <= 0.2 * norm3(innovation) + 5.0 * math.sqrt(
            2.0 * model.cross_variance + model.boresight_variance
        )
        state.rejected = state.rejected + 1 if agreed or state.rejected == 0 else 1
        state.offset[0], state.offset[1], state.offset[2] = innovation[0], innovation[1], innovation[2]
        return
    state.rejected = 0
    state.fixes += 1
    gain = work[3]
    for i in range(6):
        for k in range(3):
            gain[i, k] = cross[i, 0] * inverse[0, k] + cross[i, 1] * inverse[1, k] + cross[i, 2] * inverse[2, k]
    for i in range(6):
        for k in range(i, 6):
            value = covariance[i, k] - gain[i, 0] * cross[k, 0] - gain[i, 1] * cross[k, 1] - gain[i, 2] * cross[k, 2]
            covariance[i, k] = value
            covariance[k, i] = value
    step = (
        gain[0, 0] * innovation[0] + gain[0, 1] * innovation[1] + gain[0, 2] * innovation[2],
        gain[1, 0] * innovation[0] + gain[1, 1] * innovation[1] + gain[1, 2] * innovation[2],
        gain[2, 0] * innovation[0] + gain[2, 1] * innovation[1] + gain[2, 2] * innovation[2],
    )
    turned = unit(quaternion_product((q[0], q[1], q[2], q[3]), rotation(step)))
    for k in range(4):
        q[k] = turned[k]
    for i in range(3):
        state.bias[i] += (
            gain[3 + i, 0] * innovation[0] + gain[3 + i, 1] * innovation[1] + gain[3 + i, 2] * innovation[2]
        )


@merged
def advance(state: Any, model: Any, time: float, attitude: Any, age: float, rate: Any, work: Any) -> None:
    """Take one measurement of one spacecraft into its state; arguments as of :func:`filter_attitude`."""
    taken = time - age
    seen = state.measured_rate
    if not state.started:
        state.started = True
        state.rejected, state.fixes, state.fix_time = 0, 1, taken
        state.innovation_square = 0.0
        for k in range(4):
            state.attitude[k] = attitude[k]
        restart(state, model, (0.0, 0.0, 0.0), 0.0)
        for i in range(3):
            state.bias[i] = 0.0
            seen[i] = rate[i]
        return
    mean = (
        0.5 * (seen[0] + rate[0]) - state.bias[0],
        0.5 * (seen[1] + rate[1]) - state.bias[1],
        0.5 * (seen[2] + rate[2]) - state.bias[2],
    )
    turn = (model.period * mean[0], model.period * mean[1], model.period * mean[2])
    q = state.attitude
    carried = unit(quaternion_product((q[0], q[1], q[2], q[3]), rotation(turn)))
    for k in range(4):
        q[k] = carried[k]
    # Errors of scale and alignment are a bias that changes with the rate.
    now, before = 0.0, 0.0
    for i in range(3):
        now += (rate[i] - state.bias[i]) ** 2
        before += (seen[i] - state.bias[i]) ** 2
        seen[i] = rate[i]
    propagate(state.covariance, turn, model, model.linear_error * abs(now - before))
    # Written so that an age that is not a number is no old sample.
    if not taken <= state.fix_time + 0.5 * model.period:
        state.fix_time = taken
        correct(state, model, attitude, age, mean, work)


@entry_point(algebra)
def filter_attitude(state: Any, model: Any, time: Any, attitude: Any, age: Any, rate: Any) -> None:
    """Take one measurement of N spacecraft into their states, in place.

    Parameters
    ----------
    state
        ATTITUDE_STATE records (N,).
    model
        The :class:`AttitudeModel`.
    time, age
        (N,) times of the measurements, and ages of the samples of the star tracker [s].
    attitude
        (N, 4) measured quaternions.
    rate
        (N, 3) measured rates [rad/s].
    """
    work = np.zeros((4, 6, 6))
    for i in range(len(state)):
        advance(state[i], model, time[i], attitude[i], age[i], rate[i], work)
