"""The compiled plant: wheels with faults, then the body, one craft after the other.

Everything that one compiled entry point calls lives in this file: Numba's on-disk cache watches only the file of the
entry point, and a kernel must never run with a stale piece of itself.

Wheels do not feel the body (their momentum changes by the torque alone), so each physics step first asks every wheel
for its torque at the three stage times of RK4 and then integrates the body with the sums. Wheel friction and lag
belong in :func:`wheel_torque`; flexible modes belong beside :func:`angular_acceleration`.

Faults switch on and off only between physics steps: within a step the torque is smooth, and RK4 keeps its order.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit

# Two times closer than this are the same time: it absorbs rounding in t = step * period [s].
TIME_TOLERANCE = 1e-9

# Fused multiply-add only: it is as exact as separate operations, and no reordering is allowed.
CONTRACT = {"contract"}


@njit(cache=True, inline="always", error_model="numpy", fastmath=CONTRACT)
def wheel_torque(faults: Any, command: float, last: float, time: float, step: float) -> Any:
    """Torque of one wheel on the body at the start, the middle and the end of a physics step [N m].

    ``faults`` is the wheel's layers of FAULT records and ``command`` is within the torque limit. The set of acting
    faults is decided at the start of the step. A locked wheel repeats ``last``, the torque it applied at the end of the
    step before.
    """
    start, middle, end = 1.0, 1.0, 1.0
    bias_start, bias_middle, bias_end = 0.0, 0.0, 0.0
    locked = False
    for layer in range(faults.shape[0]):
        fault = faults[layer]
        since = time - fault.onset
        if since < -TIME_TOLERANCE or time >= fault.recovery - TIME_TOLERANCE:
            continue
        since = max(since, 0.0)
        if fault.period > 0.0:
            in_period = since - math.floor((since + TIME_TOLERANCE) / fault.period) * fault.period
            if in_period >= fault.on_time - TIME_TOLERANCE:
                continue
        locked = locked or fault.locked > 0.5
        if fault.effectiveness_amplitude == 0.0:
            start *= fault.effectiveness
            middle *= fault.effectiveness
            end *= fault.effectiveness
        else:
            start *= effectiveness_at(fault, time)
            middle *= effectiveness_at(fault, time + 0.5 * step)
            end *= effectiveness_at(fault, time + step)
        if fault.bias_amplitude == 0.0 and fault.bias_slope == 0.0:
            bias_start += fault.bias
            bias_middle += fault.bias
            bias_end += fault.bias
        else:
            bias_start += bias_at(fault, since)
            bias_middle += bias_at(fault, since + 0.5 * step)
            bias_end += bias_at(fault, since + step)
    if locked:
        return last, last, last
    return start * command + bias_start, middle * command + bias_middle, end * command + bias_end


@njit(cache=True, inline="always", error_model="numpy", fastmath=CONTRACT)
def constant_torque(faults: Any, command: float, last: float, begin: float, end: float) -> Any:
    """Whether nothing changes for a wheel between two times [s], and the constant torque that it then gives [N m]."""
    effectiveness, bias, locked = 1.0, 0.0, False
    for layer in range(faults.shape[0]):
        fault = faults[layer]
        if fault.onset >= end or fault.recovery <= begin:
            continue
        switches = fault.onset > begin or fault.recovery < end or fault.period > 0.0
        if switches or fault.effectiveness_amplitude != 0.0 or fault.bias_amplitude != 0.0 or fault.bias_slope != 0.0:
            return False, 0.0
        effectiveness *= fault.effectiveness
        bias += fault.bias
        locked = locked or fault.locked > 0.5
    return True, last if locked else effectiveness * command + bias


@njit(cache=True, inline="always", error_model="numpy", fastmath=CONTRACT)
def effectiveness_at(fault: Any, time: float) -> float:
    """Effectiveness of an acting fault at a time of the episode [s]."""
    angle = fault.effectiveness_frequency * time + fault.effectiveness_phase
    return fault.effectiveness + fault.effectiveness_amplitude * math.sin(angle)


@njit(cache=True, inline="always", error_model="numpy", fastmath=CONTRACT)
def bias_at(fault: Any, since: float) -> float:
    """Bias torque [N m] of an acting fault, ``since`` seconds after its onset."""
    oscillation = fault.bias_amplitude * math.sin(fault.bias_frequency * since + fault.bias_phase)
    if fault.bias_exponent != 0.0:
        oscillation *= since**fault.bias_exponent
    return fault.bias + fault.bias_slope * since + oscillation


@njit(cache=True, inline="always", error_model="numpy", fastmath=CONTRACT)
def fill_disturbance(torque: Any, steady: Any, harmonics: Any, time: float, step: float) -> None:
    """Write the external torque at every half step, (2 * substeps + 1, 3) [N m], before any scaling with the rate.

    The sine and cosine of a harmonic advance by a fixed rotation, which costs four multiplications instead of two
    transcendental functions; both restart from exact values at every call.
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


@njit(cache=True, inline="always", error_model="numpy", fastmath=CONTRACT)
def inertia_at(record: Any, varying: bool, rate_torque: bool, time: float) -> Any:
    """Inertia (xx, yy, zz, xy, xz, yz), its inverse in the same order, and J' (xx, yy, zz) if it makes a torque."""
    xx, yy, zz = record.constant[0, 0], record.constant[1, 1], record.constant[2, 2]
    xy, xz, yz = record.constant[0, 1], record.constant[0, 2], record.constant[1, 2]
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


@njit(cache=True, inline="always", error_model="numpy", fastmath=CONTRACT)
def angular_acceleration(w: Any, stored: Any, wheel: Any, external: Any, body: Any, steady: Any) -> Any:
    """Euler's equation: J w' = -w x (J w + stored) + wheel + external - J' w, all in body axes.

    ``external`` is multiplied by (|w|^2 + c) where the disturbance asks for it.
    """
    inertia, inverse, change = body
    momentum_x = inertia[0] * w[0] + inertia[3] * w[1] + inertia[4] * w[2] + stored[0]
    momentum_y = inertia[3] * w[0] + inertia[1] * w[1] + inertia[5] * w[2] + stored[1]
    momentum_z = inertia[4] * w[0] + inertia[5] * w[1] + inertia[2] * w[2] + stored[2]
    scale = 1.0
    if steady.rate_scaled > 0.5:
        scale = w[0] * w[0] + w[1] * w[1] + w[2] * w[2] + steady.rate_offset
    x = wheel[0] + scale * external[0] - (w[1] * momentum_z - w[2] * momentum_y) - change[0] * w[0]
    y = wheel[1] + scale * external[1] - (w[2] * momentum_x - w[0] * momentum_z) - change[1] * w[1]
    z = wheel[2] + scale * external[2] - (w[0] * momentum_y - w[1] * momentum_x) - change[2] * w[2]
    return (
        inverse[0] * x + inverse[3] * y + inverse[4] * z,
        inverse[3] * x + inverse[1] * y + inverse[5] * z,
        inverse[4] * x + inverse[5] * y + inverse[2] * z,
    )


@njit(cache=True, inline="always", error_model="numpy", fastmath=CONTRACT)
def twice_attitude_rate(q: Any, w: Any) -> Any:
    """Quaternion kinematics 2 q' = q (x) [0, w]."""
    return (
        -q[1] * w[0] - q[2] * w[1] - q[3] * w[2],
        q[0] * w[0] + q[2] * w[2] - q[3] * w[1],
        q[0] * w[1] + q[3] * w[0] - q[1] * w[2],
        q[0] * w[2] + q[1] * w[1] - q[2] * w[0],
    )


@njit(cache=True, inline="always", error_model="numpy", fastmath=CONTRACT)
def add3(a: Any, factor: float, b: Any) -> Any:
    """Return a + factor b for triples."""
    return a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]


@njit(cache=True, inline="always", error_model="numpy", fastmath=CONTRACT)
def add4(a: Any, factor: float, b: Any) -> Any:
    """Return a + factor b for quadruples."""
    return a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2], a[3] + factor * b[3]


@njit(cache=True, nogil=True, error_model="numpy", fastmath=CONTRACT)
def advance(
    start: int,
    stop: int,
    attitude: Any,
    rate: Any,
    wheel_momentum: Any,
    last_torque: Any,
    ticks: Any,
    command: Any,
    axes: Any,
    torque_limit: Any,
    momentum_limit: Any,
    coupled: bool,
    inertia: Any,
    rate_torque: bool,
    faults: Any,
    steady: Any,
    harmonics: Any,
    step: float,
    substeps: int,
) -> None:
    """Advance craft ``start`` to ``stop - 1`` by one control period, in place, by classical RK4.

    Arrays (N craft, m wheels): ``attitude`` (N, 4), ``rate`` (N, 3) [rad/s], ``wheel_momentum`` and ``last_torque``
    (N, m) [N m s, N m], ``ticks`` (N,) control periods since the start, ``command`` (N, m) [N m], ``axes`` (3, m),
    limits (m,), ``inertia`` INERTIA (N,), ``faults`` FAULT (N, m, layers), ``steady`` DISTURBANCE (N,), ``harmonics``
    HARMONIC (N, K); ``step`` is the physics step [s], of which a control period has ``substeps``.

    A wheel that would pass its momentum limit within a step gives just the share of its torque that takes it there.
    """
    wheels = axes.shape[1]
    external = np.empty((2 * substeps + 1, 3))
    actuation = np.empty((substeps, 3, 3))
    period = step * substeps
    for i in range(start, stop):
        begin = ticks[i] * period
        fill_disturbance(external, steady[i], harmonics[i], begin, step)
        stored = (0.0, 0.0, 0.0)
        total = (0.0, 0.0, 0.0)
        actuation[:] = 0.0
        for j in range(wheels):
            axis = (axes[0, j], axes[1, j], axes[2, j])
            momentum = wheel_momentum[i, j]
            if coupled:
                stored = add3(stored, momentum, axis)
            limited = min(max(command[i, j], -torque_limit[j]), torque_limit[j])
            constant, torque = constant_torque(faults[i, j], limited, last_torque[i, j], begin, begin + period)
            reached = momentum - period * torque
            if constant and abs(reached) <= momentum_limit[j]:
                total = add3(total, torque, axis)
                wheel_momentum[i, j] = reached
                last_torque[i, j] = torque
                continue
            last = last_torque[i, j]
            for substep in range(substeps):
                torque_1, torque_2, torque_4 = wheel_torque(faults[i, j], limited, last, begin + substep * step, step)
                reached = momentum - step / 6.0 * (torque_1 + 4.0 * torque_2 + torque_4)
                inside = min(max(reached, -momentum_limit[j]), momentum_limit[j])
                if inside != reached:
                    # At most 1, and 0 for a wheel that stands at its limit and is pushed further.
                    share = (inside - momentum) / (reached - momentum)
                    torque_1, torque_2, torque_4 = share * torque_1, share * torque_2, share * torque_4
                momentum, last = inside, torque_4
                for k in range(3):
                    actuation[substep, 0, k] += torque_1 * axis[k]
                    actuation[substep, 1, k] += torque_2 * axis[k]
                    actuation[substep, 2, k] += torque_4 * axis[k]
            wheel_momentum[i, j] = momentum
            last_torque[i, j] = last

        q = (attitude[i, 0], attitude[i, 1], attitude[i, 2], attitude[i, 3])
        w = (rate[i, 0], rate[i, 1], rate[i, 2])
        amplitude = inertia[i].amplitude
        varying = amplitude[0] != 0.0 or amplitude[1] != 0.0 or amplitude[2] != 0.0
        body_1 = inertia_at(inertia[i], varying, rate_torque, begin)
        body_2, body_4 = body_1, body_1
        for substep in range(substeps):
            if varying:
                time = begin + substep * step
                body_1 = inertia_at(inertia[i], varying, rate_torque, time)
                body_2 = inertia_at(inertia[i], varying, rate_torque, time + 0.5 * step)
                body_4 = inertia_at(inertia[i], varying, rate_torque, time + step)
            external_1, external_2, external_4 = (
                external[2 * substep],
                external[2 * substep + 1],
                external[2 * substep + 2],
            )
            wheel_1 = add3(total, 1.0, actuation[substep, 0])
            wheel_2 = add3(total, 1.0, actuation[substep, 1])
            wheel_4 = add3(total, 1.0, actuation[substep, 2])
            stored_2, stored_3, stored_4 = stored, stored, stored
            if coupled:
                stored_2 = add3(stored, -0.5 * step, wheel_1)
                stored_3 = add3(stored, -0.5 * step, wheel_2)
                stored_4 = add3(stored, -step, wheel_2)

            turn_1 = twice_attitude_rate(q, w)
            spin_1 = angular_acceleration(w, stored, wheel_1, external_1, body_1, steady[i])
            q_2, w_2 = add4(q, 0.25 * step, turn_1), add3(w, 0.5 * step, spin_1)
            turn_2 = twice_attitude_rate(q_2, w_2)
            spin_2 = angular_acceleration(w_2, stored_2, wheel_2, external_2, body_2, steady[i])
            q_3, w_3 = add4(q, 0.25 * step, turn_2), add3(w, 0.5 * step, spin_2)
            turn_3 = twice_attitude_rate(q_3, w_3)
            spin_3 = angular_acceleration(w_3, stored_3, wheel_2, external_2, body_2, steady[i])
            q_4, w_4 = add4(q, 0.5 * step, turn_3), add3(w, step, spin_3)
            turn_4 = twice_attitude_rate(q_4, w_4)
            spin_4 = angular_acceleration(w_4, stored_4, wheel_4, external_4, body_4, steady[i])
            q = add4(q, step / 12.0, add4(add4(turn_1, 1.0, turn_4), 2.0, add4(turn_2, 1.0, turn_3)))
            w = add3(w, step / 6.0, add3(add3(spin_1, 1.0, spin_4), 2.0, add3(spin_2, 1.0, spin_3)))
            if coupled:
                stored = add3(stored, -step / 6.0, add3(add3(wheel_1, 1.0, wheel_4), 4.0, wheel_2))
        # RK4 keeps the norm to (rate * step)^6 a step; once a period suffices to keep it at rounding error.
        norm = 1.0 / math.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
        attitude[i, 0], attitude[i, 1] = norm * q[0], norm * q[1]
        attitude[i, 2], attitude[i, 3] = norm * q[2], norm * q[3]
        rate[i, 0], rate[i, 1], rate[i, 2] = w
        ticks[i] += 1
