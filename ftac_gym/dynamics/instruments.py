"""Compiled reports of a sensor suite: star tracker with rate and latency, gyros, telemetry of wheels and modes."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ftac_gym.dynamics.algebra import cross3, quaternion_product, rotation, row4, scale3, store3, store_unit
from ftac_gym.dynamics.state import State, identity_quaternions
from ftac_gym.task.sensor_suite import SensorSuite
from ftac_gym.utils.compiling import inlined, merged
from ftac_gym.utils.parameters import FloatArray
from ftac_gym.utils.randomness import normals

# Blocks of the noise stream; those below are of the simple sensors.
_RATE_NOISE, _BIAS_WALK, _INSTABILITY, _FIX_NOISE, _TELEMETRY = 4, 5, 6, 7, 8


class Instruments(NamedTuple):
    """State of the sensors of a suite, for N spacecraft with m wheels and k modes; arrays change with every period.

    Attributes
    ----------
    every
        Control periods from one sample of the star tracker to the next.
    turned
        (N, 4) quaternion of the rotation since the start of the episode as integrated from the gyros, G(t).
    anchors
        (N, depth, 4) quaternions fix (x) conj(G) of the latest samples of the star tracker, at their times.
    taken
        (N, depth) tick of each of these samples; -1 for none.
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
    turned: FloatArray
    anchors: FloatArray
    taken: npt.NDArray[np.int64]
    anchor: FloatArray
    varying_bias: FloatArray
    wheel_momentum: FloatArray
    modal_displacement: FloatArray
    modal_rate: FloatArray


def instruments(suite: SensorSuite, control_period: float, state: State) -> Instruments:
    """Return the sensors of spacecraft in a state, before the start of an episode."""
    count, depth = len(state.attitude), suite.fixes(control_period)
    return Instruments(
        suite.tracker_periods(control_period),
        identity_quaternions(count),
        np.zeros((count, depth, 4)),
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
        factor = 0.5 * (1.0 - square / 6.0 * (1.0 - square / 20.0 * (1.0 - square / 42.0 * (1.0 - square / 72.0))))
        cosine = 1.0 - square / 2.0 * (
            1.0 - square / 12.0 * (1.0 - square / 30.0 * (1.0 - square / 56.0 * (1.0 - square / 90.0)))
        )
    else:
        angle = math.sqrt(square)
        factor, cosine = 0.5 * math.sin(angle) / angle, math.cos(angle)
    return cosine, factor * turn[0], factor * turn[1], factor * turn[2]


@merged
def gyro_rate(
    i: int, w: Any, tick: int, period: float, sensor: Any, keys: Any, episode: int, gyro_bias: Any, varying_bias: Any
) -> Any:
    """Return the rate that the gyros of spacecraft i report, without faults; let their bias vary by one period.

    (1 + scale factor) (w + misalignment x w) + bias + noise on each axis, with the noise N / sqrt(period) of the angle
    random walk N. The bias walks by K sqrt(period) z a period. Its Gauss-Markov part b has the exact discrete form
    b <- phi b + sigma sqrt(1 - phi^2) z with phi = exp(-period / correlation time), and begins with sigma z.
    """
    noise = (0.0, 0.0, 0.0)
    if sensor.angle_random_walk > 0.0:
        x, y, z, _ = normals(tick, episode, _RATE_NOISE, keys, i)
        noise = scale3(sensor.angle_random_walk / math.sqrt(period), (x, y, z))
    if sensor.rate_random_walk > 0.0 and tick > 0:
        x, y, z, _ = normals(tick, episode, _BIAS_WALK, keys, i)
        walk = sensor.rate_random_walk * math.sqrt(period)
        gyro_bias[i, 0] += walk * x
        gyro_bias[i, 1] += walk * y
        gyro_bias[i, 2] += walk * z
    if sensor.bias_instability > 0.0:
        x, y, z, _ = normals(tick, episode, _INSTABILITY, keys, i)
        kept = math.exp(-period / sensor.correlation_time) if tick > 0 else 0.0
        size = sensor.bias_instability * math.sqrt(1.0 - kept * kept)
        varying_bias[i, 0] = kept * varying_bias[i, 0] + size * x
        varying_bias[i, 1] = kept * varying_bias[i, 1] + size * y
        varying_bias[i, 2] = kept * varying_bias[i, 2] + size * z
    elif tick == 0:
        store3(varying_bias, i, (0.0, 0.0, 0.0))
    tilt, scale = sensor.gyro_misalignment, sensor.scale_factor
    aside = cross3(tilt, w)
    return (
        (1.0 + scale[0]) * (w[0] + aside[0]) + gyro_bias[i, 0] + varying_bias[i, 0] + noise[0],
        (1.0 + scale[1]) * (w[1] + aside[1]) + gyro_bias[i, 1] + varying_bias[i, 1] + noise[1],
        (1.0 + scale[2]) * (w[2] + aside[2]) + gyro_bias[i, 2] + varying_bias[i, 2] + noise[2],
    )


@merged
def fix_of(i: int, attitude: Any, turn: Any, tick: int, sensor: Any, keys: Any, episode: int) -> Any:
    """Return the attitude that the star tracker of spacecraft i sees: noise first, then the turn of a fault [rad]."""
    q = row4(attitude, i)
    if sensor.cross_noise > 0.0 or sensor.boresight_noise > 0.0:
        x, y, z, _ = normals(tick, episode, _FIX_NOISE, keys, i)
        # Half the rotation vector: cross_noise on all axes, and along the boresight the difference.
        along = sensor.boresight[0] * x + sensor.boresight[1] * y + sensor.boresight[2] * z
        across, more = 0.5 * sensor.cross_noise, 0.5 * (sensor.boresight_noise - sensor.cross_noise) * along
        q = quaternion_product(
            q,
            (
                1.0,
                across * x + more * sensor.boresight[0],
                across * y + more * sensor.boresight[1],
                across * z + more * sensor.boresight[2],
            ),
        )
    if turn[0] != 0.0 or turn[1] != 0.0 or turn[2] != 0.0:
        q = quaternion_product(q, rotation(turn))
    return q


@merged
def track(
    i: int, attitude: Any, seen: Any, turn: Any, blind: bool, tick: int, period: float, sensor: Any, keys: Any,
    episode: int, instruments: Any, measured_rate: Any, measured_attitude: Any, fix_ticks: Any,
) -> None:  # fmt: skip
    """Write the measured attitude of spacecraft i, and the tick of the fix that it is from.

    G(t) is integrated from the gyros. A sample at t_s is stored as fix (x) conj(G(t_s)); that of the latest available
    sample, times G(t), is the attitude measured at t. At the start a fix without age is there. While the star tracker
    is out it takes no sample, and those that become ready are lost.

    Parameters
    ----------
    seen
        Rate measured now [rad/s]; ``measured_rate`` (N, 3) still has that of the period before.
    turn, blind
        Turn of the attitude by faults [rad], and whether the star tracker is out.
    """
    turned, anchors, taken = instruments.turned, instruments.anchors, instruments.taken
    anchor, depth = instruments.anchor, instruments.taken.shape[1]
    if tick == 0:
        for slot in range(depth):
            taken[i, slot] = -1
        fix = fix_of(i, attitude, (0.0, 0.0, 0.0) if blind else turn, tick, sensor, keys, episode)
        turned[i, 0], turned[i, 1], turned[i, 2], turned[i, 3] = 1.0, 0.0, 0.0, 0.0
        store_unit(anchor, i, fix)
        fix_ticks[i] = 0
        store_unit(measured_attitude, i, fix)
        return
    half = 0.5 * period
    mean = (
        half * (seen[0] + measured_rate[i, 0]), half * (seen[1] + measured_rate[i, 1]),
        half * (seen[2] + measured_rate[i, 2]),
    )  # fmt: skip
    store_unit(turned, i, quaternion_product(row4(turned, i), small_rotation(mean)))
    if not blind:
        if tick % instruments.every == 0:
            fix = fix_of(i, attitude, turn, tick, sensor, keys, episode)
            back = (turned[i, 0], -turned[i, 1], -turned[i, 2], -turned[i, 3])
            slot = (tick // instruments.every) % depth
            store_unit(anchors[i], slot, quaternion_product(fix, back))
            taken[i, slot] = tick
        sampled = tick - math.ceil(sensor.latency / period - 1e-9)
        if sampled > 0 and sampled % instruments.every == 0:
            slot = (sampled // instruments.every) % depth
            if taken[i, slot] == sampled:
                for k in range(4):
                    anchor[i, k] = anchors[i, slot, k]
                fix_ticks[i] = sampled
    store_unit(measured_attitude, i, quaternion_product(row4(anchor, i), row4(turned, i)))


@merged
def noisy(
    i: int, values: Any, noise: float, quantum: float, first: int, tick: int, keys: Any, episode: int, out: Any
) -> int:
    """Write the values of a row with white noise, in steps of a quantum; return the next block of the noise."""
    width, block = values.shape[1], first
    for start in range(0, width, 4):
        a, b, c, d = 0.0, 0.0, 0.0, 0.0
        if noise > 0.0:
            a, b, c, d = normals(tick, episode, block, keys, i)
        block += 1
        for j in range(start, min(start + 4, width)):
            deviate = a if j == start else (b if j == start + 1 else (c if j == start + 2 else d))
            value = values[i, j] + noise * deviate
            if quantum > 0.0:
                value = quantum * math.floor(value / quantum + 0.5)
            out[i, j] = value
    return block


@merged
def report(
    i: int, tick: int, sensor: Any, keys: Any, episode: int, wheel_momentum: Any, modal_displacement: Any,
    modal_rate: Any, instruments: Any,
) -> None:  # fmt: skip
    """Write the measured wheel momentum and vibration modes of spacecraft i."""
    block = noisy(
        i, wheel_momentum, sensor.wheel_momentum_noise, sensor.wheel_momentum_quantum, _TELEMETRY, tick, keys, episode,
        instruments.wheel_momentum,
    )  # fmt: skip
    block = noisy(
        i, modal_displacement, sensor.modal_displacement_noise, 0.0, block, tick, keys, episode,
        instruments.modal_displacement,
    )  # fmt: skip
    noisy(i, modal_rate, sensor.modal_rate_noise, 0.0, block, tick, keys, episode, instruments.modal_rate)
