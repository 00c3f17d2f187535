"""Compiled wheels: from a command, the faults and the state of a wheel to its torque on the body.

A wheel has two states, the motor torque m and the momentum h. Over one physics step, with u the command within its
limits, T the lag, e(t) and b(t) effectiveness and bias, and T_f friction::

    T m' = u - m,    h' = -(e m + b + T_f(h / I)).

Away from rest friction is Coulomb plus viscous, and the solution is written down; near rest, where it is steep, or
where the power limit or a brake acts, a third-order L-stable implicit step takes over, so that a wheel comes to rest
without limit cycles however strong its friction is. Either way the torques handed to the body at the stages of its
Runge-Kutta step have exactly the impulse that the wheel lost: total momentum is conserved to rounding.
"""

from __future__ import annotations

import math
from typing import Any

from numba import njit

from ftac_gym.dynamics.fault_signals import constant_signals, step_signals
from ftac_gym.dynamics.wheel_table import STIFF_GAMMA
from ftac_gym.utils.compiling import CONTRACT, inlined

_GAMMA = STIFF_GAMMA
_WEIGHT_1 = -0.25 * (6.0 * _GAMMA * _GAMMA - 16.0 * _GAMMA + 1.0)
_WEIGHT_2 = 0.25 * (6.0 * _GAMMA * _GAMMA - 20.0 * _GAMMA + 5.0)
_INNER = 0.5 * (1.0 - _GAMMA)
_SECOND = 0.5 * (1.0 + _GAMMA)
_MOST_ITERATIONS = 60

_REST = 1e-12
"""A wheel that friction slows down rests below this share of the momentum at which the Coulomb torque sets in;
otherwise it would creep on for ever, into the denormal numbers, which are slow."""


@inlined
def within_limits(wheel: Any, command: float) -> float:
    """Return a command after torque limit and dead-band [N m]."""
    limited = min(max(command, -wheel.torque_limit), wheel.torque_limit)
    return limited if abs(limited) >= wheel.dead_band else 0.0


@inlined
def friction(wheel: Any, momentum: float, factor: float) -> Any:
    """Return friction [N m] at a momentum [N m s] and its derivative [1/s]; the factor is on the dry part."""
    speed = momentum * wheel.inverse_inertia
    ratio = speed * wheel.inverse_stribeck_speed
    bell = math.exp(-ratio * ratio)
    turn = speed * wheel.inverse_coulomb_speed
    if abs(turn) < 0.005:
        # The hyperbolic tangent to the last digit however close to rest: the solver stalls on less.
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
    """Return what the power limit leaves of a motor torque [N m] at a momentum [N m s]."""
    if abs(drive * momentum) * wheel.inverse_inertia <= wheel.power_limit:
        return drive
    return math.copysign(wheel.power_limit / (abs(momentum) * wheel.inverse_inertia), drive)


@inlined
def net_torque(wheel: Any, momentum: float, drive: float, forward: float, backward: float, brake: float) -> Any:
    """Return the torque of a wheel on the body [N m] under a motor torque, friction and a brake.

    The friction in it [N m] and its derivative [1/s] come second and third; at rest the latter is not worked out.
    """
    if momentum == 0.0:
        # The brake holds what it can.
        return drive - min(max(drive, -brake), brake), 0.0, math.inf
    drag, slope = friction(wheel, momentum, forward if momentum > 0.0 else backward)
    return powered(wheel, drive, momentum) + drag + math.copysign(brake, momentum), drag, slope


@inlined
def implicit_momentum(
    wheel: Any, free: float, weight: float, drive: float, guess: float, forward: float, backward: float, brake: float
) -> float:
    """Solve h + weight (drive + friction(h) + brake sign(h)) = free for the momentum h, with a guess of it.

    Friction has the sign of h, so that the sign of the solution is known beforehand, and a Newton iteration that is
    kept between bounds finds it; where it makes no headway, round the bends of friction and of the power limit, the
    bounds are halved. Where friction falls with the speed there may be three solutions, and the guess decides; a wheel
    that turns round is sought from rest, where friction catches it if it can.
    """
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
        # What is left after a move is of the order of its square over the width of the bend.
        if direct and moved <= 1e-7 * high and moved * moved <= 1e-14 * high * wheel.coulomb_momentum:
            break
    return sign * x


@njit(error_model="numpy", fastmath=CONTRACT)
def stiff_step(
    array: Any,
    j: int,
    momentum: float,
    step: float,
    wanted: float,
    missing: float,
    e_1: float,
    e_2: float,
    e_4: float,
    b_1: float,
    b_2: float,
    b_4: float,
    forward: float,
    backward: float,
    brake: float,
) -> Any:
    """Return the momentum of wheel j after a physics step by the implicit method, and its torque before and after.

    ``wanted`` is the command within its limits and ``missing`` what the motor lacks of it at the start, both in N m;
    effectiveness e and bias b are those at the start, the middle and the end of the step.
    """
    wheel = array[j]
    drive_1 = e_1 * (wanted - missing) + b_1
    torque_1, drag, steepness = net_torque(wheel, momentum, drive_1, forward, backward, brake)
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
        drive = e * (wanted - missing * wheel.lag_left[stage]) + b
        ahead, against = max(ahead, -sign * drive), max(against, sign * drive)
        # Explicit Euler is the better guess, but must not take a wheel out of the grip of its friction.
        guess = result if grip > 0.3 else free - step * _GAMMA * (drive + drag)
        if guess * momentum < 0.0:
            guess = 0.0
        result = implicit_momentum(wheel, free, step * _GAMMA, drive, guess, forward, backward, brake)
        slope = (result - free) / (step * _GAMMA)
        if stage == 0:
            slope_1 = slope
        else:
            slope_2 = slope
    # Friction and brake neither speed a wheel up nor turn it round, but a step too coarse for them can: extrapolating
    # from stages before and after the wheel stopped. Implicit Euler cannot, and steps that are fine do not come here.
    wrong = sign * result > sign * momentum + 1.1 * step * ahead
    if momentum * result < 0.0:
        returning, _ = friction(wheel, result, forward if result > 0.0 else backward)
        wrong = abs(returning) + brake > 1.1 * against
    if wrong:
        result = implicit_momentum(wheel, momentum, step, drive, momentum, forward, backward, brake)
    if grip > 1e-3 and abs(result) < min(abs(momentum), _REST * wheel.coulomb_momentum):
        result = 0.0
    torque_4, _, _ = net_torque(wheel, result, drive, forward, backward, brake)
    return result, torque_1, torque_4


@inlined
def turn_wheel(
    array: Any,
    faults: Any,
    switches: Any,
    i: int,
    j: int,
    command: float,
    past: Any,
    momentum: float,
    motor: float,
    last: float,
    begin: float,
    step: float,
    substeps: int,
    actuation: Any,
) -> Any:
    """Turn wheel j of craft i through a control period, physics step by physics step.

    Parameters
    ----------
    array, faults, switches
        WHEEL records (m,), FAULT records (N, m, layers), switching times (N, chains, FLIPS).
    command, past
        Command of this period [N m], and those before it (N, D, m), latest first.
    momentum, motor, last
        State: momentum [N m s], motor torque [N m], torque on the body at the end of the step before [N m].
    begin, step, substeps
        Start of the period and physics step [s], and how many of them the period has.
    actuation
        (substeps, 9): the torque of the wheel [N m], body axes, at the start, the middle and the end of each step is
        added to it.

    Returns
    -------
    Momentum, motor torque and last torque at the end.
    """
    wheel = array[j]
    axis_x, axis_y, axis_z = wheel.axis[0], wheel.axis[1], wheel.axis[2]
    limit, power_limit, inverse_inertia = wheel.momentum_limit, wheel.power_limit, wheel.inverse_inertia
    keep, edge, lag_left, coulomb = wheel.keep, wheel.linear_momentum, wheel.lag_left[2], wheel.coulomb
    decay, per_step = wheel.viscous * inverse_inertia, 1.0 / step
    push_1, push_2, push_4 = wheel.forcing[0], wheel.forcing[1], wheel.forcing[2]
    push = push_1 + push_2 + push_4
    constant, locked, delay, e_1, b_1, forward, backward, brake = constant_signals(
        faults, i, j, begin, begin + substeps * step
    )
    e_2, e_4, b_2, b_4 = e_1, e_1, b_1, b_1
    wanted, missing, pushed, lack, full_1, full_4 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    calm = False
    for substep in range(substeps):
        if not constant:
            time = begin + substep * step
            locked, delay, e_1, e_2, e_4, b_1, b_2, b_4, forward, backward, brake = step_signals(
                faults, switches, i, j, time, step
            )
        if substep == 0 or not constant:
            wanted = within_limits(wheel, command if delay == 0 else past[i, delay - 1, j])
            missing = wanted - motor if lag_left > 0.0 else 0.0
            full_1, full_2, full_4 = e_1 * wanted + b_1, e_2 * wanted + b_2, e_4 * wanted + b_4
            pushed = push_1 * full_1 + push_2 * full_2 + push_4 * full_4
            lack = wheel.lag_forcing[0] * e_1 + wheel.lag_forcing[1] * e_2 + wheel.lag_forcing[2] * e_4
        if substep == 0 and constant:
            # Calm: nothing that the closed form leaves out can happen in this period, so that nothing need be checked.
            largest = abs(full_1) + abs(e_1 * missing)
            drag = coulomb * max(forward, backward) + decay * abs(momentum)
            travel = substeps * step * (largest + drag)
            farthest, nearest = abs(momentum) + travel, abs(momentum) - travel
            calm = not locked and brake == 0.0 and (edge < 0.0 or nearest > edge) and farthest < limit
            calm = calm and largest * farthest * inverse_inertia <= power_limit
        missing_4 = missing * lag_left
        # The solution as if friction were Coulomb and viscous and nothing else acted.
        dry = math.copysign(coulomb, momentum) * (forward if momentum > 0.0 else backward)
        reached = keep * momentum - (pushed + push * dry) + lack * missing
        drive_1, drive_4 = full_1 - e_1 * missing, full_4 - e_4 * missing_4
        torque_1, torque_4 = drive_1 + dry + decay * momentum, drive_4 + dry + decay * reached
        mean = (momentum - reached) * per_step
        after = torque_4
        if not calm:
            stiff = False
            if locked and brake == 0.0:
                torque_1, torque_4 = last, last
                reached, missing_4 = momentum - step * last, missing
            else:
                power = max(abs(drive_1 * momentum), abs(drive_4 * reached)) * inverse_inertia
                nearest = min(abs(momentum), abs(reached)) if momentum * reached > 0.0 else 0.0
                stiff = nearest <= edge or power > power_limit or brake > 0.0
                if stiff:
                    reached, torque_1, torque_4 = stiff_step(
                        array, j, momentum, step, wanted, missing, e_1, e_2, e_4, b_1, b_2, b_4, forward, backward,
                        brake,
                    )  # fmt: skip
            inside = min(max(reached, -limit), limit)
            mean = (momentum - inside) * per_step
            after = torque_4
            if inside != reached:
                # At most 1, and 0 for a wheel that stands at its limit and is pushed further.
                share = (inside - momentum) / (reached - momentum)
                after, torque_1, torque_4 = share * torque_4, mean, mean
            elif stiff and momentum * inside <= 0.0:
                # Friction turns round or lets go within the step: only its impulse is well defined.
                torque_1, torque_4 = mean, mean
            reached = inside
        # The middle is what makes Simpson's rule, which the body applies, give the impulse that the wheel lost.
        torque_2 = 1.5 * mean - 0.25 * (torque_1 + torque_4)
        actuation[substep, 0] += torque_1 * axis_x
        actuation[substep, 1] += torque_1 * axis_y
        actuation[substep, 2] += torque_1 * axis_z
        actuation[substep, 3] += torque_2 * axis_x
        actuation[substep, 4] += torque_2 * axis_y
        actuation[substep, 5] += torque_2 * axis_z
        actuation[substep, 6] += torque_4 * axis_x
        actuation[substep, 7] += torque_4 * axis_y
        actuation[substep, 8] += torque_4 * axis_z
        momentum, missing, last = reached, missing_4, after
        motor = wanted - missing
    return momentum, motor, last
