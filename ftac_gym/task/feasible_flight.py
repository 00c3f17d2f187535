"""Compiled flights with all faults known beforehand, on a coarse grid of times: each earns an episode its label."""

import math
from typing import Any

import numpy as np

from ftac_gym.faults import signals as fault_signals
from ftac_gym.task import feasible_foresight, feasible_path, feasible_torque
from ftac_gym.task.feasible_foresight import prepare, succeeds
from ftac_gym.task.feasible_path import about_momentum, in_body, rotation_vector
from ftac_gym.task.feasible_torque import (
    SIGNALS,
    add3,
    bounds,
    cross3,
    dot3,
    inverse_symmetric,
    load_signals,
    multiple,
    quaternion_product,
    row3,
    scaled3,
    share,
    symmetric_times,
)
from ftac_gym.utils import algebra
from ftac_gym.utils.compiling import called, entry_point

PLAN = np.dtype([(name, "f8") for name in ("braking", "gyroscopic", "long_way", "foresight", "tilt")])
"""One way to turn: the shares of the torque that braking uses and that the gyroscopic torque may take. ``long_way`` is
1.0 for the long way round, ``foresight`` 1.0 for wheels that are prepared for faults to come."""

UNWINDING = 0.05
"""Rate at which wheels give up momentum that no torque needs [1/s]."""

_TIP = 0.95
"""Cosine of the angle by which the axis of the error may tip until braking is planned anew."""

_PLANS = 8
"""Most plans of braking in a flight."""

_NOTHING = (0.0, 0.0, 0.0)


@called
def external_torque(steady: Any, harmonics: Any, time: float) -> Any:
    """Return the disturbance at a time [N m], before any scaling with the rate."""
    torque = (steady.constant[0], steady.constant[1], steady.constant[2])
    for index in range(harmonics.shape[0]):
        harmonic = harmonics[index]
        sine, cosine = math.sin(harmonic.frequency * time), math.cos(harmonic.frequency * time)
        torque = add3(torque, sine, (harmonic.sine[0], harmonic.sine[1], harmonic.sine[2]))
        torque = add3(torque, cosine, (harmonic.cosine[0], harmonic.cosine[1], harmonic.cosine[2]))
    return torque


@called
def plan_braking(
    k: int,
    along: Any,
    part: float,
    normals: Any,
    across: Any,
    signals: Any,
    capacity: Any,
    momentum: Any,
    step: float,
    work: Any,
    braking: Any,
) -> None:
    """Write what braking takes away from the closing speed until each time from step k on [rad/s], and its sums.

    Parameters
    ----------
    along
        Torque for one rad/s^2 against the closing speed [kg m^2].
    part
        Share of the torque that braking uses.
    braking
        (2, steps + 1) the result.
    """  # fmt: skip
    speeds, ways = braking[0], braking[1]
    speeds[k], ways[k] = 0.0, 0.0
    for m in range(k, signals.shape[0]):
        bounds(signals[m], capacity, momentum, step, False, work[2], work[3])
        most = part * multiple(normals, across, _NOTHING, along, work[2], work[3], False)
        speeds[m + 1] = speeds[m] + step * min(most, 1e6)
        ways[m + 1] = ways[m] + 0.5 * (speeds[m] + speeds[m + 1])


@called
def safe_speed(k: int, step: float, angle: float, closing: float, braking: Any) -> float:
    """Return the largest closing speed at the end of step k [rad/s] from which braking ends within the angle [rad]."""
    speeds, ways, after = braking[0], braking[1], k + 1
    bottom, top = after, speeds.shape[0] - 1
    used = 0.0
    # The last time at which braking with all its torque may end.
    while bottom <= top:
        m = (bottom + top) // 2
        way = (m - after + 0.5) * speeds[m] - (ways[m] - ways[after]) - 0.5 * speeds[after]
        way = step * (way + 0.5 * closing)
        if way <= angle:
            bottom, used = m + 1, way
        else:
            top = m - 1
    last = bottom - 1
    if last < after:
        return 0.0
    allowed = speeds[last] - speeds[after]
    if last + 1 < speeds.shape[0]:
        # A part of the torque of the step after.
        further = (angle - used) / (step * (last - after + 1.0))
        allowed += min(speeds[last + 1] - speeds[last], further)
    return float(allowed)


@called
def flight(
    attitude: Any,
    rate: Any,
    stored: Any,
    aim: Any,
    rates: Any,
    points: Any,
    inertia: Any,
    steady: Any,
    harmonics: Any,
    signals: Any,
    capacity: Any,
    axes: Any,
    normals: Any,
    across: Any,
    coupled: bool,
    step: float,
    window: int,
    goal: Any,
    plan: Any,
    pivot: Any,
    work: Any,
    braking: Any,
    path: Any,
) -> bool:
    """Fly one episode with all faults known; True if it is a success.

    The parameters are those of :func:`flown`, of one episode; ``signals`` are those of :func:`.load_signals`.
    """  # fmt: skip
    low, high, torque, momentum, preload = work[0], work[1], work[4], work[5], work[6]
    wheels, steps = axes.shape[0], signals.shape[0]
    for j in range(wheels):
        momentum[j] = stored[j]
    prepared = prepare(signals, capacity, axes, pivot, step, work, preload) if plan.foresight > 0.5 else 0
    body = inertia.constant
    tensor = (body[0, 0], body[1, 1], body[2, 2], body[0, 1], body[0, 2], body[1, 2])
    inverse = inverse_symmetric(tensor)
    moving = rates.shape[0] > 0
    # Attitude and rate in the frame of the reference, body axes.
    q = (attitude[0], attitude[1], attitude[2], attitude[3])
    q = quaternion_product((aim[0], -aim[1], -aim[2], -aim[3]), q)
    w = (rate[0], rate[1], rate[2])
    if moving:
        w = add3(w, -1.0, in_body(q, row3(rates, 0)))
    long_way = plan.long_way > 0.5
    point, aimed, plans = 0, _NOTHING, 0
    for k in range(steps + 1):
        time = k * step
        while point + 1 < points.shape[0] and points[point + 1].time <= time + 1e-9:
            old, new = points[point].attitude, points[point + 1].attitude
            change = quaternion_product((new[0], -new[1], -new[2], -new[3]), (old[0], old[1], old[2], old[3]))
            q, aimed, point = quaternion_product(change, q), _NOTHING, point + 1
        turn = rotation_vector(q)
        path[k, 0], path[k, 1], path[k, 2] = turn
        path[k, 3], path[k, 4], path[k, 5] = w
        for j in range(wheels):
            path[k, 6 + j] = momentum[j]
        if k == steps:
            break
        bounds(signals[k], capacity, momentum, step, True, low, high)
        total = _NOTHING
        if coupled:
            for j in range(wheels):
                total = add3(total, momentum[j], row3(axes, j))
        if plan.tilt > 0.5:
            turn = about_momentum(q, total)
        angle = math.sqrt(dot3(turn, turn))
        axis = scaled3(1.0 / angle, turn) if angle > 1e-12 else _NOTHING
        long_way = long_way and angle > 0.5 * math.pi
        if long_way:
            angle, axis = 2.0 * math.pi - angle, scaled3(-1.0, axis)

        # The rate at the end of the step: as fast as braking and the gyroscopic torque allow.
        if plans == 0 or (angle > 1e-6 and dot3(axis, aimed) < _TIP and plans < _PLANS):
            aimed, plans = axis, plans + 1
            along = symmetric_times(tensor, axis)
            plan_braking(k, along, plan.braking, normals, across, signals, capacity, momentum, step, work, braking)
        allowed = safe_speed(k, step, angle, -dot3(axis, w), braking)
        precession = cross3(total, axis)
        fits = multiple(normals, across, _NOTHING, precession, low, high, True)
        next_rate = scaled3(-min(allowed, plan.gyroscopic * fits), axis)

        # The torque that the motion needs in the middle of the step, and that for the change of the rate.
        follow, ahead = _NOTHING, _NOTHING
        if moving:
            now, then = row3(rates, k), row3(rates, k + 1)
            follow = in_body(q, scaled3(0.5, add3(now, 1.0, then)))
            ahead = in_body(q, scaled3(1.0 / step, add3(then, -1.0, now)))
        middle = add3(add3(follow, 0.5, w), 0.5, next_rate)
        external = external_torque(steady, harmonics, time + 0.5 * step)
        if steady.rate_scaled > 0.5:
            external = scaled3(dot3(middle, middle) + steady.rate_offset, external)
        turning = symmetric_times(tensor, add3(ahead, -1.0, cross3(w, follow)))
        push = symmetric_times(tensor, scaled3(1.0 / step, add3(next_rate, -1.0, w)))
        own = symmetric_times(tensor, middle)
        base = add3(add3(cross3(middle, add3(total, 1.0, own)), -1.0, external), 1.0, turning)
        # Again with the momentum of the wheels in the middle of the step, without which the whole would not be kept.
        total = add3(total, -0.5 * step, add3(base, 1.0, push))
        base = add3(add3(cross3(middle, add3(total, 1.0, own)), -1.0, external), 1.0, turning)
        part = min(1.0, multiple(normals, across, base, push, low, high, True))
        for j in range(wheels):
            torque[j] = UNWINDING * momentum[j]
            if k < prepared:
                torque[j] = max(UNWINDING, 2.0 / ((prepared - k) * step)) * (momentum[j] - preload[j])
        given = share(axes, add3(base, part, push), low, high, torque, work[2])

        reached = add3(w, step, symmetric_times(inverse, add3(given, -1.0, base)))
        half = scaled3(0.25 * step, add3(w, 1.0, reached))
        size = math.sqrt(dot3(half, half))
        ratio = math.sin(size) / size if size > 1e-9 else 1.0
        q = quaternion_product(q, (math.cos(size), ratio * half[0], ratio * half[1], ratio * half[2]))
        w = reached
        for j in range(wheels):
            momentum[j] -= step * torque[j]
    return succeeds(path, signals, axes, window, step, goal)


@entry_point(algebra, fault_signals, feasible_torque, feasible_foresight, feasible_path)
def flown(
    attitude: Any,
    rate: Any,
    stored: Any,
    aims: Any,
    rates: Any,
    points: Any,
    inertia: Any,
    steady: Any,
    harmonics: Any,
    faults: Any,
    switches: Any,
    capacity: Any,
    axes: Any,
    normals: Any,
    across: Any,
    pivot: Any,
    coupled: bool,
    step: float,
    steps: int,
    window: int,
    goal: Any,
    plans: Any,
    path: Any,
    out: Any,
) -> None:
    """Write for each of N episodes the number of the first plan that flies it with success, or -1.

    Parameters
    ----------
    attitude, rate, stored
        (N, 4), (N, 3) [rad/s] and (N, m) [N m s] attitude, rate and momentum of the wheels at the start.
    points, inertia, steady, harmonics, faults, switches
        Tables of the episodes; ``points`` are the set points, ``steady`` the DISTURBANCE records.
    aims
        (N, 4) attitude of the reference at the start.
    rates
        (N, steps + 1, 3) rate of a moving reference at each time [rad/s], its own axes; (N, 0, 3) for set points.
    capacity
        CAPACITY records (m,).
    axes, normals, across
        (m, 3) true wheel axes, (facets, 3) normals of their envelope, (facets, m) products of both.
    pivot
        (m, m) momenta that add up to none, see :func:`.prepare`.
    coupled
        True if the stored momentum acts on the body.
    step, steps, window
        Step [s], number of steps, and the first time of the window of success.
    goal
        Angle [rad] and rate [rad/s] on target, largest angle in the window [rad], share of its times off target.
    plans
        PLAN records (P,).
    path
        (steps + 1, 6 + m) the last flight: turn [rad] and rate [rad/s] in the frame of the reference, body axes, and
        momenta of the wheels [N m s].
    out
        (N,) the result.
    """  # fmt: skip
    wheels = axes.shape[0]
    signals, work = np.empty((steps, wheels, SIGNALS)), np.empty((7, wheels))
    braking = np.empty((2, steps + 1))
    for i in range(attitude.shape[0]):
        load_signals(i, faults, switches, step, signals)
        out[i] = -1
        for number in range(plans.shape[0]):
            if flight(
                attitude[i], rate[i], stored[i], aims[i], rates[i], points[i], inertia[i], steady[i], harmonics[i],
                signals, capacity, axes, normals, across, coupled, step, window, goal, plans[number], pivot, work,
                braking, path,
            ):  # fmt: skip
                out[i] = number
                break
