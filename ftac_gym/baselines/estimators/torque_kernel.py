"""Compiled balance of the torque on the body: missing torque, inertia and momentum learned from it, delay of the loop.

The missing torque of a control period is what the commands do not explain. It is linear in the inertia J and in the
total angular momentum H, which is constant in inertial axes::

    r = J w' + w x C(q) H - D u

J and H are learned from it by least squares. Of the delays that the loop may have beyond the nominal one, the right one
leaves the smallest sum of squared normalised r.
"""

from __future__ import annotations

from typing import Any

from ftac_gym.baselines.estimators.wheel_kernel import HEALTHY, LONGEST_LOOP
from ftac_gym.utils.algebra import cross3, rotation_change, symmetric_times
from ftac_gym.utils.compiling import merged

FADE, DECISIVE = 0.995, 40.0
"""Share of the residuals' sums that the next period keeps, and the lead of the delay that takes over."""
SETTLED = 30
"""Control periods after the start in which the delay of the loop is found: it is that of computers and buses."""


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
