"""Time profiles and magnitudes, the parts that all fault kinds share."""

import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from ftac_gym.faults.checking import check_records
from ftac_gym.faults.table import CustomKind, FaultKind, Kind, no_faults, no_sensor_faults
from ftac_gym.spacecraft.wheel_array import WheelArray
from ftac_gym.utils.parameters import (
    FloatArray,
    Interval,
    bounds,
    draw,
    fields_named,
    interval,
    is_whole,
    non_negative_interval,
    normalise,
    optional,
    positive,
    positive_interval,
    require,
)

TIMING_UNIFORMS = 6
UNIFORMS_PER_FAULT = TIMING_UNIFORMS + 8
"""Uniform deviates that one fault of one episode may use: six for the timing, eight for the magnitudes."""


@dataclass(frozen=True)
class Magnitude:
    """Record field that the draws of a magnitude are written to, and the range of its values.

    Attributes
    ----------
    record
        Field of the fault records; empty if the kind writes the magnitude itself.
    low, high
        Bounds of the values, both included.
    above
        Bound that the values exceed.
    """

    record: str = ""
    low: float = -math.inf
    high: float = math.inf
    above: float = -math.inf


def magnitude(record: str = "", **limits: float) -> dict[str, Magnitude]:
    """Return the metadata of a dataclass field that is a magnitude; the parameters are those of :class:`Magnitude`."""
    return {"magnitude": Magnitude(record, **limits)}


@dataclass(frozen=True, kw_only=True)
class Fault:
    """A fault with its time profile: abrupt or incipient, permanent or recovering, steady or intermittent.

    Parameters
    ----------
    onset
        Start of the fault [s]. It takes effect at the first physics step that begins then or later.
    recovery
        Permanent end of the fault [s]; None for never.
    duration
        Time from the onset to the permanent end [s], instead of ``recovery``.
    rise
        Time after the onset over which the fault grows in proportion to time [s]; zero is abrupt.
    fall
        Time before the end over which the fault shrinks to nothing [s]; zero is abrupt.
    period, on_time
        If given, the fault is intermittent: it acts during the first ``on_time`` seconds of every ``period`` seconds,
        counted from the onset.
    mean_acting, mean_resting
        If given, the fault is intermittent at random: a two-state Markov chain that starts with the fault acting. It
        stays in each state for an exponentially distributed time of this mean [s], drawn with the episode.

    Raises
    ------
    ValueError
        If a time is negative, the recovery can precede the onset, or profiles contradict each other. Also if a fault
        that is not gradual has a rise or a fall, or a magnitude of a kind can leave its range.
    """

    kind: ClassVar[Kind] = FaultKind.NONE
    """Number and label of the kind; :func:`~ftac_gym.faults.register` registers a custom one."""
    gradual: ClassVar[bool] = True
    """Flag of a fault that can be present in part. A low severity makes other faults rarer, not smaller."""
    constants: ClassVar[Mapping[str, float]] = {}
    """Record fields with the same value in every fault of the kind."""

    onset: Interval = 0.0
    recovery: Interval | None = None
    duration: Interval | None = None
    rise: Interval = 0.0
    fall: Interval = 0.0
    period: Interval | None = None
    on_time: Interval | None = None
    mean_acting: float | None = None
    mean_resting: float | None = None

    def __post_init__(self) -> None:
        """Check and normalise timing and magnitudes."""
        normalise(self, non_negative_interval, "onset", "rise", "fall")
        normalise(self, optional(interval), "recovery", "period")
        normalise(self, optional(positive_interval), "duration", "on_time")
        normalise(self, optional(positive), "mean_acting", "mean_resting")
        for name, entry in self._magnitudes.items():
            checked = interval(getattr(self, name), name, entry.low, entry.high, entry.above)
            object.__setattr__(self, name, checked)
        if self.recovery is not None:
            later = bounds(self.recovery)[0] > bounds(self.onset)[1]
            require(later, "recovery", f"must come after the onset {self.onset!r}", self.recovery)
            require(self.duration is None, "duration", "must not come with recovery", self.duration)
        for name in ("rise", "fall"):
            abrupt = bounds(getattr(self, name))[1] == 0.0
            rule = f"must be zero: {type(self).__name__} is there whole or not at all"
            require(self.gradual or abrupt, name, rule, getattr(self, name))
        ends = self.recovery is not None or self.duration is not None
        require(ends or bounds(self.fall)[1] == 0.0, "fall", "needs recovery or duration", self.fall)
        require((self.period is None) == (self.on_time is None), "on_time", "must come with period", self.on_time)
        if self.period is not None and self.on_time is not None:
            shorter = bounds(self.on_time)[1] <= bounds(self.period)[0]
            require(shorter, "on_time", f"must not exceed the period {self.period!r}", self.on_time)
        together = (self.mean_acting is None) == (self.mean_resting is None)
        require(together, "mean_resting", "must come with mean_acting", self.mean_resting)
        alone = self.period is None or self.mean_acting is None
        require(alone, "mean_acting", "must not come with period", self.mean_acting)

    @cached_property
    def _magnitudes(self) -> dict[str, Magnitude]:
        """Magnitudes by field, in the order in which they use uniform deviates."""
        metadata = {item.name: item.metadata for item in dataclasses.fields(self)}
        return {name: entry["magnitude"] for name, entry in metadata.items() if "magnitude" in entry}

    def check(self, wheels: WheelArray) -> None:
        """Raise a ValueError unless the fault fits an array of wheels."""

    @property
    def random_chain(self) -> bool:
        """Flag of a fault that switches on and off at random."""
        return self.mean_acting is not None

    def switching_times(self, onset: FloatArray, uniform: FloatArray) -> FloatArray:
        """Return the times (M, FLIPS) [s] at which the chains of M faults flip, from uniforms (M, FLIPS)."""
        means = np.resize(np.array([self.mean_acting, self.mean_resting], dtype=np.float64), uniform.shape[1])
        return onset[:, None] + np.cumsum(-means * np.log1p(-uniform), axis=1)

    def draw(self, uniform: FloatArray, torque_limit: FloatArray) -> npt.NDArray[np.void]:
        """Draw M faults.

        Parameters
        ----------
        uniform
            (M, UNIFORMS_PER_FAULT) uniform deviates.
        torque_limit
            (M,) torque limit of the affected wheels [N m]; faults of the sensors do not use it.

        Returns
        -------
        Records (M,) of FAULT for faults of wheels, of SENSOR_FAULT for those of the sensors.
        """
        raise NotImplementedError(f"{type(self).__name__} is no concrete fault kind")

    def _draw_common(self, rows: npt.NDArray[np.void], uniform: FloatArray) -> None:
        """Write kind, timing, constants and magnitudes into records (M,), from uniforms (M, UNIFORMS_PER_FAULT)."""
        rows["kind"] = self.kind
        for index, name in enumerate(("onset", "recovery", "period", "on_time", "rise", "fall")):
            if (value := getattr(self, name)) is not None:
                rows[name] = draw(value, uniform[:, index])
        if self.duration is not None:
            rows["recovery"] = rows["onset"] + draw(self.duration, uniform[:, 1])
        for record, value in self.constants.items():
            rows[record] = value
        for index, (name, entry) in enumerate(self._magnitudes.items()):
            if entry.record:
                rows[entry.record] = draw(getattr(self, name), uniform[:, TIMING_UNIFORMS + index])

    def _check_drawn(self, rows: npt.NDArray[np.void]) -> None:
        """Check the records (M,) of a kind from outside, whose ``_fill`` may write anything."""
        if isinstance(self.kind, CustomKind):
            check_records(rows, type(self).__name__)


@dataclass(frozen=True, kw_only=True)
class WheelFault(Fault):
    """A fault of one wheel.

    A custom kind derives from this class, has a :class:`~ftac_gym.faults.CustomKind`, and is registered with
    :func:`~ftac_gym.faults.register`. It writes its effect on the wheel into FAULT records in a method
    ``_fill(rows, uniform, torque_limit)``. The records (M,) are those of healthy wheels with the timing filled in. The
    uniform deviates are (M, 8), the torque limits of the affected wheels (M,) [N m].

    Parameters
    ----------
    wheel
        Index of the wheel; with None the distribution draws it.
    """

    wheel: int | None = None

    def __post_init__(self) -> None:
        """Check and normalise the fields."""
        super().__post_init__()
        if self.wheel is not None:
            require(
                is_whole(self.wheel) and self.wheel >= 0, "wheel", "must be a non-negative integer or None", self.wheel
            )
            object.__setattr__(self, "wheel", int(self.wheel))

    def check(self, wheels: WheelArray) -> None:
        """Raise a ValueError unless the fault fits an array of wheels."""
        if self.wheel is not None:
            rule = f"must be below the number of wheels, {wheels.count}"
            require(self.wheel < wheels.count, "wheel", rule, self.wheel)

    def draw(self, uniform: FloatArray, torque_limit: FloatArray) -> npt.NDArray[np.void]:
        """Draw M faults as FAULT records (M,); see :meth:`Fault.draw`."""
        rows = no_faults(len(uniform), 1)[:, 0, 0]
        self._draw_common(rows, uniform)
        self._fill(rows, uniform[:, TIMING_UNIFORMS:], torque_limit)
        self._check_drawn(rows)
        return rows

    def _fill(self, rows: npt.NDArray[np.void], uniform: FloatArray, torque_limit: FloatArray) -> None:
        """Write the part of the effect that follows from neither constants nor magnitudes into FAULT records (M,)."""


@dataclass(frozen=True, kw_only=True)
class SensorFault(Fault):
    """A fault of the sensors.

    A custom kind is made as for :class:`WheelFault`; its method is ``_fill(rows, uniform)``, with SENSOR_FAULT records.
    """

    def draw(self, uniform: FloatArray, torque_limit: FloatArray | None = None) -> npt.NDArray[np.void]:
        """Draw M faults as SENSOR_FAULT records (M,); see :meth:`Fault.draw`."""
        rows = no_sensor_faults(len(uniform), 1)[:, 0]
        self._draw_common(rows, uniform)
        self._fill(rows, uniform[:, TIMING_UNIFORMS:])
        self._check_drawn(rows)
        return rows

    def _fill(self, rows: npt.NDArray[np.void], uniform: FloatArray) -> None:
        """Write the part of the effect that follows from neither constants nor magnitudes into records (M,)."""


def check_all(faults: Sequence[Fault], wheels: WheelArray, field: str) -> None:
    """Raise a ValueError unless all faults of a field fit an array of wheels; the message has the place of the fault.

    Parameters
    ----------
    faults
        The faults.
    wheels
        The wheel array, whose ``friction`` a fault can need.
    field
        Name of the field that holds them.
    """
    for index, fault in enumerate(faults):
        with fields_named(f"{field}[{index}].", friction="friction"):
            fault.check(wheels)
