"""Attitude commands: where the craft shall point, how fast that turns, and how that rate changes.

Each kind of reference fills two record arrays that the plant reads: REFERENCE (N,) and SET_POINT (N, points).
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from ftac_gym.utils.parameters import (
    FloatArray,
    Intervals,
    Matrix,
    Vector,
    draw_axes,
    intervals,
    require,
    unit_quaternion,
)
from ftac_gym.utils.serialization import serializable


class ReferenceKind(IntEnum):
    """How the plant evaluates a reference."""

    SET_POINTS = 0
    MRP_SINUSOID = 1
    RATE_PROFILE = 2


REFERENCE = np.dtype(
    [
        ("kind", "i8"),
        ("attitude", "f8", (4,)),
        ("constant", "f8", (3,)),
        ("amplitude", "f8", (3,)),
        ("frequency", "f8", (3,)),
        ("phase", "f8", (3,)),
    ]
)
SET_POINT = np.dtype([("time", "f8"), ("attitude", "f8", (4,))])

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
        When each becomes the command [s]; the first is 0.

    Raises
    ------
    ValueError
        If the times do not start at 0, do not increase, or do not match the attitudes.
    """

    attitudes: Matrix = (IDENTITY,)
    times: Vector = (0.0,)

    def __post_init__(self) -> None:
        """Check and normalise the fields."""
        checked = tuple(unit_quaternion(value, f"attitudes[{index}]") for index, value in enumerate(self.attitudes))
        object.__setattr__(self, "attitudes", checked)
        times = tuple(float(value) for value in self.times)
        object.__setattr__(self, "times", times)
        require(len(times) == len(checked) > 0, "times", f"must match the {len(checked)} attitudes", times)
        increasing = all(later > earlier for earlier, later in pairwise(times))
        require(times[0] == 0.0 and increasing, "times", "must start at 0 and increase", times)

    @property
    def moving(self) -> bool:
        """Whether the reference has a rate."""
        return False

    @property
    def uniform_count(self) -> int:
        """How many uniform deviates one episode needs."""
        return 1

    def draw(self, uniform: FloatArray) -> tuple[npt.NDArray[np.void], npt.NDArray[np.void]]:
        """Fill the records of N craft."""
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

    def __post_init__(self) -> None:
        """Check and normalise the fields."""
        for name in ("constant", "amplitude", "frequency", "phase"):
            object.__setattr__(self, name, intervals(getattr(self, name), name))

    @property
    def moving(self) -> bool:
        """Whether the reference has a rate."""
        return True

    @property
    def uniform_count(self) -> int:
        """How many uniform deviates one episode needs."""
        return 12

    def _fill(
        self, kind: ReferenceKind, uniform: FloatArray, start: Vector
    ) -> tuple[npt.NDArray[np.void], npt.NDArray[np.void]]:
        reference = np.zeros(len(uniform), REFERENCE)
        reference["kind"] = kind
        reference["attitude"] = start
        for index, name in enumerate(("constant", "amplitude", "frequency", "phase")):
            reference[name] = draw_axes(getattr(self, name), uniform[:, 3 * index : 3 * index + 3])
        points = np.zeros((len(uniform), 1), SET_POINT)
        points["attitude"] = start
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

    def draw(self, uniform: FloatArray) -> tuple[npt.NDArray[np.void], npt.NDArray[np.void]]:
        """Fill the records of N craft."""
        return self._fill(ReferenceKind.MRP_SINUSOID, uniform, IDENTITY)


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

    def __post_init__(self) -> None:
        """Check and normalise the fields."""
        super().__post_init__()
        object.__setattr__(self, "attitude", unit_quaternion(self.attitude, "attitude"))

    def draw(self, uniform: FloatArray) -> tuple[npt.NDArray[np.void], npt.NDArray[np.void]]:
        """Fill the records of N craft."""
        return self._fill(ReferenceKind.RATE_PROFILE, uniform, self.attitude)


def fixed_attitude(attitude: Vector = IDENTITY) -> SetPoints:
    """Return the reference that holds one attitude for ever."""
    return SetPoints((attitude,), (0.0,))


Reference = SetPoints | MRPSinusoid | RateProfile
