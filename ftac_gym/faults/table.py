"""Tables of drawn faults, the input of the plant and of the sensors."""

from __future__ import annotations

import re
from enum import IntEnum
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ftac_gym.utils.parameters import FloatArray, require


class FaultKind(IntEnum):
    """Fault kinds of this package; those from outside have a :class:`CustomKind`."""

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
        """Name of the kind in tables and plots."""
        return "healthy" if self is FaultKind.NONE else self.name.lower().replace("_", " ")


FIRST_CUSTOM_KIND = 100
"""Smallest number of a custom kind; smaller ones are the package's."""


class CustomKind(int):
    """Number and label of a fault kind from outside of the package.

    Parameters
    ----------
    number
        Number of the kind in the fault tables, 100 or more.
    label
        Name of the kind in tables and plots: lower case, letters and digits with single spaces.

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
        plain = isinstance(label, str) and re.fullmatch(r"[a-z][a-z0-9]*( [a-z0-9]+)*", label) is not None
        require(
            plain, "label", "must be lower-case words of letters and digits, with single spaces between them", label
        )
        kind = super().__new__(cls, number)
        kind.label = label
        return kind

    def __reduce__(self) -> tuple[type[CustomKind], tuple[int, str]]:
        """Return class and arguments, for copies and pickles."""
        return CustomKind, (int(self), self.label)

    def __repr__(self) -> str:
        """Return the call that makes it."""
        return f"CustomKind({int(self)}, {self.label!r})"


Kind = FaultKind | CustomKind
"""Number and label of a fault class."""

_TIMING = [("kind", "i8"), ("chain", "i8")]
_TIMING += [(name, "f8") for name in ("onset", "recovery", "period", "on_time", "rise", "fall")]

_EFFECTIVENESS = ("effectiveness", "effectiveness_amplitude", "effectiveness_frequency", "effectiveness_phase")
_BIAS = ("bias", "bias_slope", "bias_amplitude", "bias_frequency", "bias_phase", "bias_exponent")
_MECHANICAL = ("locked", "friction_forward", "friction_backward", "brake")

FAULT = np.dtype([*_TIMING, *((name, "f8") for name in (*_EFFECTIVENESS, *_BIAS, *_MECHANICAL)), ("delay", "i8")])
"""One fault of one wheel. With p in [0, 1] the part of it that is present, it changes the wheel's torque
e sat(u) + b + T_f by, for s = t - onset,

e = 1 + p (effectiveness + effectiveness_amplitude sin(effectiveness_frequency t + effectiveness_phase) - 1),
b = p (bias + bias_slope s + bias_amplitude s^bias_exponent sin(bias_frequency s + bias_phase)).

The dry part of the friction is multiplied by 1 + p (friction_forward - 1) while the wheel spins forward, and by
1 + p (friction_backward - 1) while it spins backward. ``brake`` [N m] is dry friction without a transition at rest: it
stops the wheel, and holds it there against any smaller torque. ``delay`` is the delay of a command in control periods.
With ``locked`` = 1 the wheel repeats the torque it applied last instead.

The fault acts from ``onset`` to ``recovery`` [s]. If ``period`` > 0, it acts only in the first ``on_time`` seconds of
each period counted from the onset. If ``chain`` >= 0, it acts only between the flips of that row of the switching
times, and before the first flip. The part p grows from 0 to 1 in the first ``rise`` seconds, and shrinks to 0 in the
last ``fall`` seconds before the recovery.
"""

SENSOR_FAULT = np.dtype([*_TIMING, ("rate_bias", "f8", (3,)), ("attitude_turn", "f8", (3,)), ("outage", "f8")])
"""One fault of the sensors, with the timing of FAULT.

It adds p ``rate_bias`` [rad/s] to the measured rate and turns the measured attitude by the rotation vector
p ``attitude_turn`` [rad]. With ``outage`` = 1 the star tracker delivers nothing.
"""

_FACTORS = {"effectiveness", "friction_forward", "friction_backward"}
"""Magnitudes that are one without a fault."""

_SIZES = {"effectiveness_amplitude", "bias", "bias_slope", "bias_amplitude", "rate_bias", "attitude_turn"}
"""Magnitudes that are zero without a fault."""

FLIPS = 64
"""Switching times that are drawn for a random chain."""

LONGEST_DELAY = 5
"""Largest delay of a command [control periods]; the plant stores as many commands."""


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
        """Return independent tables with the same faults."""
        return DrawnFaults(self.wheels.copy(), self.sensors.copy(), self.switches.copy())

    def take(self, index: npt.NDArray[np.int64]) -> DrawnFaults:
        """Return the faults of some of the episodes, in the order of their indices."""
        return DrawnFaults(self.wheels[index], self.sensors[index], self.switches[index])


def no_faults(count: int, wheels: int, layers: int = 1) -> npt.NDArray[np.void]:
    """Return a FAULT table (count, wheels, layers) of healthy wheels."""
    table = np.zeros((count, wheels, layers), FAULT)
    _never(table)
    for name in _FACTORS:
        table[name] = 1.0
    return table


def no_sensor_faults(count: int, faults: int = 0) -> npt.NDArray[np.void]:
    """Return a SENSOR_FAULT table (count, faults) of healthy sensors."""
    table = np.zeros((count, faults), SENSOR_FAULT)
    _never(table)
    return table


def _never(table: npt.NDArray[np.void]) -> None:
    table["onset"] = np.inf
    table["recovery"] = np.inf
    table["chain"] = -1


def scale_magnitudes(rows: npt.NDArray[np.void], severity: float) -> None:
    """Scale the magnitudes of FAULT or SENSOR_FAULT records, in place: 0 makes them those of a healthy spacecraft."""
    if severity == 1.0:
        return
    names = set(rows.dtype.names or ())
    for name in names & _FACTORS:
        rows[name] = 1.0 + severity * (rows[name] - 1.0)
    for name in names & _SIZES:
        rows[name] *= severity
