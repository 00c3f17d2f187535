"""Measures behind the claims of Zhang and Zhou 2019."""

from __future__ import annotations

import numpy as np

from ftac_gym.reproduction.recordings import Recording
from ftac_gym.utils.parameters import FloatArray

EFFECTIVENESS, BIAS = 0.5, 0.06
"""True e1, and true b2 [N m]."""


def visible_bias(recording: Recording) -> float:
    """Return the part of the true b2 that acts along the wheels' axes, and can thus be estimated [N m]."""
    axes = recording.scenario.spacecraft.wheels.axis_matrix
    return float((np.linalg.pinv(axes) @ axes)[1, 1]) * BIAS


def late_estimates(recording: Recording) -> tuple[FloatArray, FloatArray]:
    """Return e1^ and b2^ [N m] of the last 10 s."""
    assert recording.effectiveness is not None and recording.bias is not None
    late = recording.last()[:-1]
    return recording.effectiveness[late, 0, 0], recording.bias[late, 0, 1]


def estimated(recording: Recording) -> str:
    """Return the ranges of e1^ and b2^ in the last 10 s as text."""
    share, bias = late_estimates(recording)
    return f"e1 {share.min():.2f} to {share.max():.2f}, b2 {bias.min():.3f} to {bias.max():.3f} N m"


def estimates_hold(recording: Recording) -> bool:
    """Test for e1^ within 0.05 and b2^ within a fifth of its visible part in the last 10 s."""
    share, bias = late_estimates(recording)
    visible = visible_bias(recording)
    return bool(np.abs(share - EFFECTIVENESS).max() < 0.05 and np.abs(bias - visible).max() < 0.2 * visible)


def rate_mismatch(recording: Recording) -> float:
    """Return the largest ``|w~|_1`` after the first second [rad/s]."""
    assert recording.rate_mismatch is not None
    return float(np.abs(recording.rate_mismatch[recording.time[:-1] > 1.0]).sum(axis=2).max())


def earlier(first: Recording, second: Recording) -> bool:
    """Test for the first to settle at least 5 % earlier than the second."""
    return first.settling(0.1) < 0.95 * second.settling(0.1)


def more_precise(first: Recording, second: Recording) -> bool:
    """Test for the first to settle earlier than the second, and to a smaller error."""
    return first.settling(0.1) < second.settling(0.1) and first.steady() < second.steady()
