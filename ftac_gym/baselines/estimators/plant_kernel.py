"""Compiled multiple-model estimator: inertia, angular momentum, and which wheel is faulty.

:mod:`.torque_kernel` has the missing torque r, and learns inertia and momentum from it while the body accelerates. Gyro
noise, uncertain parameters and model errors give r a covariance S. A faulty wheel j adds torque along its axis alone.
Its excess torque is then g_j = D_j' S^-1 r / (D_j' S^-1 D_j), and g_j^2 over its variance is the increment of a
cumulative sum. The wheel with the largest sum is faulty once the sum passes a threshold and leads the others.
:mod:`.wheel_kernel` tells the kind of its fault. Its axis is left out of what is learned of all else.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ftac_gym.baselines.estimators import attitude_kernel, torque_kernel, wheel_kernel
from ftac_gym.baselines.estimators.attitude_kernel import symmetric_inverse
from ftac_gym.baselines.estimators.torque_kernel import (
    commanded,
    distance,
    learn,
    miss,
    relate,
    relearn,
    spread_of,
    time_loop,
    widen,
)
from ftac_gym.baselines.estimators.wheel_kernel import (
    ABRUPT,
    BIAS,
    CALM,
    DELAY,
    HEALTHY,
    LOCK,
    LONGEST,
    LONGEST_LOOP,
    OUTAGE,
    UNKNOWN,
    begin,
    explained,
    follow,
    gather,
    torque_of,
)
from ftac_gym.utils import algebra
from ftac_gym.utils.algebra import rotation_change
from ftac_gym.utils.compiling import entry_point, merged

SMOOTH = 0.3
"""Gain of the low-pass of the unexplained torque."""
OUTLIER = 16.0
"""Squared normalised residual from which a period teaches nothing of inertia and momentum."""
UNLIKELY = 20.0
"""Squared distance of a learned inertia from the nominal one, in standard deviations, that a fault has caused."""
LEAD = 20.0
"""Lead of the score of a faulty wheel over all others."""
YOUNG = 12
"""Control periods after the start in which no wheel is judged: a late loop would look like faulty wheels."""
WEAKEST = 0.3
"""Effectiveness below which a wheel is left out, as long as three others remain."""
MOST = 2
"""Most faulty wheels at a time: a third one cannot be told from two."""


@merged
def start_at(state: Any, wheels: Any, model: Any, rate: Any, momentum: Any, before: Any) -> None:
    """Start an episode: nominal parameters and healthy wheels."""
    state.started = True
    for i in range(9):
        state.parameters[i] = model.start[i]
        for k in range(9):
            state.covariance[i, k] = model.spread[i, k]
    for i in range(3):
        state.rate[i], state.missing[i] = rate[i], 0.0
    for j in range(len(wheels)):
        wheels[j].effectiveness = 1.0
        before[j] = momentum[j]


@merged
def separate(
    state: Any, wheels: Any, model: Any, inside: Any, inverse: Any, momentum: Any, before: Any, own: Any
) -> float:
    """Write excess torque and information of every wheel; return the factor that caps the increments of scores.

    Parameters
    ----------
    state, wheels, model, momentum, before
        As of :func:`observe`.
    inside, inverse
        Covariance of the missing torque, and its inverse.
    own
        Scratch.
    """
    largest = model.largest
    missing = state.missing
    for j in range(len(wheels)):
        wheel = wheels[j]
        used = inverse
        if wheel.kind != HEALTHY:
            widen(inside, model.axes, j, model.limits[j], -1.0)
            symmetric_inverse(inside, own)
            widen(inside, model.axes, j, model.limits[j], 1.0)
            used = own
        information, along = 0.0, 0.0
        for i in range(3):
            for k in range(3):
                term = model.axes[j, i] * used[i, k]
                information += term * model.axes[j, k]
                along += term * missing[k]
        if model.tachometer < math.inf:
            along += ((before[j] - momentum[j]) / model.period - wheel.commands[0]) / model.tachometer
            information += 1.0 / model.tachometer
            before[j] = momentum[j]
        wheel.information, wheel.excess = information, along / information
        if wheel.kind == HEALTHY:
            largest = max(largest, along * along / information)
    return float(model.largest / largest)


@merged
def judge(state: Any, wheels: Any, model: Any, faulty: int, factor: float) -> bool:
    """Update scores and faults of the wheels; tell whether one has just been found faulty."""
    worst, second = -1, 0.0
    for j in range(len(wheels)):
        wheel = wheels[j]
        increment = wheel.information * wheel.excess * wheel.excess
        if wheel.kind != HEALTHY:
            wheel.quiet += CALM * (min(increment, model.largest) - wheel.quiet)
            gather(wheel)
            follow(wheel, model.margin, model.limits[j])
            continue
        if faulty >= MOST:
            continue
        # All increments of a period keep their ratios: an outlier counts little, and for each wheel alike.
        wheel.score = min(max(wheel.score + factor * increment - model.drift, 0.0), 3.0 * model.threshold)
        if wheel.score == 0.0:
            begin(wheel)
            continue
        gather(wheel)
        if wheel.score > model.threshold and (worst < 0 or wheel.score > wheels[worst].score):
            second = max(second, 0.0 if worst < 0 else wheels[worst].score)
            worst = j
        else:
            second = max(second, wheel.score)
    if worst < 0 or second >= wheels[worst].score - LEAD:
        return worst >= 0
    wheel = wheels[worst]
    if wheel.sums[0] > ABRUPT or distance(state, model) > UNLIKELY:
        relearn(state, model)
    # The onset itself, in which excess and command both change, tells kinds apart wrongly.
    begin(wheel)
    wheel.quiet, wheel.level = model.largest, wheel.excess
    wheel.kind, wheel.held = UNKNOWN, 0
    return True


@merged
def remember(state: Any, wheels: Any, axes: Any) -> None:
    """Take what the estimated faults explain off the missing torque, and low-pass the rest."""
    rest, slow = state.rest, state.slow
    for i in range(3):
        rest[i] = state.missing[i]
    for j in range(len(wheels)):
        if wheels[j].kind != HEALTHY:
            known = explained(wheels[j])
            for i in range(3):
                rest[i] -= axes[j, i] * known
    for i in range(3):
        slow[i] += SMOOTH * (rest[i] - slow[i])


@merged
def observe(
    state: Any, wheels: Any, model: Any, attitude: Any, rate: Any, command: Any, momentum: Any, before: Any, work: Any
) -> None:
    """Take one measurement of one spacecraft into its state; arguments as of :func:`estimate_plant`."""
    if not state.started:
        start_at(state, wheels, model, rate, momentum, before)
        return
    scale, last = 1.0 / model.period, state.rate
    change = (scale * (rate[0] - last[0]), scale * (rate[1] - last[1]), scale * (rate[2] - last[2]))
    mean = (0.5 * (rate[0] + last[0]), 0.5 * (rate[1] + last[1]), 0.5 * (rate[2] + last[2]))
    for i in range(3):
        last[i] = rate[i]
    regressors, cross, inside, inverse, own = work[0], work[1], work[2], work[3], work[4]
    relate(regressors, change, mean, attitude, model)
    state.age += 1
    for j in range(len(wheels)):
        past = wheels[j].past
        for d in range(LONGEST_LOOP + LONGEST, 0, -1):
            past[d] = past[d - 1]
        past[0] = torque_of(wheels[j], command[j], model.period, model.lags[j])
    torque = commanded(wheels, model.axes, state.late)
    miss(state, regressors, mean, torque, model.coupled)
    faulty = spread_of(state, wheels, regressors, torque, model, cross, inside)
    symmetric_inverse(inside, inverse)
    if time_loop(state, wheels, model.axes, torque, inverse):
        torque = commanded(wheels, model.axes, state.late)
        miss(state, regressors, mean, torque, model.coupled)
    for j in range(len(wheels)):
        wheel = wheels[j]
        for d in range(LONGEST + 1):
            wheel.commands[d] = wheel.past[state.late + d]
    square, missing = 0.0, state.missing
    for i in range(3):
        for k in range(3):
            square += missing[i] * inverse[i, k] * missing[k]
    factor = separate(state, wheels, model, inside, inverse, momentum, before, own)
    suspected = state.age > YOUNG and judge(state, wheels, model, faulty, factor)
    moves = change[0] * change[0] + change[1] * change[1] + change[2] * change[2] >= model.excitation
    if moves and square <= OUTLIER and not suspected:
        learn(state, cross, inverse)
    remember(state, wheels, model.axes)


@entry_point(algebra, attitude_kernel, torque_kernel, wheel_kernel)
def estimate_plant(
    state: Any, wheels: Any, model: Any, attitude: Any, rate: Any, command: Any, momentum: Any, before: Any
) -> None:
    """Take one measurement of N spacecraft into their states, in place.

    Parameters
    ----------
    state, wheels
        PLANT_STATE records (N,) and WHEEL_STATE records (N, m).
    model
        The :class:`PlantModel`.
    attitude
        (N, 4) estimated quaternions.
    rate
        (N, 3) rates without bias [rad/s].
    command
        (N, m) mean commands in effect over the period that has ended [N m].
    momentum, before
        (N, m) measured momenta of the wheels, now and one period ago [N m s]; the latter are replaced.
    """
    work = np.zeros((5, 9, 9))
    for i in range(len(state)):
        observe(state[i], wheels[i], model, attitude[i], rate[i], command[i], momentum[i], before[i], work)


@entry_point(algebra, attitude_kernel, torque_kernel, wheel_kernel)
def summarise(
    state: Any,
    wheels: Any,
    model: Any,
    attitude: Any,
    inertia: Any,
    momentum: Any,
    response: Any,
    level: Any,
    missing: Any,
    usable: Any,
    late: Any,
) -> None:
    """Write what the states of N spacecraft say, for controllers and prediction.

    Parameters
    ----------
    state, wheels, model
        As of :func:`estimate_plant`.
    attitude
        (N, 4) quaternions, in whose body axes the momentum is.
    inertia, momentum, response, level, missing, usable, late
        The arrays of :class:`~ftac_gym.baselines.estimators.plant_estimator.PlantSummary`, written to.
    """
    for i in range(len(state)):
        parameters = state[i].parameters
        late[i] = state[i].late
        entries = inertia[i]
        entries[0, 0], entries[1, 1], entries[2, 2] = parameters[0], parameters[1], parameters[2]
        entries[0, 1], entries[0, 2], entries[1, 2] = parameters[3], parameters[4], parameters[5]
        entries[1, 0], entries[2, 0], entries[2, 1] = parameters[3], parameters[4], parameters[5]
        stored = (parameters[6], parameters[7], parameters[8])
        change = rotation_change(attitude[i, 0], (attitude[i, 1], attitude[i, 2], attitude[i, 3]), stored)
        for k in range(3):
            momentum[i, k] = stored[k] + change[k]
            missing[i, k] = 0.0
        strong = 0
        for j in range(wheels.shape[1]):
            wheel = wheels[i, j]
            kind = wheel.kind
            response[i, j] = 0.0 if kind in (LOCK, OUTAGE) else wheel.effectiveness
            level[i, j] = wheel.level if kind in (LOCK, BIAS, UNKNOWN) else 0.0
            usable[i, j] = 0.0 if response[i, j] < WEAKEST or kind == DELAY else response[i, j]
            strong += 1 if usable[i, j] > 0.0 else 0
            for k in range(3):
                missing[i, k] += model.axes[j, k] * level[i, j]
        if strong < 3:
            # Weak and late wheels are better than too few.
            for j in range(wheels.shape[1]):
                usable[i, j] = response[i, j]
