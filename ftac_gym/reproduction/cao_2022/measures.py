"""Measures behind the claims of Cao, Gong and Han 2022."""

from __future__ import annotations

import numpy as np

from ftac_gym.attitude import mrp_derivative
from ftac_gym.baselines.components.predefined_time_gain import PredefinedTime
from ftac_gym.baselines.observers import PRINTED_LEARNING
from ftac_gym.reproduction.recordings import Recording, below_from
from ftac_gym.reproduction.wording import seconds
from ftac_gym.utils.parameters import FloatArray

ONSETS = (5.0, 8.0, 10.0)
"""Onsets of the losses of effectiveness, one for each wheel [s]."""

TOLERANCE = 0.05
"""Largest error of an effectiveness that counts as estimated."""

FINE = 0.01
"""Error at which arrival is timed [deg]: the closed forms give this time as they do for zero."""


def estimated_after(recording: Recording, wheel: int) -> float:
    """Return the time from a wheel's fault until its effectiveness stays estimated [s]; infinity if never.

    An estimate with an error before the fault does not count: its agreement after the fault is chance.
    """
    assert recording.effectiveness is not None
    error = np.abs(recording.effectiveness - recording.true_effectiveness)[:, 0, wheel]
    onset = int(np.argmax(recording.time >= ONSETS[wheel] - 1e-9))
    wrong = np.flatnonzero(error > TOLERANCE)
    if error[onset - 1] > TOLERANCE or (len(wrong) and wrong[-1] == len(error) - 1):
        return float("inf")
    return max(0.0, float(recording.time[wrong[-1] + 1]) - ONSETS[wheel]) if len(wrong) else 0.0


def all_estimated_after(recording: Recording) -> float:
    """Return the time until the slowest of the three estimates [s]; see :func:`estimated_after`."""
    return max(estimated_after(recording, wheel) for wheel in range(3))


def estimated(recording: Recording) -> str:
    """Return the times from each fault to its estimate as text."""
    return ", ".join(f"e{wheel + 1} {seconds(estimated_after(recording, wheel))}" for wheel in range(3))


def error_before_faults(recording: Recording) -> float:
    """Return the largest error of an effectiveness before the first fault."""
    assert recording.effectiveness is not None
    early = recording.time[:-1] < ONSETS[0] - 1e-9
    return float(np.abs(recording.effectiveness - 1.0)[early, 0].max())


def rate_mismatch(recording: Recording) -> float:
    """Return the largest ``|w~|`` of the last 10 s [rad/s]."""
    assert recording.rate_mismatch is not None
    return float(np.linalg.norm(recording.rate_mismatch[recording.last()[:-1], 0], axis=1).max())


def theorem_bounds() -> tuple[float, float]:
    """Return upper bounds of c1 and c3 of Theorem 1 for the gains of Table 1, of which neither may be negative.

    Its b3 and b4, and the factor (1 + chi + ...), exceed one for all values of its free numbers a_i, and k > 0. The
    norms are those of the three rows that fit the example; the fourth can only increase them.
    """
    first, second = (float(np.linalg.norm(np.array(PRINTED_LEARNING[name]), 2)) for name in ("first", "second"))
    return min(PRINTED_LEARNING["rate_gain"]) - 1.0 - first**2, 1.0 - second**2


def quiet_from(recording: Recording) -> float:
    """Return the time from which the rate stays below 0.1 deg/s until the first fault [s]; infinity if never."""
    early = recording.time < ONSETS[0] - 1e-9
    return below_from(recording.time[early], recording.speed()[early], 0.1)


def disturbed(recording: Recording) -> tuple[list[float], bool]:
    """Return the rise of the largest rate in the 2 s after each fault [deg/s], and whether it decays in them."""
    speed, time = recording.speed(), recording.time
    raised, recovered = [], True
    for onset in ONSETS:
        before = speed[(time >= onset - 0.5) & (time < onset)].max()
        raised.append(float(max(0.0, speed[(time >= onset) & (time < onset + 2.0)].max() - before)))
        recovered &= bool(speed[(time >= onset + 1.5) & (time < onset + 2.0)].max() < before + 0.05)
    return raised, recovered


def torque_at_faults(recording: Recording) -> tuple[float, float]:
    """Return largest torque [N m] and total variation [N m/s] from the first fault to 5 s after the last."""
    start, end = ONSETS[0], ONSETS[-1] + 5.0
    window = (recording.time[:-1] >= start) & (recording.time[:-1] < end)
    return float(np.abs(recording.command[window, 0]).max()), recording.chatter(start, end)


def sliding_variable(recording: Recording, time: float) -> FloatArray:
    """Return s (T + 1, 3) [1/s] of the first spacecraft, for h1 = 0.25 and T1 [s]."""
    sigma = recording.attitude[:, 0]
    gain = PredefinedTime(0.25, time).gain(0.5 * np.einsum("ti,ti->t", sigma, sigma)[:, None])
    variable: FloatArray = mrp_derivative(sigma, recording.rate[:, 0]) + gain * sigma
    return variable


def closed_forms(recording: Recording, time: float) -> tuple[float, float]:
    """Return the times at which s is zero and the error is 0.01 deg, by the closed forms [s].

    The first starts with the flight, the second with the error at the time when s is zero:
    T (exp(-V1^h) - exp(-V0^h)) leads from V0 to V1.
    """
    position, rate = PredefinedTime(0.25, time), PredefinedTime(0.3, time)
    variable = sliding_variable(recording, time)[0]
    reached = float(rate.reaching_time(np.asarray(0.5 * (variable @ variable))))
    start = min(len(recording.time) - 1, round(reached / recording.scenario.control_period))
    sigma = recording.attitude[start, 0]
    there = float(position.reaching_time(np.asarray(0.5 * (sigma @ sigma))))
    left = float(position.reaching_time(np.array(0.5 * np.tan(np.radians(FINE) / 4.0) ** 2)))
    return reached, reached + there - left
