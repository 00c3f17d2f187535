"""The drawn fault table: what the plant reads."""

from __future__ import annotations

from enum import IntEnum

import numpy as np


class FaultKind(IntEnum):
    """What is wrong with a wheel."""

    NONE = 0
    LOSS_OF_EFFECTIVENESS = 1
    BIAS = 2
    OUTAGE = 3
    LOCK_IN_PLACE = 4
    HARD_OVER = 5

    @property
    def label(self) -> str:
        """The kind in words, for tables and plots."""
        return "healthy" if self is FaultKind.NONE else self.name.lower().replace("_", " ")


FAULT = np.dtype(
    [
        ("kind", "i8"),
        ("onset", "f8"),
        ("recovery", "f8"),
        ("period", "f8"),
        ("on_time", "f8"),
        ("effectiveness", "f8"),
        ("effectiveness_amplitude", "f8"),
        ("effectiveness_frequency", "f8"),
        ("effectiveness_phase", "f8"),
        ("bias", "f8"),
        ("bias_slope", "f8"),
        ("bias_amplitude", "f8"),
        ("bias_frequency", "f8"),
        ("bias_phase", "f8"),
        ("bias_exponent", "f8"),
        ("locked", "f8"),
    ]
)
"""One fault of one wheel. While it acts the wheel gives e sat(u) + b with, for s = t - onset,

e = effectiveness + effectiveness_amplitude sin(effectiveness_frequency t + effectiveness_phase),
b = bias + bias_slope s + bias_amplitude s^bias_exponent sin(bias_frequency s + bias_phase).

It acts from ``onset`` to ``recovery`` [s]; if ``period`` > 0, only in the first ``on_time`` seconds of each period
counted from the onset. ``locked`` = 1 makes the wheel repeat the torque it applied last instead.
"""


def no_faults(craft: int, wheels: int, layers: int = 1) -> np.ndarray:
    """Return a table (craft, wheels, layers) of healthy wheels."""
    table = np.zeros((craft, wheels, layers), FAULT)
    table["onset"] = np.inf
    table["recovery"] = np.inf
    table["effectiveness"] = 1.0
    return table
