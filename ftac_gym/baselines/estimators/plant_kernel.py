"""Compiled multiple-model estimator: inertia, angular momentum, and which wheel is faulty.

The missing torque is what the commands do not explain of the torque on the body. It is linear in the inertia J and in
the total angular momentum H, which is constant in inertial axes::

    r = J w' + w x C(q) H - D u

J and H are learned from it by least squares while the body accelerates. Gyro noise, uncertain parameters and model
errors give r a covariance S. A faulty wheel j adds torque along its axis alone. Its excess torque is then g_j = D_j'
S^-1 r / (D_j' S^-1 D_j), and g_j^2 over its variance is the increment of a cumulative sum. The wheel with the largest
sum is faulty once the sum passes a threshold and leads the others. :mod:`.wheel_kernel` tells the kind of its fault.
Its axis is left out of what is learned of all else.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ftac_gym.baselines.estimators import attitude_kernel, wheel_kernel
from ftac_gym.baselines.estimators.attitude_kernel import symmetric_inverse
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
from ftac_gym.utils.algebra import cross3, rotation_change, symmetric_times
from ftac_gym.utils.compiling import entry_point, merged

PLANT_STATE = np.dtype(
    [
        ("started", "?"),
        ("age", "i8"),
        ("late", "i8"),
        ("energies", "f8", (LONGEST_LOOP + 1,)),
        ("rate", "f8", (3,)),
        ("missing", "f8", (3,)),
        ("rest", "f8", (3,)),
        ("slow", "f8", (3,)),
        ("parameters", "f8", (9,)),
        ("covariance", "f8", (9, 9)),
    ]
)
"""State of one spacecraft.

Whether it has started; control periods since then; delay of the loop beyond the nominal one [control periods], and the
squared normalised residuals that each such delay leaves, summed with a weight that fades. The rate of the last period
[rad/s]; in body axes [N m] the missing torque of the last period,
its rest without that of faulty wheels, and the rest low-passed. Then inertia (xx, yy, zz, xy, xz, yz) [kg m^2] and
angular momentum in inertial axes [N m s], with their covariance.
"""

SMOOTH = 0.3
"""Gain of the low-pass of the unexplained torque."""
OUTLIER = 16.0
"""Squared normalised residual from which a period teaches nothing of inertia and momentum."""
UNLIKELY = 20.0
"""Squared distance of a learned inertia from the nominal one, in standard deviations, that a fault has caused."""
LEAD = 20.0
"""Lead of the score of a faulty wheel over all others."""
FADE, DECISIVE = 0.995, 40.0
"""Share of the residuals' sums that the next period keeps, and the lead of the delay that takes over."""
SETTLED = 30
"""Control periods after the start in which the delay of the loop is found: it is that of computers and buses."""
YOUNG = 12
"""Control periods after the start in which no wheel is judged: a late loop would look like faulty wheels."""
WEAKEST = 0.3
"""Effectiveness below which a wheel is left out, as long as three others remain."""
MOST = 2
"""Most faulty wheels at a time: a third one cannot be told from two."""


class PlantModel(NamedTuple):
    """Nominal spacecraft and thresholds of the estimator; SI units.

    Attributes
    ----------
    period
        Control period [s].
    axes
        (m, 3) wheel axes.
    limits
        (m,) torque limits [N m].
    assured
        (m,) torque that each wheel gives at any speed [N m]; infinite without a limit of its power.
    coupled
        Whether the momentum of the wheels acts on the body.
    start, spread
        (9,) parameters at the start, and (9, 9) their covariance.
    noise
        (3, 3) covariance of the torque that the gyro noise of one period looks like [N2 m2].
    excitation
        Least squared angular acceleration at which the parameters are learned [rad^2/s^4].
    tolerance
        Error of the model as a share of the commanded torque.
    floor
        Standard deviation of the torque of environment, friction and dead band [N m].
    lags
        (m,) time constants of the wheels [s].
    tachometer
        Variance of the torque of a wheel by its tachometer [N2 m2]; infinite without telemetry.
    drift
        Score that each wheel loses every period; a healthy wheel gains 1 on average.
    largest
        Largest increment of a score.
    threshold
        Score of a faulty wheel.
    margin
        Least difference of twice the logarithms of likelihood by which a kind of fault is told from others.
    """

    period: float
    axes: Any
    limits: Any
    assured: Any
    coupled: bool
    start: Any
    spread: Any
    noise: Any
    excitation: float
    tolerance: float
    floor: float
    lags: Any
    tachometer: float
    drift: float
    largest: float
    threshold: float
    margin: float


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
def relate(regressors: Any, change: Any, mean: Any, attitude: Any, model: Any) -> None:
    """Write the regressors (3, 9) of J w' + w x C(q) H.

    Parameters
    ----------
    regressors
        Written to.
    change, mean
        Mean angular acceleration [rad/s^2] and mean rate [rad/s] of the period.
    attitude
        Quaternion at the end of the period.
    model
        The :class:`PlantModel`.
    """
    x, y, z = change
    for i in range(3):
        for k in range(9):
            regressors[i, k] = 0.0
    regressors[0, 0], regressors[0, 3], regressors[0, 4] = x, y, z
    regressors[1, 1], regressors[1, 3], regressors[1, 5] = y, x, z
    regressors[2, 2], regressors[2, 4], regressors[2, 5] = z, x, y
    if not model.coupled:
        return
    half = 0.5 * model.period
    scalar, vector = attitude[0], (attitude[1], attitude[2], attitude[3])
    for k in range(3):
        unit = (1.0 if k == 0 else 0.0, 1.0 if k == 1 else 0.0, 1.0 if k == 2 else 0.0)
        turn = rotation_change(scalar, vector, unit)
        column = (unit[0] + turn[0], unit[1] + turn[1], unit[2] + turn[2])
        # The momentum in body axes at the middle of the period.
        back = cross3(mean, column)
        column = (column[0] + half * back[0], column[1] + half * back[1], column[2] + half * back[2])
        torque = cross3(mean, column)
        for i in range(3):
            regressors[i, 6 + k] = torque[i]


@merged
def widen(matrix: Any, axes: Any, wheel: int, limit: float, sign: float) -> None:
    """Add the variance of an unknown torque of a wheel to a covariance (3, 3), or take it off."""
    size = sign * 100.0 * limit * limit
    for i in range(3):
        for k in range(3):
            matrix[i, k] += size * axes[wheel, i] * axes[wheel, k]


@merged
def relearn(state: Any, model: Any) -> None:
    """Forget the inertia, into which a fault that grew slowly was learned, and doubt the momentum."""
    for i in range(9):
        for k in range(9):
            state.covariance[i, k] = 0.0 if i >= 6 or k >= 6 else model.spread[i, k]
        if i < 6:
            state.parameters[i] = model.start[i]
        else:
            state.covariance[i, i] = 0.01 * model.spread[i, i]


@merged
def distance(state: Any, model: Any) -> float:
    """Return the squared distance of the inertia from its start, in standard deviations at the start."""
    total = 0.0
    for i in range(6):
        change = state.parameters[i] - model.start[i]
        total += change * change / model.spread[i, i]
    return total


@merged
def learn(state: Any, cross: Any, inverse: Any) -> None:
    """Update the parameters by the missing torque; ``cross`` (9, 3) is its covariance with them."""
    parameters, covariance, missing = state.parameters, state.covariance, state.missing
    for i in range(9):
        a = cross[i, 0] * inverse[0, 0] + cross[i, 1] * inverse[1, 0] + cross[i, 2] * inverse[2, 0]
        b = cross[i, 0] * inverse[0, 1] + cross[i, 1] * inverse[1, 1] + cross[i, 2] * inverse[2, 1]
        c = cross[i, 0] * inverse[0, 2] + cross[i, 1] * inverse[1, 2] + cross[i, 2] * inverse[2, 2]
        parameters[i] -= a * missing[0] + b * missing[1] + c * missing[2]
        for k in range(i, 9):
            value = covariance[i, k] - a * cross[k, 0] - b * cross[k, 1] - c * cross[k, 2]
            covariance[i, k] = value
            covariance[k, i] = value


@merged
def miss(state: Any, regressors: Any, mean: Any, torque: Any, coupled: bool) -> None:
    """Write the torque that the commanded one, a triple [N m], does not explain."""
    for i in range(3):
        value = -torque[i]
        for k in range(9):
            value += regressors[i, k] * state.parameters[k]
        state.missing[i] = value
    if not coupled:
        gyroscopic = cross3(mean, symmetric_times(state.parameters, mean))
        for i in range(3):
            state.missing[i] += gyroscopic[i]


@merged
def spread_of(state: Any, wheels: Any, regressors: Any, torque: Any, model: Any, cross: Any, inside: Any) -> int:
    """Write the covariance (3, 3) of the missing torque, and that with the parameters (9, 3).

    The torque along the axis of a faulty wheel is unknown. Returns the number of faulty wheels.
    """
    covariance = state.covariance
    for i in range(9):
        for k in range(3):
            value = 0.0
            for n in range(9):
                value += covariance[i, n] * regressors[k, n]
            cross[i, k] = value
    size = torque[0] * torque[0] + torque[1] * torque[1] + torque[2] * torque[2]
    loose = model.tolerance * model.tolerance * size + model.floor * model.floor
    for i in range(3):
        for k in range(3):
            value = model.noise[i, k]
            for n in range(9):
                value += regressors[i, n] * cross[n, k]
            inside[i, k] = value
        inside[i, i] += loose
    faulty = 0
    for j in range(len(wheels)):
        # At an unknown speed the limit of the power may take some of the torque.
        doubtful = abs(wheels[j].past[state.late]) - model.assured[j]
        if doubtful > 0.0:
            for i in range(3):
                for k in range(3):
                    inside[i, k] += 0.25 * doubtful * doubtful * model.axes[j, i] * model.axes[j, k]
        if wheels[j].kind != HEALTHY:
            faulty += 1
            widen(inside, model.axes, j, model.limits[j], 1.0)
    return faulty


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
def commanded(wheels: Any, axes: Any, late: int) -> Any:
    """Return the torque of healthy wheels on the body, a triple [N m], for commands by a delay of the loop."""
    x, y, z = 0.0, 0.0, 0.0
    for j in range(len(wheels)):
        given = wheels[j].past[late]
        x, y, z = x + given * axes[j, 0], y + given * axes[j, 1], z + given * axes[j, 2]
    return x, y, z


@merged
def time_loop(state: Any, wheels: Any, axes: Any, torque: Any, inverse: Any) -> bool:
    """Update the delay of the loop; tell whether it has changed.

    Parameters
    ----------
    state, wheels, axes
        As of :func:`observe`.
    torque
        Commanded torque by the present delay, of which the missing torque is the rest [N m].
    inverse
        Inverse of the covariance of the missing torque (3, 3).
    """
    if state.age > SETTLED:
        return False
    missing, energies = state.missing, state.energies
    best = 0
    for d in range(LONGEST_LOOP + 1):
        other = commanded(wheels, axes, d)
        a, b, c = (
            missing[0] + torque[0] - other[0],
            missing[1] + torque[1] - other[1],
            missing[2] + torque[2] - other[2],
        )
        x = inverse[0, 0] * a + inverse[0, 1] * b + inverse[0, 2] * c
        y = inverse[1, 0] * a + inverse[1, 1] * b + inverse[1, 2] * c
        z = inverse[2, 0] * a + inverse[2, 1] * b + inverse[2, 2] * c
        energies[d] = FADE * energies[d] + a * x + b * y + c * z
        if energies[d] < energies[best]:
            best = d
    if best == state.late or energies[best] > energies[state.late] - DECISIVE:
        return False
    state.late = best
    for j in range(len(wheels)):
        wheels[j].score = 0.0
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


@entry_point(algebra, attitude_kernel, wheel_kernel)
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


@entry_point(algebra, attitude_kernel, wheel_kernel)
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
