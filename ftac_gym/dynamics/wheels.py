"""Compiled wheels: from a command, the faults and the state of a wheel to its torque on the body.

A wheel has two states, the motor torque m and the momentum h. Over one physics step, with u the command within its
limits, T the lag, e(t) and b(t) effectiveness and bias, and T_f friction::

    T m' = u - m,    h' = -(e m + b + T_f(h / I)).

Away from rest, friction is Coulomb plus viscous and the solution is closed; elsewhere the step is implicit
(:mod:`.stiff_wheel`). The torques at the stages of the body's Runge-Kutta step have the impulse that the wheel lost:
total momentum is conserved to rounding.
"""

import math
from typing import Any

from numba import njit

from ftac_gym.dynamics.stiff_wheel import stiff_step
from ftac_gym.faults.signals import constant_signals, step_signals
from ftac_gym.utils.compiling import CONTRACT, inlined, merged


@inlined
def within_limits(wheel: Any, command: float) -> float:
    """Return a command after torque limit and dead-band [N m]."""
    limited = min(max(command, -wheel.torque_limit), wheel.torque_limit)
    return limited if abs(limited) >= wheel.dead_band else 0.0


@inlined
def add_torque(actuation: Any, substep: int, column: int, torque: float, axis: Any) -> None:
    """Add the torque of a wheel to three columns of the actuation."""
    actuation[substep, column] += torque * axis[0]
    actuation[substep, column + 1] += torque * axis[1]
    actuation[substep, column + 2] += torque * axis[2]


@njit(error_model="numpy", fastmath=CONTRACT)
def held_at_limit(
    array: Any, j: int, momentum: float, step: float, settled: float, transient: float, resistance: Any
) -> float:
    """Return the momentum after a step in which the lag presses wheel j against its limit and then releases it.

    The torque of the motor is ``settled`` - ``transient`` exp(-t / T). Without this the momentum would pass its limit
    within the step and come back. NaN if it stays within the limit.
    """
    wheel = array[j]
    forward, backward, brake = resistance
    sign = math.copysign(1.0, transient)
    dry = wheel.coulomb * (forward if sign > 0.0 else backward) + brake
    drag = sign * (dry + wheel.viscous * wheel.inverse_inertia * wheel.momentum_limit)
    balance = settled + drag
    # The exponential of the lag at the moment at which torque and drag balance.
    share = balance / transient
    if not wheel.lag_left[2] < share < 1.0:
        return math.nan
    lag = -step / math.log(wheel.lag_left[2])
    moment = -lag * math.log(share)
    peak = momentum - balance * moment + lag * (transient - balance)
    if not sign * peak > wheel.momentum_limit:
        return math.nan
    back = sign * (balance * (step - moment) - lag * (balance - transient * wheel.lag_left[2]))
    strongest = wheel.power_limit / (wheel.momentum_limit * wheel.inverse_inertia) + abs(drag)
    return sign * (wheel.momentum_limit - min(back, strongest * (step - moment)))


@merged
def turn_wheel(
    array: Any,
    faults: Any,
    switches: Any,
    i: int,
    j: int,
    commands: Any,
    lag: int,
    momentum: float,
    motor: float,
    last: float,
    begin: float,
    step: float,
    substeps: int,
    actuation: Any,
) -> Any:
    """Turn wheel j of spacecraft i through a control period or a part of it, physics step by physics step.

    Parameters
    ----------
    array, faults, switches
        WHEEL records (m,), FAULT records (N, m, layers), switching times (N, chains, FLIPS).
    commands, lag
        Commands (D, N, m) [N m], latest first, and the position of that in effect where no fault delays.
    momentum, motor, last
        State: momentum [N m s], motor torque [N m], torque on the body at the end of the step before [N m].
    begin, step, substeps
        Start of the period and physics step [s], and number of steps in the period.
    actuation
        (substeps, 9): the torque of the wheel [N m], body axes, at the start, the middle and the end of each step is
        added to it.

    Returns
    -------
    Momentum, motor torque and last torque at the end.
    """
    wheel = array[j]
    axis = (wheel.axis[0], wheel.axis[1], wheel.axis[2])
    limit, power_limit, inverse_inertia = wheel.momentum_limit, wheel.power_limit, wheel.inverse_inertia
    keep, edge, lag_left, coulomb = wheel.keep, wheel.linear_momentum, wheel.lag_left[2], wheel.coulomb
    decay, per_step = wheel.viscous * inverse_inertia, 1.0 / step
    push_1, push_2, push_4 = wheel.forcing[0], wheel.forcing[1], wheel.forcing[2]
    push = push_1 + push_2 + push_4
    constant, locked, delay, e_1, b_1, forward, backward, brake = constant_signals(
        faults, i, j, begin, begin + substeps * step
    )
    e_2, e_4, b_2, b_4 = e_1, e_1, b_1, b_1
    limited, missing, pushed, lack, full_1, full_4 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    calm = False
    for substep in range(substeps):
        if not constant:
            time = begin + substep * step
            locked, delay, e_1, e_2, e_4, b_1, b_2, b_4, forward, backward, brake = step_signals(
                faults, switches, i, j, time, step
            )
        if substep == 0 or not constant:
            limited = within_limits(wheel, commands[lag + delay, i, j])
            missing = limited - motor if lag_left > 0.0 else 0.0
            full_1, full_2, full_4 = e_1 * limited + b_1, e_2 * limited + b_2, e_4 * limited + b_4
            pushed = push_1 * full_1 + push_2 * full_2 + push_4 * full_4
            lack = wheel.lag_forcing[0] * e_1 + wheel.lag_forcing[1] * e_2 + wheel.lag_forcing[2] * e_4
        if substep == 0 and constant:
            # Calm: no limit, brake or rest can occur in this period, and the closed form needs no check.
            largest = abs(full_1) + abs(e_1 * missing)
            drag = coulomb * max(forward, backward) + decay * abs(momentum)
            travel = substeps * step * (largest + drag)
            farthest, nearest = abs(momentum) + travel, abs(momentum) - travel
            calm = not locked and brake == 0.0 and (edge < 0.0 or nearest > edge) and farthest < limit
            calm = calm and largest * farthest * inverse_inertia <= power_limit
        missing_4 = missing * lag_left
        # The solution for Coulomb and viscous friction alone.
        dry = math.copysign(coulomb, momentum) * (forward if momentum > 0.0 else backward)
        reached = keep * momentum - (pushed + push * dry) + lack * missing
        drive_1, drive_4 = full_1 - e_1 * missing, full_4 - e_4 * missing_4
        torque_1, torque_4 = drive_1 + dry + decay * momentum, drive_4 + dry + decay * reached
        mean = (momentum - reached) * per_step
        after = torque_4
        if not calm:
            stiff, smooth = False, True
            if locked and brake == 0.0:
                torque_1, torque_4 = last, last
                reached, missing_4 = momentum - step * last, missing
            else:
                power = max(abs(drive_1 * momentum), abs(drive_4 * reached)) * inverse_inertia
                nearest = min(abs(momentum), abs(reached)) if momentum * reached > 0.0 else 0.0
                stiff = nearest <= edge or power > power_limit or brake > 0.0
                if stiff:
                    effectiveness, bias, resistance = (e_1, e_2, e_4), (b_1, b_2, b_4), (forward, backward, brake)
                    reached, torque_1, torque_4 = stiff_step(
                        array, j, momentum, step, limited, missing, effectiveness, bias, resistance
                    )
                if lag_left > 0.0:
                    held = held_at_limit(array, j, momentum, step, full_2, e_2 * missing, (forward, backward, brake))
                    if held == held:
                        reached, smooth = held, False
            inside = min(max(reached, -limit), limit)
            mean = (momentum - inside) * per_step
            after = torque_4
            if inside != reached:
                # At most 1, and 0 for a wheel at its limit under a torque beyond it.
                share = (inside - momentum) / (reached - momentum)
                after, torque_1, torque_4 = share * torque_4, mean, mean
            elif not smooth or (stiff and momentum * inside <= 0.0):
                # The limit or friction acts in a part of the step: only the impulse is well defined.
                torque_1, torque_4 = mean, mean
            reached = inside
        # With this middle, Simpson's rule of the body gives the impulse that the wheel lost.
        torque_2 = 1.5 * mean - 0.25 * (torque_1 + torque_4)
        add_torque(actuation, substep, 0, torque_1, axis)
        add_torque(actuation, substep, 3, torque_2, axis)
        add_torque(actuation, substep, 6, torque_4, axis)
        momentum, missing, last = reached, missing_4, after
        motor = limited - missing
    return momentum, motor, last
