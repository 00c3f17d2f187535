"""The drawn fault tables: what the plant and the sensors read."""

from __future__ import annotations

import re
from enum import IntEnum
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ftac_gym.utils.parameters import FloatArray, require


class FaultKind(IntEnum):
    """What is wrong, of the kinds of this package; those from outside have an :class:`CustomKind`."""

    NONE = 0
    LOSS_OF_EFFECTIVENESS = 1
    BIAS = 2
    OUTAGE = 3
    LOCK_IN_PLACE = 4
    HARD_OVER = 5
    DRIFTING_EFFECTIVENESS = 6
    FRICTION_RISE = 7
    SEIZURE = 8
    INTERMITTENT_SHUTDOWN = 9
    COMMAND_DELAY = 10
    GYRO_BIAS_STEP = 11
    STAR_TRACKER_OUTAGE = 12
    ATTITUDE_SPIKE = 13

    @property
    def label(self) -> str:
        """The kind in words, for tables and plots."""
        return "healthy" if self is FaultKind.NONE else self.name.lower().replace("_", " ")


FIRST_CUSTOM_KIND = 100
"""The smallest number that a kind from outside of the package may have: smaller ones are the package's."""


class CustomKind(int):
    """Number and label of a fault kind from outside of the package.

    Parameters
    ----------
    number
        What stands for the kind in the fault tables, 100 or more.
    label
        The kind in words, for tables and plots: lower case, letters and digits with single spaces.

    Raises
    ------
    ValueError
        If the number is one of the package's, or the label has another form.
    """

    label: str

    def __new__(cls, number: int, label: str) -> CustomKind:
        """Check number and label."""
        whole = isinstance(number, int) and not isinstance(number, bool)
        require(whole and number >= FIRST_CUSTOM_KIND, "number", f"must be {FIRST_CUSTOM_KIND} or more", number)
        require(number < 2**31, "number", "must be below 2**31", number)
        rule = "must be lower-case words of letters and digits, with single spaces between them"
        require(
            isinstance(label, str) and re.fullmatch(r"[a-z][a-z0-9]*( [a-z0-9]+)*", label) is not None,
            "label",
            rule,
            label,
        )
        kind = super().__new__(cls, number)
        kind.label = label
        return kind

    def __reduce__(self) -> tuple[type[CustomKind], tuple[int, str]]:
        """Return what makes it again, for copies and pickles."""
        return CustomKind, (int(self), self.label)

    def __repr__(self) -> str:
        """Return how it is written."""
        return f"CustomKind({int(self)}, {self.label!r})"


Kind = FaultKind | CustomKind
"""What a fault class says of itself."""

_TIMING: list[tuple[str, str]] = [
    ("kind", "i8"),
    ("chain", "i8"),
    ("onset", "f8"),
    ("recovery", "f8"),
    ("period", "f8"),
    ("on_time", "f8"),
    ("rise", "f8"),
    ("fall", "f8"),
]

FAULT = np.dtype(
    [
        *_TIMING,
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
        ("friction_forward", "f8"),
        ("friction_backward", "f8"),
        ("brake", "f8"),
        ("delay", "i8"),
    ]
)
"""One fault of one wheel. With p in [0, 1] the part of it that is there, it changes the wheel's torque
e sat(u) + b + T_f by, for s = t - onset,

e = 1 + p (effectiveness + effectiveness_amplitude sin(effectiveness_frequency t + effectiveness_phase) - 1),
b = p (bias + bias_slope s + bias_amplitude s^bias_exponent sin(bias_frequency s + bias_phase)).

The dry part of the friction is multiplied by 1 + p (friction_forward - 1) while the wheel spins forward, and by
1 + p (friction_backward - 1) while it spins backward. ``brake`` [N m] is dry friction without a transition at rest: it
stops the wheel, and holds it there against any smaller torque. ``delay`` is how many control periods a command is late.
``locked`` = 1 makes the wheel repeat the torque it applied last instead.

It acts from ``onset`` to ``recovery`` [s]; if ``period`` > 0, only in the first ``on_time`` seconds of each period
counted from the onset; if ``chain`` >= 0, only between the flips of that row of the switching times (it acts before the
first flip). p grows from 0 to 1 in the first ``rise`` seconds and shrinks to 0 in the last ``fall`` seconds before the
recovery.
"""

SENSOR_FAULT = np.dtype([*_TIMING, ("rate_bias", "f8", (3,)), ("attitude_turn", "f8", (3,)), ("outage", "f8")])
"""One fault of the sensors, with the timing of FAULT: it adds ``rate_bias`` [rad/s] to the measured rate and turns the
measured attitude by the rotation vector ``attitude_turn`` [rad], both times p; ``outage`` = 1 blinds the star tracker.
"""

FLIPS = 64
"""Switching times that are drawn for a random chain."""


class DrawnFaults(NamedTuple):
    """The faults of N episodes.

    Attributes
    ----------
    wheels
        FAULT records (N, m, layers).
    sensors
        SENSOR_FAULT records (N, faults); no columns where the source has no sensor faults.
    switches
        (N, chains, FLIPS) increasing times [s] at which random chains flip; no chains where no fault has one.
    """

    wheels: npt.NDArray[np.void]
    sensors: npt.NDArray[np.void]
    switches: FloatArray

    def copy(self) -> DrawnFaults:
        """Return tables of their own with the same faults."""
        return DrawnFaults(self.wheels.copy(), self.sensors.copy(), self.switches.copy())

    def take(self, index: npt.NDArray[np.int64]) -> DrawnFaults:
        """Return the faults of some of the episodes, in the order of their indices."""
        return DrawnFaults(self.wheels[index], self.sensors[index], self.switches[index])


def no_faults(craft: int, wheels: int, layers: int = 1) -> npt.NDArray[np.void]:
    """Return a FAULT table (craft, wheels, layers) of healthy wheels."""
    table = np.zeros((craft, wheels, layers), FAULT)
    _never(table)
    for name in ("effectiveness", "friction_forward", "friction_backward"):
        table[name] = 1.0
    return table


def no_sensor_faults(craft: int, faults: int = 0) -> npt.NDArray[np.void]:
    """Return a SENSOR_FAULT table (craft, faults) of healthy sensors."""
    table = np.zeros((craft, faults), SENSOR_FAULT)
    _never(table)
    return table


def healthy(craft: int, wheels: int) -> DrawnFaults:
    """Return the tables of craft without faults."""
    return DrawnFaults(no_faults(craft, wheels), no_sensor_faults(craft), np.zeros((craft, 0, FLIPS)))


def _never(table: npt.NDArray[np.void]) -> None:
    table["onset"] = np.inf
    table["recovery"] = np.inf
    table["chain"] = -1


def scale_magnitudes(rows: npt.NDArray[np.void], severity: float) -> None:
    """Shrink the magnitudes of FAULT or SENSOR_FAULT records towards those of a healthy craft, in place."""
    if severity == 1.0:
        return
    names = rows.dtype.names or ()
    for name in ("effectiveness", "friction_forward", "friction_backward"):
        if name in names:
            rows[name] = 1.0 + severity * (rows[name] - 1.0)
    for name in (
        "effectiveness_amplitude", "bias", "bias_slope", "bias_amplitude", "rate_bias", "attitude_turn",
    ):  # fmt: skip
        if name in names:
            rows[name] *= severity
