"""Alarms of an estimator of faults: its own flags, or a rule on its estimates."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ftac_gym.baselines import FaultEstimate
from ftac_gym.spacecraft.wheel_array import WheelArray
from ftac_gym.utils.parameters import FloatArray, non_negative, positive, require

BoolArray = npt.NDArray[np.bool_]


@dataclass(frozen=True)
class AlarmRule:
    """Thresholds at which an estimate declares a fault, for estimators without alarms of their own.

    Torques are shares of the torque limit, or of 1 N m for a wheel without one. The defaults are a wheel that lacks a
    third of its torque, and a torque of a tenth of its limit. On the body it is more, since the model has errors. An
    error of 10 % of the inertia at full torque about an axis of the flagship is 0.23 of the limit of a wheel.

    Attributes
    ----------
    effectiveness
        A wheel alarms while its effectiveness can be identified and its estimate is below this.
    bias
        A wheel alarms while its estimated uncommanded torque exceeds this share of its limit.
    disturbance
        The spacecraft alarms, without naming a wheel, while the estimated torque on the body exceeds this share of the
        mean limit.
    hold
        Time for which a threshold must be exceeded without a break [s]; the alarm begins at its end.
    grace
        Time after the end of a fault in which an alarm is no false one [s]: estimates need it to return. It holds for
        flags of an estimator's own too.

    Raises
    ------
    ValueError
        If a threshold is not positive, or a time is negative.
    """

    effectiveness: float = 0.7
    bias: float = 0.1
    disturbance: float = 0.25
    hold: float = 0.5
    grace: float = 10.0

    def __post_init__(self) -> None:
        """Check the values."""
        share = 0.0 < positive(self.effectiveness, "effectiveness") < 1.0
        require(share, "effectiveness", "must be below 1, that of a healthy wheel", self.effectiveness)
        for name in ("bias", "disturbance"):
            positive(getattr(self, name), name)
        for name in ("hold", "grace"):
            non_negative(getattr(self, name), name)


@dataclass(frozen=True, eq=False)
class Alarms:
    """Alarms along a flight of T control periods of N spacecraft with m wheels.

    Attributes
    ----------
    wheels
        (T, N, m) weight of the alarm of each wheel, zero without one: the excess over its threshold, or one for a flag
        of the estimator's own. Of several wheels in alarm, the one with the largest sum is named.
    body
        (T, N) alarm that names no wheel.
    names_wheels
        Whether the estimator can name a wheel.
    """

    wheels: FloatArray
    body: BoolArray
    names_wheels: bool

    @property
    def any(self) -> BoolArray:
        """(T, N) whether there is an alarm."""
        raised: BoolArray = self.body | (self.wheels > 0.0).any(axis=2)
        return raised


def alarms_of(estimates: FaultEstimate, rule: AlarmRule, wheels: WheelArray, control_period: float) -> Alarms:
    """Return the alarms of an estimator.

    Parameters
    ----------
    estimates
        Estimates (T, N, ...) along a flight. Their ``alarm`` is taken as it is; without it the rule decides.
    rule
        Thresholds.
    wheels
        The wheel array.
    control_period
        [s].

    Raises
    ------
    ValueError
        If there is no estimate of wheels or torque.
    """
    if estimates.alarm is not None:
        flags = np.asarray(estimates.alarm, dtype=np.float64)
        return Alarms(flags, np.zeros(flags.shape[:2], dtype=np.bool_), names_wheels=True)
    limits = np.where(np.isfinite(wheels.torque_limits), wheels.torque_limits, 1.0)
    excess: list[FloatArray] = []
    if estimates.effectiveness is not None:
        lost = (1.0 - estimates.effectiveness) / (1.0 - rule.effectiveness)
        excess.append(lost if estimates.identifiable is None else np.where(estimates.identifiable, lost, 0.0))
    if estimates.bias is not None:
        excess.append(np.abs(estimates.bias) / (rule.bias * limits))
    torque = estimates.disturbance
    known = [*excess, *([] if torque is None else [torque])]
    require(len(known) > 0, "estimate", "must have alarm, effectiveness, bias or disturbance", estimates)
    periods = max(1, math.ceil(rule.hold / control_period - 1e-9))
    weights = np.zeros((*known[0].shape[:2], wheels.count))
    if excess:
        largest = np.maximum.reduce(excess)
        weights = np.where(_sustained(largest > 1.0, periods), largest, 0.0)
    body = np.zeros(weights.shape[:2], dtype=np.bool_)
    if torque is not None:
        body = _sustained(np.linalg.norm(torque, axis=2) > rule.disturbance * limits.mean(), periods)
    return Alarms(weights, body, names_wheels=bool(excess))


def _sustained(flags: BoolArray, periods: int) -> BoolArray:
    """Return where flags (T, ...) are set in each of the last control periods, of which there must be as many."""
    counts = np.cumsum(flags, axis=0, dtype=np.int64)
    counts[periods:] = counts[periods:] - counts[:-periods]
    sustained: BoolArray = counts == periods
    return sustained
