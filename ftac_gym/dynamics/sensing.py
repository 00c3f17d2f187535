"""Compiled measurement: the commanded attitude of the moment, and the reports of the sensors."""

import math
from typing import Any

from ftac_gym.dynamics import algebra, fault_signals, instruments
from ftac_gym.dynamics.algebra import (
    add3,
    add4,
    cross3,
    norm3,
    quaternion_product,
    rotation,
    row3,
    row4,
    scale3,
    store3,
    store_unit,
)
from ftac_gym.dynamics.fault_signals import acts, part_at
from ftac_gym.dynamics.instruments import gyro_rate, report, track
from ftac_gym.task import references
from ftac_gym.task.references import ReferenceKind
from ftac_gym.utils import randomness
from ftac_gym.utils.compiling import entry_point, inlined, merged
from ftac_gym.utils.randomness import normals

_SET_POINTS = int(ReferenceKind.SET_POINTS)
_MRP_SINUSOID = int(ReferenceKind.MRP_SINUSOID)


@inlined
def sinusoid(record: Any, axis: int, time: float) -> Any:
    """Return value, first and second derivative of constant + amplitude sin(frequency t + phase) on one axis."""
    angle = record.frequency[axis] * time + record.phase[axis]
    sine, cosine = record.amplitude[axis] * math.sin(angle), record.amplitude[axis] * math.cos(angle)
    frequency = record.frequency[axis]
    return record.constant[axis] + sine, frequency * cosine, -frequency * frequency * sine


@inlined
def mrp_map(sigma: Any, square: float, a: Any, along: float) -> Any:
    """Return (1 - s^2) a - 2 sigma x a + 2 along sigma, with s^2 = ``square``."""
    c = cross3(sigma, a)
    return (
        (1.0 - square) * a[0] - 2.0 * c[0] + 2.0 * sigma[0] * along,
        (1.0 - square) * a[1] - 2.0 * c[1] + 2.0 * sigma[1] * along,
        (1.0 - square) * a[2] - 2.0 * c[2] + 2.0 * sigma[2] * along,
    )


@merged
def follow_mrp(i: int, record: Any, time: float, attitude: Any, rate: Any, acceleration: Any) -> None:
    """Write the reference from modified Rodrigues parameters.

    With P(v) = (1 - s^2) v - 2 sigma x v + 2 sigma (sigma.v): w = 4 P(sigma') / (1 + s^2)^2 and
    w' = 4 (P(sigma'') + 2 sigma ``|sigma'|^2``) / (1 + s^2)^2 - 4 (sigma.sigma') / (1 + s^2) w.
    """
    x, vx, ax = sinusoid(record, 0, time)
    y, vy, ay = sinusoid(record, 1, time)
    z, vz, az = sinusoid(record, 2, time)
    square = x * x + y * y + z * z
    store_unit(attitude, i, (1.0 - square, 2.0 * x, 2.0 * y, 2.0 * z))
    along_v, along_a = x * vx + y * vy + z * vz, x * ax + y * ay + z * az + vx * vx + vy * vy + vz * vz
    scale = 4.0 / ((1.0 + square) * (1.0 + square))
    turned = scale3(scale, mrp_map((x, y, z), square, (vx, vy, vz), along_v))
    store3(rate, i, turned)
    drag = 4.0 * along_v / (1.0 + square)
    bent = scale3(scale, mrp_map((x, y, z), square, (ax, ay, az), along_a))
    store3(acceleration, i, add3(bent, -drag, turned))


@merged
def half_turn_rate(q: Any, record: Any, time: float) -> Any:
    """Return q' = 1/2 q (x) [0, w_d(t)]."""
    x, y, z = sinusoid(record, 0, time)[0], sinusoid(record, 1, time)[0], sinusoid(record, 2, time)[0]
    return quaternion_product(q, (0.0, 0.5 * x, 0.5 * y, 0.5 * z))


@merged
def follow_rate(
    i: int, record: Any, tick: int, step: float, substeps: int, attitude: Any, rate: Any, acceleration: Any
) -> None:
    """Write the reference from a rate profile: integrate the attitude over the control period that ends now (RK4)."""
    period = step * substeps
    if tick == 0:
        for k in range(4):
            attitude[i, k] = record.attitude[k]
    else:
        q = (attitude[i, 0], attitude[i, 1], attitude[i, 2], attitude[i, 3])
        for substep in range(substeps):
            time = (tick - 1) * period + substep * step
            turn_1 = half_turn_rate(q, record, time)
            turn_2 = half_turn_rate(add4(q, 0.5 * step, turn_1), record, time + 0.5 * step)
            turn_3 = half_turn_rate(add4(q, 0.5 * step, turn_2), record, time + 0.5 * step)
            turn_4 = half_turn_rate(add4(q, step, turn_3), record, time + step)
            q = add4(add4(q, step / 6.0, add4(turn_1, 1.0, turn_4)), step / 3.0, add4(turn_2, 1.0, turn_3))
        store_unit(attitude, i, q)
    for axis in range(3):
        rate[i, axis], acceleration[i, axis] = sinusoid(record, axis, tick * period)[:2]


@entry_point(algebra, fault_signals, instruments, randomness, references)
def sense(
    rows: Any,
    attitude: Any,
    rate: Any,
    ticks: Any,
    step: float,
    substeps: int,
    reference: Any,
    set_points: Any,
    reference_attitude: Any,
    reference_rate: Any,
    reference_acceleration: Any,
    sensors: Any,
    sensor_faults: Any,
    switches: Any,
    keys: Any,
    episodes: Any,
    gyro_bias: Any,
    measured_attitude: Any,
    measured_rate: Any,
    star_tracker_valid: Any,
    fix_ticks: Any,
    suite: Any,
    suite_sensors: Any,
    wheel_momentum: Any,
    modal_displacement: Any,
    modal_rate: Any,
    largest_rate: float,
) -> int:
    """Update the reference and the measurement of the listed rows after a reset or a control period, in place.

    Reference and measurement arrays are (N, 4) or (N, 3), the rate and acceleration of the reference in the reference
    frame's axes. The noise is a function of (key, episode, tick) alone. The gyro bias walks by one step for every tick
    after the first. While the star tracker is out, the measured attitude is the last one, turned by the mean of the
    last two measured rates. ``fix_ticks`` (N,) holds the tick at which the star tracker has taken the sample in use.

    Of the arguments of the two kinds of sensors, one must be None, for which the compiler leaves its code out:
    ``sensors``, SENSOR records (N,), or both ``suite``, the :class:`~ftac_gym.dynamics.instruments.Instruments`, and
    ``suite_sensors``, SUITE records (N,). With a suite, wheel momentum and modes are measured too.

    Returns
    -------
    Number of rows that have diverged: those with a rate beyond ``largest_rate`` [rad/s], or with an entry that is not
    finite.
    """
    period = step * substeps
    diverged = 0
    for index in range(rows.shape[0]):
        i = rows[index]
        tick = ticks[i]
        record = reference[i]
        if record.kind == _SET_POINTS:
            point = 0
            # The tolerance is far below a physics step and absorbs rounding in tick * period.
            while point + 1 < set_points.shape[1] and set_points[i, point + 1].time <= tick * period + 1e-9:
                point += 1
            for k in range(4):
                reference_attitude[i, k] = set_points[i, point].attitude[k]
            for k in range(3):
                reference_rate[i, k] = 0.0
                reference_acceleration[i, k] = 0.0
        elif record.kind == _MRP_SINUSOID:
            follow_mrp(i, record, tick * period, reference_attitude, reference_rate, reference_acceleration)
        else:
            follow_rate(i, record, tick, step, substeps, reference_attitude, reference_rate, reference_acceleration)

        w = row3(rate, i)
        seen = (0.0, 0.0, 0.0)
        noise_0, noise_1, noise_2, noise_3, noise_4, noise_5 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        if suite is not None:
            seen = gyro_rate(
                i, w, tick, period, suite_sensors[i], keys, episodes[i], gyro_bias, suite.varying_bias
            )  # fmt: skip
        if sensors is not None:
            sensor = sensors[i]
            walk = sensor.gyro_bias_walk * math.sqrt(period)
            if walk > 0.0 and tick > 0:
                walk_x, walk_y, walk_z, _ = normals(tick, episodes[i], 2, keys, i)
                gyro_bias[i, 0] += walk * walk_x
                gyro_bias[i, 1] += walk * walk_y
                gyro_bias[i, 2] += walk * walk_z
            if sensor.attitude_noise > 0.0 or sensor.rate_noise > 0.0:
                noise_0, noise_1, noise_2, noise_3 = normals(tick, episodes[i], 0, keys, i)
                noise_4, noise_5, _, _ = normals(tick, episodes[i], 1, keys, i)
            tilt = sensor.gyro_misalignment
            seen = (
                w[0] + tilt[1] * w[2] - tilt[2] * w[1] + gyro_bias[i, 0] + sensor.rate_noise * noise_3,
                w[1] + tilt[2] * w[0] - tilt[0] * w[2] + gyro_bias[i, 1] + sensor.rate_noise * noise_4,
                w[2] + tilt[0] * w[1] - tilt[1] * w[0] + gyro_bias[i, 2] + sensor.rate_noise * noise_5,
            )
        turn = (0.0, 0.0, 0.0)
        blind = False
        for k in range(sensor_faults.shape[1]):
            fault = sensor_faults[i, k]
            if acts(fault, switches, i, tick * period):
                part = part_at(fault, tick * period)
                seen = add3(seen, part, fault.rate_bias)
                turn = add3(turn, part, fault.attitude_turn)
                blind = blind or fault.outage > 0.5
        star_tracker_valid[i] = not blind
        if suite is not None:
            track(
                i, attitude, seen, turn, blind, tick, period, suite_sensors[i], keys, episodes[i], suite, measured_rate,
                measured_attitude, fix_ticks,
            )  # fmt: skip
            report(i, tick, suite_sensors[i], keys, episodes[i], wheel_momentum, modal_displacement, modal_rate, suite)
        if sensors is not None:
            sensor = sensors[i]
            if blind and tick > 0:
                # The rate measured now carries the attitude measured a period ago forward.
                mean = scale3(0.5, add3(seen, 1.0, row3(measured_rate, i)))
                carried = quaternion_product(row4(measured_attitude, i), rotation(scale3(period, mean)))
                # Stored in both branches: the compiler rounds a common normalisation in another way.
                store_unit(measured_attitude, i, carried)
            else:
                half = 0.5 * sensor.attitude_noise
                measured = quaternion_product(row4(attitude, i), (1.0, half * noise_0, half * noise_1, half * noise_2))
                if turn[0] != 0.0 or turn[1] != 0.0 or turn[2] != 0.0:
                    measured = quaternion_product(measured, rotation(turn))
                store_unit(measured_attitude, i, measured)
                fix_ticks[i] = tick
        store3(measured_rate, i, seen)
        # Zero unless a term is infinite or not a number, and no comparison with such a sum is true.
        excess = 0.0
        for k in range(3):
            excess += 0.0 * (seen[k] + reference_rate[i, k] + reference_acceleration[i, k])
        for k in range(4):
            excess += 0.0 * (measured_attitude[i, k] + reference_attitude[i, k])
        if not norm3(w) + excess <= largest_rate:
            diverged += 1
    return diverged
