"""What the faults do to the wheels at a moment: the truth, for oracles and plots."""

from __future__ import annotations

import numpy as np

from ftac_gym.parameters import FloatArray

_TOLERANCE = 1e-9


def fault_effect(faults: np.ndarray, time: FloatArray, wheel_torque: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Evaluate the fault table.

    Parameters
    ----------
    faults
        FAULT records (N, m, layers).
    time
        (N,) time of each episode [s].
    wheel_torque
        (N, m) torque that each wheel applied last [N m], which a locked wheel repeats.

    Returns
    -------
    Effectiveness (N, m) and bias torque (N, m) [N m], so that a wheel gives effectiveness * command + bias.
    """
    now = time[:, None, None]
    with np.errstate(invalid="ignore"):
        since = np.maximum(now - faults["onset"], 0.0)
        acting = (now >= faults["onset"] - _TOLERANCE) & (now < faults["recovery"] - _TOLERANCE)
        period = np.where(faults["period"] > 0.0, faults["period"], np.inf)
        phase = since - np.floor((since + _TOLERANCE) / period) * np.where(np.isinf(period), 0.0, period)
        acting &= np.isinf(period) | (phase < faults["on_time"] - _TOLERANCE)
    angle = faults["effectiveness_frequency"] * now + faults["effectiveness_phase"]
    effectiveness = faults["effectiveness"] + faults["effectiveness_amplitude"] * np.sin(angle)
    swing = faults["bias_amplitude"] * np.sin(faults["bias_frequency"] * since + faults["bias_phase"])
    bias = faults["bias"] + faults["bias_slope"] * since + swing * since ** faults["bias_exponent"]
    locked = (acting & (faults["locked"] > 0.5)).any(axis=2)
    return (
        np.where(locked, 0.0, np.where(acting, effectiveness, 1.0).prod(axis=2)),
        np.where(locked, wheel_torque, np.where(acting, bias, 0.0).sum(axis=2)),
    )
