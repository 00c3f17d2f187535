"""Compiled implicit step of a wheel, for the neighbourhood of rest, the power limit and the brake.

Friction is steep near rest. A third-order L-stable step brings a wheel to rest without limit cycles however strong its
friction is. ``resistance`` is the triple of the factors on the dry friction forward and backward, and of the brake
[N m].
"""

import math
from typing import Any

from numba import njit

from ftac_gym.dynamics.wheel_table import STIFF_GAMMA
from ftac_gym.utils.compiling import CONTRACT, inlined, merged

_GAMMA = STIFF_GAMMA
_WEIGHT_1 = -0.25 * (6.0 * _GAMMA * _GAMMA - 16.0 * _GAMMA + 1.0)
_WEIGHT_2 = 0.25 * (6.0 * _GAMMA * _GAMMA - 20.0 * _GAMMA + 5.0)
_INNER = 0.5 * (1.0 - _GAMMA)
_SECOND = 0.5 * (1.0 + _GAMMA)
_MOST_ITERATIONS = 60

_REST = 1e-12
"""Share of the momentum at which the Coulomb torque sets in, below which a wheel that friction slows down rests.

Without it the wheel would creep on into the denormal numbers, which are slow.
"""


@inlined
def friction(wheel: Any, momentum: float, factor: float) -> Any:
    """Return friction [N m] at a momentum [N m s] and its derivative [1/s]; the factor is on the dry part."""
    speed = momentum * wheel.inverse_inertia
    ratio = speed * wheel.inverse_stribeck_speed
    bell = math.exp(-ratio * ratio)
    turn = speed * wheel.inverse_coulomb_speed
    if abs(turn) < 0.005:
        # The hyperbolic tangent to the last digit, however close to rest: the solver stalls on less.
        square = turn * turn
        tangent = turn * (1.0 - square * (1.0 - 0.4 * square) / 3.0)
    else:
        # By one exponential; the magnitude keeps it from overflowing.
        decay = math.exp(-2.0 * abs(turn))
        tangent = math.copysign((1.0 - decay) / (1.0 + decay), turn)
    dry = wheel.stribeck * ratio * bell + wheel.coulomb * tangent
    rise = wheel.stribeck * wheel.inverse_stribeck_speed * bell * (1.0 - 2.0 * ratio * ratio)
    rise += wheel.coulomb * wheel.inverse_coulomb_speed * (1.0 - tangent * tangent)
    return factor * dry + wheel.viscous * speed, (factor * rise + wheel.viscous) * wheel.inverse_inertia


@inlined
def powered(wheel: Any, drive: float, momentum: float) -> float:
    """Return a motor torque within the power limit [N m] at a momentum [N m s]."""
    if abs(drive * momentum) * wheel.inverse_inertia <= wheel.power_limit:
        return drive
    return math.copysign(wheel.power_limit / (abs(momentum) * wheel.inverse_inertia), drive)


@merged
def net_torque(wheel: Any, momentum: float, drive: float, resistance: Any) -> Any:
    """Return the torque of a wheel on the body [N m] under a motor torque and resistance.

    The friction in it [N m] and its derivative [1/s] come second and third; at rest the derivative is infinite.
    """
    forward, backward, brake = resistance
    if momentum == 0.0:
        # At rest the brake opposes any torque up to its own.
        return drive - min(max(drive, -brake), brake), 0.0, math.inf
    drag, slope = friction(wheel, momentum, forward if momentum > 0.0 else backward)
    return powered(wheel, drive, momentum) + drag + math.copysign(brake, momentum), drag, slope


@merged
def implicit_momentum(wheel: Any, free: float, weight: float, drive: float, guess: float, resistance: Any) -> float:
    """Solve h + weight (drive + friction(h) + brake sign(h)) = free for the momentum h, with a guess of it.

    Friction has the sign of h, which gives the sign of the solution beforehand. A Newton iteration between bounds finds
    the solution; the interval is halved where the iteration stalls, at the bends of friction and of the power limit.
    Where friction falls with the speed there may be three solutions, and the guess decides. The search for a wheel
    that changes direction starts at rest, where friction holds the wheel if it is strong enough.
    """
    forward, backward, brake = resistance
    pushed = free - weight * drive
    if abs(pushed) <= weight * brake:
        return 0.0
    sign = math.copysign(1.0, pushed)
    factor = forward if sign > 0.0 else backward
    target, drive = sign * free - weight * brake, sign * drive
    low, high = 0.0, target + weight * abs(drive)
    x = min(max(sign * guess, low), high)
    least = math.inf
    for _ in range(_MOST_ITERATIONS):
        drag, slope = friction(wheel, x, factor)
        given = powered(wheel, drive, x)
        excess = x + weight * (given + drag) - target
        if excess > 0.0:
            high = x
        else:
            low = x
        rise = 1.0 + weight * slope
        if given != drive:
            rise -= weight * given / x
        following = x - excess / rise
        direct = low <= following <= high and abs(excess) <= 0.5 * least
        least = abs(excess)
        if not direct:
            following = 0.5 * (low + high)
        moved = abs(following - x)
        x = following
        # The error after a move is of the order of its square over the width of the bend.
        if direct and moved <= 1e-7 * high and moved * moved <= 1e-14 * high * wheel.coulomb_momentum:
            break
    return sign * x


@njit(error_model="numpy", fastmath=CONTRACT)
def stiff_step(
    array: Any,
    j: int,
    momentum: float,
    step: float,
    limited: float,
    missing: float,
    effectiveness: Any,
    bias: Any,
    resistance: Any,
) -> Any:
    """Return the momentum of wheel j after a physics step by the implicit method, and its torque before and after.

    ``limited`` is the command within its limits and ``missing`` its excess over the motor torque at the start, both in
    N m; effectiveness e and bias b are triples for the start, the middle and the end of the step.
    """
    wheel = array[j]
    e_1, e_2, e_4 = effectiveness
    b_1, b_2, b_4 = bias
    forward, backward, brake = resistance
    drive_1 = e_1 * (limited - missing) + b_1
    torque_1, drag, steepness = net_torque(wheel, momentum, drive_1, resistance)
    grip = step * _GAMMA * steepness
    slope_1, slope_2, result, drive = 0.0, 0.0, momentum, drive_1
    sign = math.copysign(1.0, momentum)
    ahead, against = max(-sign * drive_1, 0.0), max(sign * drive_1, 0.0)
    for stage in range(3):
        if stage == 0:
            time, free = _GAMMA, momentum
        elif stage == 1:
            time, free = _SECOND, momentum + step * _INNER * slope_1
        else:
            time, free = 1.0, momentum + step * (_WEIGHT_1 * slope_1 + _WEIGHT_2 * slope_2)
        # Quadratics through the three points.
        first, second, third = (1.0 - time) * (1.0 - 2.0 * time), 4.0 * time * (1.0 - time), time * (2.0 * time - 1.0)
        e = first * e_1 + second * e_2 + third * e_4
        b = first * b_1 + second * b_2 + third * b_4
        drive = e * (limited - missing * wheel.lag_left[stage]) + b
        ahead, against = max(ahead, -sign * drive), max(against, sign * drive)
        # Explicit Euler is the better guess, but overshoots where friction is steep.
        guess = result if grip > 0.3 else free - step * _GAMMA * (drive + drag)
        if guess * momentum < 0.0:
            guess = 0.0
        result = implicit_momentum(wheel, free, step * _GAMMA, drive, guess, resistance)
        slope = (result - free) / (step * _GAMMA)
        if stage == 0:
            slope_1 = slope
        else:
            slope_2 = slope
    # Friction and brake neither accelerate nor reverse a wheel, but a coarse step across the stop can.
    # Implicit Euler cannot; fine steps do not reach this branch.
    wrong = sign * result > sign * momentum + 1.1 * step * ahead
    if momentum * result < 0.0:
        returning, _ = friction(wheel, result, forward if result > 0.0 else backward)
        wrong = abs(returning) + brake > 1.1 * against
    if wrong:
        result = implicit_momentum(wheel, momentum, step, drive, momentum, resistance)
    if grip > 1e-3 and abs(result) < min(abs(momentum), _REST * wheel.coulomb_momentum):
        result = 0.0
    torque_4, _, _ = net_torque(wheel, result, drive, resistance)
    return result, torque_1, torque_4
