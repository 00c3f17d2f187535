"""Compiled plant: wheels with faults, then the body, one spacecraft after the other.

The body does not act on the wheels: their momentum changes by the torque alone. Each part of a control period has one
command. First every wheel turns through all its physics steps, and its torque at the three stage times of RK4 is
stored. The body is then integrated with the sums of these torques, together with the flexible modes if there are
any.

Faults switch on and off only between physics steps: within a step the torque is smooth, and RK4 keeps its order.
"""

from typing import Any

import numpy as np

from ftac_gym.dynamics import body, modes, stiff_wheel, wheel_table, wheels
from ftac_gym.dynamics.body import angular_acceleration, fill_disturbance, inertia_at, twice_attitude_rate
from ftac_gym.dynamics.modes import ROWS, begin_step, end_step, load_modes, modal_stage, store_modes
from ftac_gym.dynamics.wheels import turn_wheel
from ftac_gym.faults import signals
from ftac_gym.faults.signals import constant_signals, untouched
from ftac_gym.utils import algebra
from ftac_gym.utils.algebra import add3, add4, store_unit
from ftac_gym.utils.compiling import entry_point, inlined, merged


@inlined
def slopes(
    appendages: Any,
    work: Any,
    weight: float,
    ahead: float,
    q: Any,
    w: Any,
    stored: Any,
    torque: Any,
    external: Any,
    inertia: Any,
    steady: Any,
) -> Any:
    """Return 2 q' and w' at a stage of RK4, and take that stage of the modes, if there are any.

    ``weight`` and ``ahead`` [s] are those of :func:`.modal_stage`; ``stored`` is the momentum [N m s] and ``torque``
    the torque [N m] of the wheels.
    """
    if appendages is not None:
        momentum, pull = modal_stage(work, w, weight, ahead)
        stored, torque = add3(stored, 1.0, momentum), add3(torque, 1.0, pull)
    return twice_attitude_rate(w, q), angular_acceleration(w, stored, torque, external, inertia, steady)


@merged
def turn_body(
    i: int,
    begin: float,
    attitude: Any,
    rate: Any,
    coupled: bool,
    stored: Any,
    total: Any,
    actuation: Any,
    inertia: Any,
    rate_torque: bool,
    appendages: Any,
    modal_displacement: Any,
    modal_rate: Any,
    work: Any,
    steady: Any,
    external: Any,
    step: float,
    substeps: int,
) -> None:
    """Turn body i through a control period under the torques of its wheels, in place.

    The parameters are those of :func:`advance`, with those of wheels and work space as follows.

    Parameters
    ----------
    begin
        Start of the period [s].
    stored
        Momentum of the wheels at the start [N m s], body axes.
    total, actuation
        Torque of the wheels [N m], body axes: (3,) of those that hold it through the period, and (substeps, 9) of the
        others at the three stage times.
    work
        Space (ROWS, k) for the modes.
    external
        (2 * substeps + 1, 3) external torque at every half step [N m].
    """
    q = (attitude[i, 0], attitude[i, 1], attitude[i, 2], attitude[i, 3])
    w = (rate[i, 0], rate[i, 1], rate[i, 2])
    amplitude = inertia[i].amplitude
    varying = amplitude[0] != 0.0 or amplitude[1] != 0.0 or amplitude[2] != 0.0
    carried = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    if appendages is not None:
        carried = load_modes(work, appendages[i], modal_displacement[i], modal_rate[i], w)
    body_1 = inertia_at(inertia[i], carried, varying, rate_torque, begin)
    body_2, body_4 = body_1, body_1
    for substep in range(substeps):
        if varying:
            time = begin + substep * step
            body_1 = inertia_at(inertia[i], carried, varying, rate_torque, time)
            body_2 = inertia_at(inertia[i], carried, varying, rate_torque, time + 0.5 * step)
            body_4 = inertia_at(inertia[i], carried, varying, rate_torque, time + step)
        external_1, external_2 = external[2 * substep], external[2 * substep + 1]
        external_4 = external[2 * substep + 2]
        wheel_1 = add3(total, 1.0, (actuation[substep, 0], actuation[substep, 1], actuation[substep, 2]))
        wheel_2 = add3(total, 1.0, (actuation[substep, 3], actuation[substep, 4], actuation[substep, 5]))
        wheel_4 = add3(total, 1.0, (actuation[substep, 6], actuation[substep, 7], actuation[substep, 8]))
        stored_2, stored_3, stored_4 = stored, stored, stored
        if coupled:
            stored_2 = add3(stored, -0.5 * step, wheel_1)
            stored_3 = add3(stored, -0.5 * step, wheel_2)
            stored_4 = add3(stored, -step, wheel_2)

        if appendages is not None:
            begin_step(work)
        turn_1, spin_1 = slopes(appendages, work, 1.0, 0.5 * step, q, w, stored, wheel_1, external_1, body_1, steady[i])
        q_2, w_2 = add4(q, 0.25 * step, turn_1), add3(w, 0.5 * step, spin_1)
        turn_2, spin_2 = slopes(
            appendages, work, 2.0, 0.5 * step, q_2, w_2, stored_2, wheel_2, external_2, body_2, steady[i]
        )
        q_3, w_3 = add4(q, 0.25 * step, turn_2), add3(w, 0.5 * step, spin_2)
        turn_3, spin_3 = slopes(appendages, work, 2.0, step, q_3, w_3, stored_3, wheel_2, external_2, body_2, steady[i])
        q_4, w_4 = add4(q, 0.5 * step, turn_3), add3(w, step, spin_3)
        turn_4, spin_4 = slopes(appendages, work, 1.0, 0.0, q_4, w_4, stored_4, wheel_4, external_4, body_4, steady[i])
        if appendages is not None:
            end_step(work, step / 6.0)
        q = add4(q, step / 12.0, add4(add4(turn_1, 1.0, turn_4), 2.0, add4(turn_2, 1.0, turn_3)))
        w = add3(w, step / 6.0, add3(add3(spin_1, 1.0, spin_4), 2.0, add3(spin_2, 1.0, spin_3)))
        if coupled:
            stored = add3(stored, -step / 6.0, add3(add3(wheel_1, 1.0, wheel_4), 4.0, wheel_2))
    # RK4 keeps the norm to (rate * step)^6 a step: once a period suffices to keep it to rounding.
    store_unit(attitude, i, q)
    rate[i, 0], rate[i, 1], rate[i, 2] = w
    if appendages is not None:
        store_modes(work, modal_displacement[i], modal_rate[i], w)


@entry_point(algebra, body, signals, modes, stiff_wheel, wheels, wheel_table)
def advance(
    start: int,
    stop: int,
    attitude: Any,
    rate: Any,
    wheel_momentum: Any,
    motor_torque: Any,
    last_torque: Any,
    ticks: Any,
    first: int,
    commands: Any,
    lag: Any,
    array: Any,
    coupled: bool,
    inertia: Any,
    rate_torque: bool,
    appendages: Any,
    modal_displacement: Any,
    modal_rate: Any,
    faults: Any,
    switches: Any,
    steady: Any,
    harmonics: Any,
    step: float,
    substeps: int,
    period: float,
) -> None:
    """Advance spacecraft ``start`` to ``stop - 1`` through a part of a control period, in place, by classical RK4.

    A wheel that would pass its momentum limit within a step gives the share of its torque that takes it there.

    Parameters
    ----------
    start, stop
        Range of the N spacecraft.
    attitude, rate
        State of the body, (N, 4) and (N, 3) [rad/s].
    wheel_momentum, motor_torque, last_torque
        State of the wheels, (N, m) each [N m s, N m, N m].
    ticks
        (N,) control periods since the start of the episode.
    first
        First physics step of the part.
    commands, lag
        (D, N, m) commands [N m], latest first, and (N,) position of that in effect where no fault delays.
    array, coupled
        WHEEL records (m,); True if the stored momentum acts on the body.
    inertia, rate_torque
        INERTIA records (N,); True for the term -J' w.
    appendages, modal_displacement, modal_rate
        MODE records (N, k) and state of the modes (N, k). All are None for rigid bodies, for which the compiler makes a
        plant of their own without modes.
    faults, switches
        FAULT records (N, m, layers) and switching times (N, chains, FLIPS) [s].
    steady, harmonics
        DISTURBANCE records (N,) and HARMONIC records (N, K).
    step, substeps
        Physics step [s], and number of them in the part.
    period
        Control period [s].
    """
    count = array.shape[0]
    external = np.empty((2 * substeps + 1, 3))
    actuation = np.empty((substeps, 9))
    work = np.empty((ROWS, 0 if appendages is None else appendages.shape[1]))
    length = step * substeps
    for i in range(start, stop):
        begin = ticks[i] * period + first * step
        fill_disturbance(external, steady[i], harmonics[i], begin, step)
        stored = (0.0, 0.0, 0.0)
        total = (0.0, 0.0, 0.0)
        actuation[:] = 0.0
        for j in range(count):
            wheel = array[j]
            axis = (wheel.axis[0], wheel.axis[1], wheel.axis[2])
            momentum = wheel_momentum[i, j]
            if coupled:
                stored = add3(stored, momentum, axis)
            if wheel.ideal > 0.5:
                torque = min(max(commands[lag[i], i, j], -wheel.torque_limit), wheel.torque_limit)
                constant = True
                if not untouched(faults, i, j, begin, begin + length):
                    constant, locked, delay, effectiveness, bias, _, _, brake = constant_signals(
                        faults, i, j, begin, begin + length
                    )
                    constant = constant and delay == 0 and brake == 0.0
                    torque = last_torque[i, j] if locked else effectiveness * torque + bias
                if constant:
                    reached = momentum - length * torque
                    if abs(reached) <= wheel.momentum_limit:
                        total = add3(total, torque, axis)
                        wheel_momentum[i, j] = reached
                        last_torque[i, j] = torque
                        continue
            wheel_momentum[i, j], motor_torque[i, j], last_torque[i, j] = turn_wheel(
                array, faults, switches, i, j, commands, lag[i], momentum, motor_torque[i, j], last_torque[i, j],
                begin, step, substeps, actuation,
            )  # fmt: skip
        turn_body(
            i, begin, attitude, rate, coupled, stored, total, actuation, inertia, rate_torque, appendages,
            modal_displacement, modal_rate, work, steady, external, step, substeps,
        )  # fmt: skip
