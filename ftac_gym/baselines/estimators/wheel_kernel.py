"""Compiled test of one wheel: whether it is faulty, how, and the torque that it gives beyond its command.

With the excess torque g of a wheel beyond its command u, the hypotheses are

- effectiveness e: g = (e - 1) u;
- bias: g = c;
- lock: g = c - u, the wheel gives c whatever it is told;
- outage: g = -u;
- delay of d periods: g(t) = u(t - d) - u(t).

A bias changes slowly, and so does the command of a controller that compensates for it. Only their quick parts tell a
bias from a lock: a bias has none that follows the command.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ftac_gym.baselines.estimate import WheelCondition
from ftac_gym.utils.compiling import merged

LONGEST = 5
"""Longest delay of a wheel that is told from other faults [control periods]."""

LONGEST_LOOP = 4
"""Longest delay of the whole loop beyond the nominal one that is found [control periods]."""

HEALTHY, EFFECTIVENESS, BIAS, LOCK = (
    int(WheelCondition.HEALTHY), int(WheelCondition.EFFECTIVENESS), int(WheelCondition.BIAS), int(WheelCondition.LOCK)
)  # fmt: skip
OUTAGE, DELAY, UNKNOWN = int(WheelCondition.OUTAGE), int(WheelCondition.DELAY), int(WheelCondition.UNKNOWN)

WHEEL_STATE = np.dtype(
    [
        ("kind", "i8"),
        ("delay", "i8"),
        ("held", "i8"),
        ("score", "f8"),
        ("quiet", "f8"),
        ("torque", "f8"),
        ("information", "f8"),
        ("excess", "f8"),
        ("level", "f8"),
        ("effectiveness", "f8"),
        ("slow_excess", "f8"),
        ("slow_command", "f8"),
        ("past", "f8", (LONGEST_LOOP + LONGEST + 1,)),
        ("commands", "f8", (LONGEST + 1,)),
        ("sums", "f8", (5,)),
        ("late", "f8", (LONGEST, 2)),
    ]
)
"""State of one wheel.

Its condition, a :class:`~ftac_gym.baselines.estimate.WheelCondition`; delay of its command [control periods]; control
periods until its level may jump back, with the sign of its last jump; score of the test for a fault; running mean of
the score's increments; torque at the end of the last period by the model [N m]; information on the excess torque,
1 / variance [1/(N m)^2]; the excess torque of the last period [N m]; the constant c; the effectiveness; slow parts of
excess and command [N m]; torques that healthy wheels give for the latest commands by the nominal delay of the loop, and
by the delay that is found [N m].

The sums are over the control periods since the fault was found, with a weight that fades. They are the number of
periods, g^2, u^2 and g u of the quick parts, and g^2 of the whole. For each delay there are g v and v^2 of the change v
that it makes, of the whole too. All but the number are in units of variance.
"""

SLOW, KEEP = 0.5, 0.99
"""Gain of the slow parts of excess and command, and the share of the sums that the next period keeps."""
CALM, RECOVERED = 0.02, 1.5
"""Gain of the running mean of a score's increments, and the mean below which a wheel has recovered."""
FOLLOW = 0.2
"""Gain of the constant c."""
ABRUPT = 8.0
"""Control periods in which an abrupt fault is found."""
HOLD = 10
"""Control periods after a jump of the level in which it does not jump back."""
CONSTANT = 0.05
"""Share of the torque limit from which a constant torque counts."""
LEAST_LOSS = 0.1
"""Least loss of effectiveness that is told from a bias."""
JUMP = 25.0
"""Squared change in units of variance that is none of noise."""


@merged
def torque_of(wheel: Any, command: float, period: float, lag: float) -> float:
    """Return the mean torque of a healthy wheel over a period [N m], and advance its lag.

    Parameters
    ----------
    wheel
        The WHEEL_STATE record.
    command
        Mean command in effect over the period [N m].
    period, lag
        Control period, and time constant of the wheel [s].
    """
    if lag <= 0.0:
        wheel.torque = command
        return command
    decay = math.exp(-period / lag)
    before = wheel.torque - command
    wheel.torque = command + decay * before
    return float(command + before * (1.0 - decay) * lag / period)


@merged
def explained(wheel: Any) -> float:
    """Return the excess torque that the estimated fault of a wheel explains [N m]."""
    given = wheel.commands[0]
    if wheel.kind == EFFECTIVENESS:
        return float((wheel.effectiveness - 1.0) * given)
    if wheel.kind == LOCK:
        return float(wheel.level - given)
    if wheel.kind == OUTAGE:
        return float(-given)
    if wheel.kind == DELAY:
        return float(wheel.commands[wheel.delay] - given)
    return float(wheel.level)


@merged
def begin(wheel: Any) -> None:
    """Forget what tells the kinds of faults of a wheel apart."""
    wheel.slow_excess, wheel.slow_command = wheel.excess, wheel.commands[0]
    for k in range(5):
        wheel.sums[k] = 0.0
    for d in range(LONGEST):
        wheel.late[d, 0], wheel.late[d, 1] = 0.0, 0.0


@merged
def gather(wheel: Any) -> None:
    """Add the last period to the sums that tell the kinds of faults apart."""
    excess, given, information = wheel.excess, wheel.commands[0], wheel.information
    quick, turn = excess - wheel.slow_excess, given - wheel.slow_command
    if abs(quick) > 3.0 * abs(turn) and information * quick * quick > JUMP:
        # The fault itself changes: this tells nothing of how the wheel follows its command.
        wheel.slow_excess, quick = excess, 0.0
    wheel.slow_excess += SLOW * quick
    wheel.slow_command += SLOW * turn
    sums, late = wheel.sums, wheel.late
    sums[0] = KEEP * sums[0] + 1.0
    sums[1] = KEEP * sums[1] + information * quick * quick
    sums[2] = KEEP * sums[2] + information * turn * turn
    sums[3] = KEEP * sums[3] + information * quick * turn
    sums[4] = KEEP * sums[4] + information * excess * excess
    for d in range(LONGEST):
        # A change has no constant part to be left out.
        change = wheel.commands[d + 1] - given
        late[d, 0] = KEEP * late[d, 0] + information * excess * change
        late[d, 1] = KEEP * late[d, 1] + information * change * change


@merged
def classify(wheel: Any, margin: float, limit: float) -> None:
    """Set the kind of a faulty wheel to that which fits best, if it fits distinctly better than the others.

    Each hypothesis leaves a sum of squares S of the quick parts. With n periods, n log(n + S) is twice the negative
    logarithm of its likelihood for an unknown variance of at least that of the noise. Hypotheses with a number to fit
    pay log(n). The kind stays where the best two differ by less than the margin.

    Parameters
    ----------
    wheel
        The WHEEL_STATE record.
    margin
        Least difference of twice the logarithms of likelihood.
    limit
        Torque limit of the wheel [N m].
    """
    count, gg, uu, gu = wheel.sums[0], wheel.sums[1], wheel.sums[2], wheel.sums[3]
    share = min(max(-gu / max(uu, 1e-300), 0.0), 1.0)
    penalty = math.log(count + 2.0) / (count + 2.0)
    best, second, kind, delay = math.log(count + gg), math.inf, BIAS, 0
    value = math.log(count + gg + 2.0 * gu + uu)
    if value < best:
        best, second, kind = value, best, OUTAGE
    else:
        second = value
    # With nearly nothing left the wheel is as good as out, and with nearly all it has no loss that can be told.
    share = max(share, LEAST_LOSS)
    if share < 0.9:
        value = math.log(count + gg + 2.0 * share * gu + share * share * uu) + penalty
        if value < best:
            best, second, kind = value, best, EFFECTIVENESS
        else:
            second = min(second, value)
    for d in range(LONGEST):
        value = math.log(count + max(wheel.sums[4] - 2.0 * wheel.late[d, 0] + wheel.late[d, 1], 0.0)) + penalty
        if value < best:
            # Neighbouring delays are the same kind.
            best, second, kind, delay = value, second if kind == DELAY else best, DELAY, d + 1
        elif kind != DELAY:
            second = min(second, value)
    if (second - best) * count < margin:
        mismatch = wheel.slow_excess + (1.0 - wheel.effectiveness) * wheel.slow_command
        if wheel.kind == EFFECTIVENESS and abs(mismatch) > CONSTANT * limit:
            wheel.kind, wheel.effectiveness, wheel.level = BIAS, 1.0, wheel.slow_excess
        return
    # A wheel that is locked without torque is out.
    locked = wheel.kind == LOCK and abs(wheel.level) > CONSTANT * limit
    if kind == OUTAGE and (locked or abs(wheel.slow_excess + wheel.slow_command) > CONSTANT * limit):
        kind = LOCK
    # A reduced effectiveness explains the slow part too.
    if kind == EFFECTIVENESS and abs(wheel.slow_excess + share * wheel.slow_command) > CONSTANT * limit:
        kind = BIAS
    if kind != wheel.kind:
        wheel.level = wheel.slow_excess + wheel.slow_command if kind == LOCK else wheel.slow_excess
    wheel.kind, wheel.delay = kind, delay
    wheel.effectiveness = 1.0 - share if kind == EFFECTIVENESS else 1.0


@merged
def follow(wheel: Any, margin: float, limit: float) -> None:
    """Take the last period into level and kind of a faulty wheel, and let it go if its fault is over.

    Parameters
    ----------
    wheel
        The WHEEL_STATE record.
    margin, limit
        As of :func:`classify`.
    """
    given = wheel.commands[0]
    constant = wheel.kind == BIAS or wheel.kind == UNKNOWN
    goal = wheel.excess + given if wheel.kind == LOCK else (wheel.excess if constant else 0.0)
    step = goal - wheel.level
    jumps = wheel.information * step * step > JUMP and step * wheel.held >= 0
    wheel.level += step if jumps else FOLLOW * step
    if jumps:
        # A level that jumps to and fro would close a loop of its own.
        wheel.held = HOLD if step > 0.0 else -HOLD
    elif wheel.held != 0:
        wheel.held -= 1 if wheel.held > 0 else -1
    classify(wheel, margin, limit)
    sudden = wheel.sums[0] < 2.0 * ABRUPT and abs(wheel.level) > limit
    if wheel.kind == UNKNOWN and sudden and limit >= 0.98 * abs(wheel.level + given):
        # No wheel adds more than its limit all at once; one that ignores a saturated command seems to.
        wheel.kind, wheel.level = LOCK, wheel.level + given
    if (wheel.kind == BIAS or wheel.kind == UNKNOWN) and wheel.quiet < RECOVERED:
        wheel.kind = HEALTHY
        wheel.score, wheel.level, wheel.effectiveness = 0.0, 0.0, 1.0
