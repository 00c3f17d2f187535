"""Compiled preparations for faults to come, and for a flight without control of all axes to its end."""

import math
from typing import Any

from ftac_gym.task.feasible_torque import share
from ftac_gym.utils.compiling import called

FILLING = 0.9
"""Share of the momentum limits that preparations may fill."""

SETTLED_ANGLE, SETTLED_RATE = math.radians(2.0), math.radians(0.1)
"""Largest angle [rad] and rate [rad/s] in the frame of the reference from which a drift may start."""

FARTHEST = math.radians(10.0)
"""Largest change of the attitude at the start of a drift [rad]; its rate may change by ``SETTLED_RATE``."""


@called
def prepare(signals: Any, capacity: Any, axes: Any, pivot: Any, step: float, work: Any, preload: Any) -> int:
    """Choose the torques of locked wheels and the momenta before a wheel runs away, and return its step.

    A wheel that is locked to the end may hold a torque, as commanded at its onset, which balances biases of others. A
    wheel that follows no command and has a bias starts to run away with half of its impulse of the opposite sign.

    Parameters
    ----------
    signals
        (steps, m, SIGNALS) state of the wheels; the bias of a locked wheel becomes its torque.
    capacity, axes
        CAPACITY records (m,), and wheel axes (m, 3).
    pivot
        (m, m): column j is the momentum of all wheels that adds up to none in which wheel j has 1 N m s; zero if there
        is none.
    step
        Length of a step [s].
    work
        (6, m) work space.
    preload
        (m,) the momenta [N m s].
    """
    steps, wheels = signals.shape[0], signals.shape[1]
    low, high, torque = work[0], work[1], work[4]
    for j in range(wheels):
        last, since = signals[steps - 1, j], 0
        torque[j], preload[j] = 0.0, 0.0
        most = capacity[j].torque_limit * abs(last[0])
        if last[2] > 0.5:
            while since < steps and signals[since, j, 2] < 0.5:
                since += 1
            most = min(capacity[j].torque_limit, FILLING * capacity[j].momentum_limit / ((steps - since) * step))
        low[j], high[j] = last[1] - most, last[1] + most
        if last[5] > 0.0:
            low[j], high[j] = 0.0, 0.0
    share(axes, (0.0, 0.0, 0.0), low, high, torque, work[2])
    first = steps
    for j in range(wheels):
        impulse, began = 0.0, steps
        for k in range(steps):
            if signals[k, j, 2] > 0.5 and signals[steps - 1, j, 2] > 0.5:
                signals[k, j, 1] = torque[j]
            if signals[k, j, 0] == 0.0 and signals[k, j, 1] != 0.0:
                impulse, began = impulse + step * signals[k, j, 1], min(began, k)
        most = FILLING * capacity[j].momentum_limit
        wanted = min(max(0.5 * impulse, -most), most)
        if wanted != 0.0:
            first = min(first, began)
            for i in range(wheels):
                preload[i] += wanted * pivot[i, j]
    return first if first < steps else 0


@called
def misses(path: Any, window: int, step: float, goal: Any, turn: Any, drift: Any) -> int:
    """Return the number of times in the window off target, after a turn [rad] and a drift [rad/s] are taken away.

    The turn is that at the end. A time beyond the largest angle counts as all.
    """
    last, missed = path.shape[0] - 1, 0
    for k in range(window, last + 1):
        back = (last - k) * step
        angle, rate = 0.0, 0.0
        for axis in range(3):
            away = path[k, axis] - turn[axis] + back * drift[axis]
            angle += away * away
            rate += (path[k, 3 + axis] - drift[axis]) ** 2
        # In this form a motion that is no number fails.
        if not angle <= goal[2] * goal[2]:
            missed += path.shape[0]
        elif not (angle <= goal[0] * goal[0] and rate <= goal[1] * goal[1]):
            missed += 1
    return missed


@called
def uncontrolled_since(signals: Any, axes: Any) -> int:
    """Return the time from which the wheels that follow commands span no space to the end; the last one if they do."""
    k = signals.shape[0]
    while k > 0:
        xx, yy, zz, xy, xz, yz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for j in range(axes.shape[0]):
            if signals[k - 1, j, 0] != 0.0 and signals[k - 1, j, 5] == 0.0:
                a, b, c = axes[j, 0], axes[j, 1], axes[j, 2]
                xx, yy, zz = xx + a * a, yy + b * b, zz + c * c
                xy, xz, yz = xy + a * b, xz + a * c, yz + b * c
        if xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz) > 1e-4:
            break
        k -= 1
    return k


@called
def succeeds(path: Any, signals: Any, axes: Any, window: int, step: float, goal: Any) -> bool:
    """Return whether a flight is a success; its path (steps + 1, 6 + m) begins with turn [rad] and rate [rad/s].

    Wheels may span no space to the end. Then a drift may pass the target in the window: where the flight is settled
    before, it can have any small attitude and rate.
    """
    last = path.shape[0] - 1
    allowed = goal[3] * (last + 1 - window) + 1e-9
    nothing = (0.0, 0.0, 0.0)
    if misses(path, window, step, goal, nothing, nothing) <= allowed:
        return True
    begin = uncontrolled_since(signals, axes)
    if begin > window:
        return False
    angle, rate = 0.0, 0.0
    for axis in range(3):
        angle, rate = angle + path[begin, axis] ** 2, rate + path[begin, 3 + axis] ** 2
    if not (angle <= SETTLED_ANGLE**2 and rate <= SETTLED_RATE**2):
        return False
    turn, drift, size = [0.0, 0.0, 0.0], [0.0, 0.0, 0.0], 0.0
    for axis in range(3):
        least, most = math.inf, -math.inf
        for k in range(window, last + 1):
            least, most = min(least, path[k, 3 + axis]), max(most, path[k, 3 + axis])
        drift[axis] = 0.5 * (least + most)
        least, most = math.inf, -math.inf
        for k in range(window, last + 1):
            away = path[k, axis] + (last - k) * step * drift[axis]
            least, most = min(least, away), max(most, away)
        turn[axis] = 0.5 * (least + most)
        if not abs(drift[axis]) <= SETTLED_RATE:
            return False
        size += (turn[axis] - (last - begin) * step * drift[axis]) ** 2
    if not size <= FARTHEST**2:
        return False
    return misses(path, window, step, goal, (turn[0], turn[1], turn[2]), (drift[0], drift[1], drift[2])) <= allowed
