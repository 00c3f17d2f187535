"""Attitude commands, with their rates and accelerations.

Each kind of reference fills two record arrays that the plant reads: REFERENCE (N,) and SET_POINT (N, points).
"""

import math
from dataclasses import dataclass
from enum import IntEnum
from itertools import pairwise
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from ftac_gym.utils.parameters import (
    FloatArray,
    Intervals,
    Matrix,
    Vector,
    draw_axes,
    intervals,
    largest,
    normalise,
    require,
    unit_quaternion,
    vector,
)
from ftac_gym.utils.serialization import serializable


class ReferenceKind(IntEnum):
    """Kind of reference; the plant evaluates all but the sampled one, which the simulator has as a table."""

    SET_POINTS = 0
    MRP_SINUSOID = 1
    RATE_PROFILE = 2
    SAMPLED = 3


_SINUSOID = ("constant", "amplitude", "frequency", "phase")
REFERENCE = np.dtype([("kind", "i8"), ("attitude", "f8", (4,)), *((name, "f8", (3,)) for name in _SINUSOID)])
SET_POINT = np.dtype([("time", "f8"), ("attitude", "f8", (4,))])
References = tuple[npt.NDArray[np.void], npt.NDArray[np.void]]
"""REFERENCE records (N,) and SET_POINT records (N, points)."""

IDENTITY: Vector = (1.0, 0.0, 0.0, 0.0)


@serializable
@dataclass(frozen=True)
class SetPoints:
    """Fixed attitudes, one after the other.

    Parameters
    ----------
    attitudes
        The quaternions, one or more.
    times
        Times at which they become the command [s]; the first is 0.

    Raises
    ------
    ValueError
        If the times do not start at 0, do not increase, or do not match the attitudes.
    """

    attitudes: Matrix = (IDENTITY,)
    times: Vector = (0.0,)

    def __post_init__(self) -> None:
        """Check and normalise the fields."""
        listed = isinstance(self.attitudes, (tuple, list, np.ndarray))
        require(listed, "attitudes", "must be a list of quaternions", self.attitudes)
        checked = tuple(unit_quaternion(value, f"attitudes[{index}]") for index, value in enumerate(self.attitudes))
        object.__setattr__(self, "attitudes", checked)
        times = vector(self.times, None, "times")
        object.__setattr__(self, "times", times)
        require(len(times) == len(checked) > 0, "times", f"must match the {len(checked)} attitudes", times)
        increasing = all(later > earlier for earlier, later in pairwise(times))
        require(times[0] == 0.0 and increasing, "times", "must start at 0 and increase", times)

    @property
    def moving(self) -> bool:
        """True for a reference that has a rate."""
        return False

    @property
    def largest_rate(self) -> float:
        """Bound on the rate of the reference [rad/s]."""
        return 0.0

    @property
    def uniform_count(self) -> int:
        """Number of uniform deviates of one episode."""
        return 1

    def draw(self, uniform: FloatArray) -> References:
        """Fill the records of N spacecraft."""
        reference = np.zeros(len(uniform), REFERENCE)
        reference["kind"] = ReferenceKind.SET_POINTS
        reference["attitude"] = self.attitudes[0]
        points = np.zeros((len(uniform), len(self.times)), SET_POINT)
        points["time"] = self.times
        points["attitude"] = self.attitudes
        return reference, points


@dataclass(frozen=True)
class _Sinusoid:
    """Three components, each constant + amplitude sin(frequency t + phase)."""

    amplitude: Intervals
    frequency: Intervals
    constant: Intervals = (0.0, 0.0, 0.0)
    phase: Intervals = (0.0, 0.0, 0.0)

    _kind: ClassVar[ReferenceKind]

    def __post_init__(self) -> None:
        """Check and normalise the fields."""
        normalise(self, intervals, *_SINUSOID)

    @property
    def moving(self) -> bool:
        """True for a reference that has a rate."""
        return True

    @property
    def uniform_count(self) -> int:
        """Number of uniform deviates of one episode."""
        return 12

    def draw(self, uniform: FloatArray) -> References:
        """Fill the records of N spacecraft."""
        reference, points = np.zeros(len(uniform), REFERENCE), np.zeros((len(uniform), 1), SET_POINT)
        reference["kind"] = self._kind
        reference["attitude"] = points["attitude"] = getattr(self, "attitude", IDENTITY)
        for index, name in enumerate(_SINUSOID):
            reference[name] = draw_axes(getattr(self, name), uniform[:, 3 * index : 3 * index + 3])
        return reference, points


@serializable
@dataclass(frozen=True)
class MRPSinusoid(_Sinusoid):
    """Modified Rodrigues parameters sigma_d = constant + amplitude sin(frequency t + phase), axis by axis.

    Rates and accelerations are exact: w_d = G^-1 sigma_d', w_d' = G^-1 (sigma_d'' - G' w_d).

    Parameters
    ----------
    amplitude, constant
        Dimensionless, per component.
    frequency
        [rad/s], per component.
    phase
        [rad], per component.
    """

    _kind = ReferenceKind.MRP_SINUSOID

    @property
    def largest_rate(self) -> float:
        """Bound on the rate of the reference [rad/s]: at most four times that of the parameters."""
        return 4.0 * math.hypot(*(largest(a) * largest(f) for a, f in zip(self.amplitude, self.frequency, strict=True)))


@serializable
@dataclass(frozen=True)
class RateProfile(_Sinusoid):
    """Reference rate w_d = constant + amplitude sin(frequency t + phase) in the reference frame's own axes.

    The reference attitude is integrated from ``attitude`` with the plant's step and method (Ma et al. 2023).

    Parameters
    ----------
    amplitude, constant
        [rad/s], per axis.
    frequency
        [rad/s], per axis.
    phase
        [rad], per axis.
    attitude
        Reference attitude at time zero.
    """

    attitude: Vector = IDENTITY

    _kind = ReferenceKind.RATE_PROFILE

    def __post_init__(self) -> None:
        """Check and normalise the fields."""
        super().__post_init__()
        normalise(self, unit_quaternion, "attitude")

    @property
    def largest_rate(self) -> float:
        """Bound on the rate of the reference [rad/s]."""
        return math.hypot(*(largest(c) + largest(a) for c, a in zip(self.constant, self.amplitude, strict=True)))


def fixed_attitude(attitude: Vector = IDENTITY) -> SetPoints:
    """Return the reference that holds one attitude."""
    return SetPoints((attitude,), (0.0,))
