"""Compiled measurement: the commanded attitude of the moment, and the reports of the sensors."""

import math
from typing import Any

from ftac_gym.dynamics import instruments, state
from ftac_gym.dynamics.instruments import (
    DISPLACEMENT_NOISE,
    MODAL_RATE_NOISE,
    WHEEL_NOISE,
    carry,
    fix_of,
    gyro_rate,
    nearly_unit,
    reported,
)
from ftac_gym.faults import signals
from ftac_gym.faults.signals import acts, part_at
from ftac_gym.task import references, sensor_suite
from ftac_gym.task.references import ReferenceKind
from ftac_gym.utils import algebra, parameters, randomness
from ftac_gym.utils.algebra import (
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
    store4,
    store_unit,
)
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


@entry_point(algebra, instruments, parameters, randomness, references, sensor_suite, signals, state)
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
    suite_sensors: Any,
    every: Any,
    clock: Any,
    turned: Any,
    anchors: Any,
    taken: Any,
    anchor: Any,
    varying_bias: Any,
    measured_momentum: Any,
    measured_displacement: Any,
    measured_modal_rate: Any,
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

    Of ``sensors``, SENSOR records (N,), and ``suite_sensors``, SUITE records (N,), one must be None, for which the
    compiler leaves the code of these sensors out. With a suite, wheel momentum and modes are measured too. Its further
    arguments are the fields of :class:`~ftac_gym.dynamics.instruments.Instruments`.

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

        key = (keys[i, 0], keys[i, 1])
        w = row3(rate, i)
        seen = (0.0, 0.0, 0.0)
        noise_0, noise_1, noise_2, noise_3, noise_4, noise_5 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        if suite_sensors is not None:
            biases = row3(gyro_bias, i), row3(varying_bias, i)
            seen, fixed, varying = gyro_rate(w, *biases, tick, period, suite_sensors[i], episodes[i], key)
            store3(gyro_bias, i, fixed)
            store3(varying_bias, i, varying)
        if sensors is not None:
            sensor = sensors[i]
            walk = sensor.gyro_bias_walk * math.sqrt(period)
            if walk > 0.0 and tick > 0:
                walk_x, walk_y, walk_z, _ = normals(tick, episodes[i], 2, key)
                gyro_bias[i, 0] += walk * walk_x
                gyro_bias[i, 1] += walk * walk_y
                gyro_bias[i, 2] += walk * walk_z
            if sensor.attitude_noise > 0.0 or sensor.rate_noise > 0.0:
                noise_0, noise_1, noise_2, noise_3 = normals(tick, episodes[i], 0, key)
                noise_4, noise_5, _, _ = normals(tick, episodes[i], 1, key)
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
        if suite_sensors is not None:
            suite, depth = suite_sensors[i], taken.shape[1]
            if tick == 0:
                # A sample without age; of the others, the next one to take and the next one to become available.
                clock[i, 0], clock[i, 1], clock[i, 2], clock[i, 3] = every, 0, every, 0
                clock[i, 4] = math.ceil(suite.latency / period - 1e-9)
                spike = (0.0, 0.0, 0.0) if blind else turn
                store4(anchor, i, fix_of(row4(attitude, i), spike, tick, suite, episodes[i], key))
                store4(turned, i, (1.0, 0.0, 0.0, 0.0))
                fix_ticks[i] = 0
            else:
                store4(turned, i, carry(row4(turned, i), seen, row3(measured_rate, i), period))
            if tick == clock[i, 0]:
                slot = clock[i, 1]
                taken[i, slot] = -1 if blind else tick
                if not blind:
                    fix = fix_of(row4(attitude, i), turn, tick, suite, episodes[i], key)
                    back = (turned[i, 0], -turned[i, 1], -turned[i, 2], -turned[i, 3])
                    store4(anchors, i * depth + slot, quaternion_product(fix, back))
                clock[i, 0] += every
                clock[i, 1] = slot + 1 if slot + 1 < depth else 0
            if tick == clock[i, 2] + clock[i, 4]:
                slot = clock[i, 3]
                if taken[i, slot] >= 0 and not blind:
                    store4(anchor, i, row4(anchors, i * depth + slot))
                    fix_ticks[i] = taken[i, slot]
                clock[i, 2] += every
                clock[i, 3] = slot + 1 if slot + 1 < depth else 0
            store4(measured_attitude, i, nearly_unit(quaternion_product(row4(anchor, i), row4(turned, i))))
            deviates = (0.0, 0.0, 0.0, 0.0)
            noise = suite.wheel_momentum_noise
            for j in range(wheel_momentum.shape[1]):
                if noise > 0.0 and j % 4 == 0:
                    deviates = normals(tick, episodes[i], WHEEL_NOISE + j // 4, key)
                value = reported(wheel_momentum[i, j], noise, deviates, j % 4, suite.wheel_momentum_quantum)
                measured_momentum[i, j] = value
            noise = suite.modal_displacement_noise
            for j in range(modal_displacement.shape[1]):
                if noise > 0.0 and j % 4 == 0:
                    deviates = normals(tick, episodes[i], DISPLACEMENT_NOISE + j // 4, key)
                measured_displacement[i, j] = reported(modal_displacement[i, j], noise, deviates, j % 4, 0.0)
            noise = suite.modal_rate_noise
            for j in range(modal_rate.shape[1]):
                if noise > 0.0 and j % 4 == 0:
                    deviates = normals(tick, episodes[i], MODAL_RATE_NOISE + j // 4, key)
                measured_modal_rate[i, j] = reported(modal_rate[i, j], noise, deviates, j % 4, 0.0)
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
            # Between two samples of the star tracker, the measured attitude is not that of the body.
            excess += 0.0 * (attitude[i, k] + measured_attitude[i, k] + reference_attitude[i, k])
        if not norm3(w) + excess <= largest_rate:
            diverged += 1
    return diverged
