"""What all fault kinds have in common: when they act, and how they come and go."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from ftac_gym.faults.table import FaultKind, Kind, no_faults, no_sensor_faults
from ftac_gym.utils.parameters import FloatArray, Interval, bounds, draw, interval, positive, require

TIMING_UNIFORMS = 6
UNIFORMS_PER_FAULT = TIMING_UNIFORMS + 8
"""Uniform deviates that one fault of one episode may use: six for the timing, eight for the magnitudes."""


@dataclass(frozen=True, kw_only=True)
class Fault:
    """A fault with its time profile: abrupt or incipient, for good or recovering, steady or intermittent.

    Parameters
    ----------
    onset
        When the fault starts [s]. It takes effect at the first physics step that begins then or later.
    recovery
        When it ends for good [s]; None for never.
    duration
        How long after the onset it ends for good [s], instead of ``recovery``.
    rise
        Incipient fault: it grows in proportion to the time over this long after its onset [s]; zero is abrupt.
    fall
        It shrinks to nothing over this long before its end [s]; zero is abrupt.
    period, on_time
        If given, the fault is intermittent: it acts during the first ``on_time`` seconds of every ``period`` seconds,
        counted from the onset.
    mean_acting, mean_resting
        If given, the fault is intermittent at random: a two-state Markov chain that starts with the fault acting and
        stays in each state for an exponentially distributed time of this mean [s]. It is drawn with the episode.

    Raises
    ------
    ValueError
        If a time is negative, the recovery can precede the onset, profiles contradict each other, or a fault that is
        there whole or not at all is asked to rise or fall.
    """

    kind: ClassVar[Kind] = FaultKind.NONE
    """Number and label of the kind; :func:`~ftac_gym.faults.register` makes one of your own known."""
    gradual: ClassVar[bool] = True
    """Whether the fault can be there in part. One that cannot is made rarer, not smaller, by a low severity."""

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
        """Check and normalise the timing."""
        object.__setattr__(self, "onset", interval(self.onset, "onset"))
        require(bounds(self.onset)[0] >= 0.0, "onset", "must not be negative", self.onset)
        if self.recovery is not None:
            object.__setattr__(self, "recovery", interval(self.recovery, "recovery"))
            require(
                bounds(self.recovery)[0] > bounds(self.onset)[1],
                "recovery",
                f"must come after the onset {self.onset!r}",
                self.recovery,
            )
        if self.duration is not None:
            object.__setattr__(self, "duration", interval(self.duration, "duration"))
            positive(bounds(self.duration)[0], "duration")
            require(self.recovery is None, "duration", "must not come with recovery", self.duration)
        for name in ("rise", "fall"):
            object.__setattr__(self, name, interval(getattr(self, name), name))
            low, high = bounds(getattr(self, name))
            require(low >= 0.0, name, "must not be negative", getattr(self, name))
            rule = f"must be zero: {type(self).__name__} is there whole or not at all"
            require(self.gradual or high == 0.0, name, rule, getattr(self, name))
        ends = self.recovery is not None or self.duration is not None
        require(ends or bounds(self.fall)[1] == 0.0, "fall", "needs recovery or duration", self.fall)
        self._check_intermittency()

    def _check_intermittency(self) -> None:
        require((self.period is None) == (self.on_time is None), "on_time", "must come with period", self.on_time)
        if self.period is not None and self.on_time is not None:
            object.__setattr__(self, "period", interval(self.period, "period"))
            object.__setattr__(self, "on_time", interval(self.on_time, "on_time"))
            positive(bounds(self.on_time)[0], "on_time")
            require(
                bounds(self.on_time)[1] <= bounds(self.period)[0],
                "on_time",
                f"must not exceed the period {self.period!r}",
                self.on_time,
            )
        together = (self.mean_acting is None) == (self.mean_resting is None)
        require(together, "mean_resting", "must come with mean_acting", self.mean_resting)
        if self.mean_acting is not None and self.mean_resting is not None:
            require(self.period is None, "mean_acting", "must not come with period", self.mean_acting)
            for name in ("mean_acting", "mean_resting"):
                object.__setattr__(self, name, positive(getattr(self, name), name))

    @property
    def random_chain(self) -> bool:
        """Whether the fault switches on and off at random."""
        return self.mean_acting is not None

    def switching_times(self, onset: FloatArray, uniform: FloatArray) -> FloatArray:
        """Return the times (M, FLIPS) [s] at which the chains of M faults flip, from uniforms (M, FLIPS)."""
        means = np.resize(np.array([self.mean_acting, self.mean_resting], dtype=np.float64), uniform.shape[1])
        times: FloatArray = onset[:, None] + np.cumsum(-means * np.log1p(-uniform), axis=1)
        return times

    def _time(self, rows: npt.NDArray[np.void], uniform: FloatArray) -> None:
        """Write kind and timing into fault records (M,), from uniforms (M, TIMING_UNIFORMS)."""
        rows["kind"] = self.kind
        rows["onset"] = draw(self.onset, uniform[:, 0])
        if self.recovery is not None:
            rows["recovery"] = draw(self.recovery, uniform[:, 1])
        if self.duration is not None:
            rows["recovery"] = rows["onset"] + draw(self.duration, uniform[:, 1])
        if self.period is not None and self.on_time is not None:
            rows["period"] = draw(self.period, uniform[:, 2])
            rows["on_time"] = draw(self.on_time, uniform[:, 3])
        rows["rise"] = draw(self.rise, uniform[:, 4])
        rows["fall"] = draw(self.fall, uniform[:, 5])


@dataclass(frozen=True, kw_only=True)
class WheelFault(Fault):
    """A fault of one wheel.

    A kind of your own derives from this class, has an :class:`~ftac_gym.faults.CustomKind`, is made known with
    :func:`~ftac_gym.faults.register`, and writes what it does to the wheel into FAULT records: in a method
    ``_fill(rows, uniform, torque_limit)``, which gets records (M,) of healthy wheels with the timing filled in, uniform
    deviates (M, 8) to draw from, and the torque limits (M,) of the struck wheels [N m].

    Parameters
    ----------
    wheel
        Index of the wheel; None lets the distribution choose it.
    """

    wheel: int | None = None

    def __post_init__(self) -> None:
        """Check and normalise the fields."""
        super().__post_init__()
        if self.wheel is not None:
            is_index = isinstance(self.wheel, (int, np.integer)) and not isinstance(self.wheel, bool)
            require(is_index and self.wheel >= 0, "wheel", "must be a non-negative integer or None", self.wheel)
            object.__setattr__(self, "wheel", int(self.wheel))

    def draw(self, uniform: FloatArray, torque_limit: FloatArray) -> npt.NDArray[np.void]:
        """Draw M faults.

        Parameters
        ----------
        uniform
            (M, UNIFORMS_PER_FAULT) uniform deviates.
        torque_limit
            (M,) torque limit of the wheel that each fault strikes [N m].

        Returns
        -------
        Records of FAULT (M,).
        """
        rows = no_faults(len(uniform), 1)[:, 0, 0]
        self._time(rows, uniform)
        self._fill(rows, uniform[:, TIMING_UNIFORMS:], torque_limit)
        return rows

    def _fill(self, rows: npt.NDArray[np.void], uniform: FloatArray, torque_limit: FloatArray) -> None:
        """Write the magnitudes of this kind into FAULT records, from uniforms (M, 8)."""
        raise NotImplementedError(f"{type(self).__name__} is no concrete fault kind")


@dataclass(frozen=True, kw_only=True)
class SensorFault(Fault):
    """A fault of the sensors.

    A kind of your own is made as for :class:`WheelFault`; its method is ``_fill(rows, uniform)``, with SENSOR_FAULT
    records.
    """

    def draw(self, uniform: FloatArray) -> npt.NDArray[np.void]:
        """Draw M faults from uniform deviates (M, UNIFORMS_PER_FAULT); returns SENSOR_FAULT records (M,)."""
        rows = no_sensor_faults(len(uniform), 1)[:, 0]
        self._time(rows, uniform)
        self._fill(rows, uniform[:, TIMING_UNIFORMS:])
        return rows

    def _fill(self, rows: npt.NDArray[np.void], uniform: FloatArray) -> None:
        """Write the magnitudes of this kind into SENSOR_FAULT records, from uniforms (M, 8)."""
        raise NotImplementedError(f"{type(self).__name__} is no concrete fault kind")


def random_signs(uniform: FloatArray) -> FloatArray:
    """Turn uniform deviates into +1 and -1 with equal chances."""
    return np.where(uniform < 0.5, -1.0, 1.0)


def limited_wheels(torque_limit: FloatArray, kind: str) -> None:
    """Raise a ValueError unless all struck wheels have a torque limit, in which the kind measures its size."""
    limited = bool(np.isfinite(torque_limit).all())
    require(limited, kind, "needs wheels with a torque limit; torque_limit", torque_limit.tolist())
