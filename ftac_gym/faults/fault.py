"""What all fault kinds have in common: which wheel, and when."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ftac_gym.faults.table import FaultKind, no_faults
from ftac_gym.parameters import FloatArray, Interval, bounds, draw, interval, positive, require

UNIFORMS_PER_FAULT = 12
"""Uniform deviates that one fault of one episode may use: four for the timing, eight for the magnitudes."""


@dataclass(frozen=True, kw_only=True)
class Fault:
    """A fault of one wheel, with its time profile.

    Parameters
    ----------
    wheel
        Index of the wheel; None lets the distribution choose it.
    onset
        When the fault starts [s]. It takes effect at the first physics step that begins then or later.
    recovery
        When it ends for good [s]; None for never.
    period, on_time
        If given, the fault is intermittent: it acts during the first ``on_time`` seconds of every ``period`` seconds,
        counted from the onset.

    Raises
    ------
    ValueError
        If the wheel index or a time is negative, the recovery can precede the onset, or ``on_time`` exceeds
        ``period`` or comes without it.
    """

    kind: ClassVar[FaultKind] = FaultKind.NONE

    wheel: int | None = None
    onset: Interval = 0.0
    recovery: Interval | None = None
    period: Interval | None = None
    on_time: Interval | None = None

    def __post_init__(self) -> None:
        """Check and normalise the timing."""
        if self.wheel is not None:
            is_index = isinstance(self.wheel, (int, np.integer)) and not isinstance(self.wheel, bool)
            require(is_index and self.wheel >= 0, "wheel", "must be a non-negative integer or None", self.wheel)
            object.__setattr__(self, "wheel", int(self.wheel))
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

    def draw(self, uniform: FloatArray, torque_limit: FloatArray) -> np.ndarray:
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
        rows["kind"] = self.kind
        rows["onset"] = draw(self.onset, uniform[:, 0])
        if self.recovery is not None:
            rows["recovery"] = draw(self.recovery, uniform[:, 1])
        if self.period is not None and self.on_time is not None:
            rows["period"] = draw(self.period, uniform[:, 2])
            rows["on_time"] = draw(self.on_time, uniform[:, 3])
        self._fill(rows, uniform[:, 4:], torque_limit)
        return rows

    def _fill(self, rows: np.ndarray, uniform: FloatArray, torque_limit: FloatArray) -> None:
        """Write the magnitudes of this kind into FAULT records, from uniforms (M, 8)."""
        raise NotImplementedError(f"{type(self).__name__} is no concrete fault kind")


def random_signs(uniform: FloatArray) -> FloatArray:
    """Turn uniform deviates into +1 and -1 with equal chances."""
    return np.where(uniform < 0.5, -1.0, 1.0)
