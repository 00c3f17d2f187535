"""Compiled reports of a sensor suite: star tracker with rate and latency, gyros, telemetry of wheels and modes."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ftac_gym.dynamics.state import State, identity_quaternions
from ftac_gym.task.sensor_suite import SensorSuite
from ftac_gym.utils.algebra import add3, cross3, quaternion_product, rotation, scale3, unit
from ftac_gym.utils.compiling import inlined, merged
from ftac_gym.utils.parameters import FloatArray
from ftac_gym.utils.randomness import normals

# Blocks of the noise stream; those below are of the simple sensors.
_GYRO_NOISE, _INSTABILITY, _FIX_NOISE = 4, 6, 7
WHEEL_NOISE, DISPLACEMENT_NOISE, MODAL_RATE_NOISE = 8, 1 << 16, 2 << 16
"""First blocks of the noise of telemetry; one block is for four wheels or modes."""


class Instruments(NamedTuple):
    """State of the sensors of a suite, for N spacecraft with m wheels and k modes; arrays change with every period.

    G(t) is the rotation since the start of the episode, integrated from the gyros. A sample of the star tracker, taken
    at t_s, is stored as fix (x) conj(G(t_s)). That of the latest available sample, times G(t), is the measured attitude
    at t. At the start a sample without age is there. While the star tracker is out it takes no samples, and those that
    become ready are lost.

    The compiled function takes the fields one by one: Numba would count references to arrays from a tuple at every use.

    Attributes
    ----------
    every
        Control periods from one sample of the star tracker to the next.
    clock
        (N, 5) tick of the next sample and its place among the stored ones; the same of the next sample that becomes
        available; and the latency [control periods].
    turned
        (N, 4) quaternion G(t).
    anchors
        (N depth, 4) quaternions fix (x) conj(G) of the latest samples of the star tracker, at their times.
    taken
        (N, depth) tick of each of these samples; -1 for one that the star tracker did not take.
    anchor
        (N, 4) that of the latest sample that has become available.
    varying_bias
        (N, 3) Gauss-Markov part of the gyro bias [rad/s].
    wheel_momentum
        (N, m) measured momentum of the wheels [N m s].
    modal_displacement, modal_rate
        (N, k) measured displacement [kg^1/2 m] and rate [kg^1/2 m/s] of the vibration modes.
    """

    every: int
    clock: npt.NDArray[np.int64]
    turned: FloatArray
    anchors: FloatArray
    taken: npt.NDArray[np.int64]
    anchor: FloatArray
    varying_bias: FloatArray
    wheel_momentum: FloatArray
    modal_displacement: FloatArray
    modal_rate: FloatArray


WITHOUT = (None,) * len(Instruments._fields)
"""Arguments in the place of instruments where there is no suite."""


def instruments(suite: SensorSuite, control_period: float, state: State) -> Instruments:
    """Return the sensors of spacecraft in a state, before the start of an episode."""
    count, depth = len(state.attitude), suite.fixes(control_period)
    return Instruments(
        suite.tracker_periods(control_period),
        np.zeros((count, 5), dtype=np.int64),
        identity_quaternions(count),
        np.zeros((count * depth, 4)),
        np.full((count, depth), -1, dtype=np.int64),
        identity_quaternions(count),
        np.zeros((count, 3)),
        *(np.zeros_like(part) for part in (state.wheel_momentum, state.modal_displacement, state.modal_rate)),
    )


@inlined
def small_rotation(turn: Any) -> Any:
    """Return the quaternion of a rotation vector [rad]: by series, exact to rounding, for turns below 0.2 rad."""
    square = 0.25 * (turn[0] * turn[0] + turn[1] * turn[1] + turn[2] * turn[2])
    if square < 0.01:
        # Products, not nested quotients: a division takes as long as the whole series.
        factor = 0.5 + square * (
            -1.0 / 12.0 + square * (1.0 / 240.0 + square * (-1.0 / 10080.0 + square * (1.0 / 725760.0)))
        )
        tail = -1.0 / 720.0 + square * (1.0 / 40320.0 - square * (1.0 / 3628800.0))
        cosine = 1.0 + square * (-0.5 + square * (1.0 / 24.0 + square * tail))
    else:
        angle = math.sqrt(square)
        factor, cosine = 0.5 * math.sin(angle) / angle, math.cos(angle)
    return cosine, factor * turn[0], factor * turn[1], factor * turn[2]


@inlined
def nearly_unit(q: Any) -> Any:
    """Return a quaternion normalised to rounding, if its norm differs from one by rounding only."""
    scale = 1.5 - 0.5 * (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    return scale * q[0], scale * q[1], scale * q[2], scale * q[3]


@merged
def gyro_rate(w: Any, bias: Any, varying: Any, tick: int, period: float, sensor: Any, episode: int, key: Any) -> Any:
    """Return the rate that gyros report without faults, and both parts of their bias, which vary once a period.

    (1 + scale factor) (w + misalignment x w) + bias + noise on each axis, with the noise N / sqrt(period) of the angle
    random walk N. The bias of one axis after the other walks, by K sqrt(3 period) z every third period: four deviates
    are then enough for both walks. Its Gauss-Markov part b has the exact discrete form
    b <- phi b + sigma sqrt(1 - phi^2) z with phi = exp(-period / correlation time), and begins with sigma z.
    """
    noise = (0.0, 0.0, 0.0)
    if sensor.angle_random_walk > 0.0 or sensor.rate_random_walk > 0.0:
        x, y, z, step = normals(tick, episode, _GYRO_NOISE, key)
        noise = scale3(sensor.angle_random_walk / math.sqrt(period), (x, y, z))
        walk, axis = sensor.rate_random_walk * math.sqrt(3.0 * period) * step, tick % 3
        if tick > 0:
            bias = (
                bias[0] + (walk if axis == 0 else 0.0),
                bias[1] + (walk if axis == 1 else 0.0),
                bias[2] + (walk if axis == 2 else 0.0),
            )
    if sensor.bias_instability > 0.0:
        x, y, z, _ = normals(tick, episode, _INSTABILITY, key)
        kept = math.exp(-period / sensor.correlation_time) if tick > 0 else 0.0
        size = sensor.bias_instability * math.sqrt(1.0 - kept * kept)
        varying = add3(scale3(kept, varying), size, (x, y, z))
    elif tick == 0:
        varying = (0.0, 0.0, 0.0)
    tilt, scale = sensor.gyro_misalignment, sensor.scale_factor
    aside = cross3(tilt, w)
    seen = (
        (1.0 + scale[0]) * (w[0] + aside[0]) + bias[0] + varying[0] + noise[0],
        (1.0 + scale[1]) * (w[1] + aside[1]) + bias[1] + varying[1] + noise[1],
        (1.0 + scale[2]) * (w[2] + aside[2]) + bias[2] + varying[2] + noise[2],
    )
    return seen, bias, varying


@inlined
def carry(turned: Any, seen: Any, before: Any, period: float) -> Any:
    """Return the rotation since the start after one more period, in which the measured rate [rad/s] has changed."""
    half = 0.5 * period
    turn = (half * (seen[0] + before[0]), half * (seen[1] + before[1]), half * (seen[2] + before[2]))
    return nearly_unit(quaternion_product(turned, small_rotation(turn)))


@merged
def fix_of(attitude: Any, turn: Any, tick: int, sensor: Any, episode: int, key: Any) -> Any:
    """Return the attitude that a star tracker sees, as a quaternion: noise first, then the turn of a fault [rad]."""
    q = attitude
    if sensor.cross_noise > 0.0 or sensor.boresight_noise > 0.0:
        x, y, z, _ = normals(tick, episode, _FIX_NOISE, key)
        # Half the rotation vector: cross_noise on all axes, and along the boresight the difference.
        axis = (sensor.boresight[0], sensor.boresight[1], sensor.boresight[2])
        along = axis[0] * x + axis[1] * y + axis[2] * z
        more = 0.5 * (sensor.boresight_noise - sensor.cross_noise) * along
        half = add3(scale3(0.5 * sensor.cross_noise, (x, y, z)), more, axis)
        q = quaternion_product(q, (1.0, half[0], half[1], half[2]))
    if turn[0] != 0.0 or turn[1] != 0.0 or turn[2] != 0.0:
        q = quaternion_product(q, rotation(turn))
    return unit(q)


@inlined
def reported(value: float, noise: float, deviates: Any, part: int, quantum: float) -> float:
    """Return a value with noise, of which there are four standard normal deviates, in steps of a quantum."""
    a, b, c, d = deviates
    noisy = value + noise * (a if part == 0 else (b if part == 1 else (c if part == 2 else d)))
    return quantum * np.floor(noisy / quantum + 0.5) if quantum > 0.0 else noisy
