"""Attitude commands from samples: a trajectory of the user's own, with rates and accelerations by a spline."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ftac_gym.task.references import REFERENCE, SET_POINT, ReferenceKind, References
from ftac_gym.utils.files import reading
from ftac_gym.utils.parameters import FloatArray, Matrix, Vector, require, unit_quaternion, vector
from ftac_gym.utils.serialization import reads_as_number, serializable

if TYPE_CHECKING:
    from scipy.spatial.transform import RotationSpline

LARGEST_TURN = math.pi / 2.0
"""Limit of the turn from one sample to the next [rad]: there is no doubt about the way between them."""

MOST_SAMPLES = 20_000
"""Limit of the samples, which are part of the scenario's JSON."""

COLUMNS = "time, q0, q1, q2, q3"
"""Columns of a file: time [s], and the quaternion, scalar first."""


@serializable
@dataclass(frozen=True)
class SampledReference:
    """A trajectory through samples of the attitude.

    Between the samples the attitude is SciPy's ``RotationSpline``: attitude, rate and acceleration are continuous. The
    rate is that of the spline, so that q' = 1/2 q (x) [0, w_d] holds; the acceleration is its derivative, zero at both
    ends. An episode may not be longer than the samples. A simulator that goes on after the last sample has a reference
    at rest there.

    Parameters
    ----------
    times
        Times of the samples [s], two or more, rising from 0.
    attitudes
        One unit quaternion for each, scalar first, of either sign. Neighbours differ by a quarter turn at most.

    Raises
    ------
    ValueError
        If times and attitudes do not match, or break one of these rules.
    """

    times: Vector
    attitudes: Matrix

    def __post_init__(self) -> None:
        """Check and normalise the fields."""
        times = vector(self.times, None, "times")
        object.__setattr__(self, "times", times)
        require(2 <= len(times) <= MOST_SAMPLES, "times", f"must have 2 to {MOST_SAMPLES} samples", len(times))
        require(times[0] == 0.0, "times", "must start at 0", times[0])
        for number, (earlier, later) in enumerate(pairwise(times), 1):
            require(later > earlier, f"times[{number}]", f"must be later than {earlier:g} s before it", later)
        listed = isinstance(self.attitudes, (tuple, list, np.ndarray))
        require(listed, "attitudes", "must be a list of quaternions", self.attitudes)
        require(
            len(self.attitudes) == len(times), "attitudes", f"must match the {len(times)} times", len(self.attitudes)
        )
        checked = tuple(unit_quaternion(value, f"attitudes[{index}]") for index, value in enumerate(self.attitudes))
        object.__setattr__(self, "attitudes", checked)
        alike = np.abs(np.sum(np.array(checked[1:]) * np.array(checked[:-1]), axis=1))
        turn = 2.0 * np.arccos(np.minimum(alike, 1.0))
        widest = int(np.argmax(turn))
        rule = "must be within a quarter turn of the one before it [deg]; give more samples"
        require(turn[widest] <= LARGEST_TURN, f"attitudes[{widest + 1}]", rule, round(math.degrees(turn[widest]), 3))

    @classmethod
    def from_arrays(cls, time: npt.ArrayLike, quaternion: npt.ArrayLike) -> SampledReference:
        """Build a trajectory from times (T,) [s] and quaternions (T, 4), scalar first.

        The first time may be any; it becomes the start of the episode.
        """
        given: Any = time
        attitudes: Any = quaternion
        times = np.array(vector(given, None, "times"))
        return cls(tuple((times - times[:1]).tolist()), attitudes)

    @classmethod
    def from_csv(cls, path: str | os.PathLike[str]) -> SampledReference:
        """Read a trajectory from a file of comma-separated values.

        The scenario keeps the numbers and not the path.

        Parameters
        ----------
        path
            The file: columns time [s], q0, q1, q2, q3 (scalar first), with or without a line of these names; other
            names are refused, as their order may be another. Lines that begin with ``#`` are left out. The first time
            may be any; it becomes the start of the episode.

        Raises
        ------
        ValueError
            If the file cannot be read, has other columns or names, or its numbers break a rule of the class.
        """
        with reading(Path(path), f"give comma-separated columns {COLUMNS}"):
            text = Path(path).read_text(encoding="utf-8-sig").splitlines()
            lines = [line for line in text if line.strip() and not line.lstrip().startswith("#")]
            if lines and not reads_as_number(lines[0].split(",")[0]):
                names = ", ".join(part.strip().strip('"').lower() for part in lines.pop(0).split(","))
                require(names == COLUMNS, "line of names", f"must be {COLUMNS!r}", names)
            rows = [_row(line, number) for number, line in enumerate(lines, 1)]
            table = np.array(rows).reshape(-1, 5)
            return cls.from_arrays(table[:, 0], table[:, 1:])

    @property
    def moving(self) -> bool:
        """True for a reference that has a rate."""
        return True

    @cached_property
    def largest_rate(self) -> float:
        """Largest rate of the reference [rad/s], at 16 points between each pair of samples."""
        share, times = np.linspace(0.0, 1.0, 17), np.array(self.times)
        points = times[:-1, None] + np.diff(times)[:, None] * share
        return float(np.linalg.norm(self._spline(points.ravel(), 1), axis=1).max())

    @property
    def uniform_count(self) -> int:
        """Number of uniform deviates of one episode."""
        return 1

    def draw(self, uniform: FloatArray) -> References:
        """Fill the records of N spacecraft; the motion itself is that of :meth:`motion`."""
        reference, points = np.zeros(len(uniform), REFERENCE), np.zeros((len(uniform), 1), SET_POINT)
        reference["kind"] = ReferenceKind.SAMPLED
        reference["attitude"] = points["attitude"] = self.attitudes[0]
        return reference, points

    def motion(self, time: npt.ArrayLike) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return attitude (T, 4), rate (T, 3) [rad/s] and acceleration (T, 3) [rad/s^2] at rising times (T,) [s].

        Rate and acceleration are in the reference frame's own axes. After the last sample the reference is at rest.
        """
        given = np.asarray(time, dtype=np.float64)
        # The tolerance absorbs rounding in the number of a control period times its length.
        over = given > self.times[-1] + 1e-9
        inside = np.clip(given, 0.0, self.times[-1])
        attitude = np.asarray(self._spline(inside).as_quat(scalar_first=True))
        follows = np.sum(attitude[1:] * attitude[:-1], axis=1) >= 0.0
        attitude[1:] *= np.cumprod(np.where(follows, 1.0, -1.0))[:, None]
        rate, acceleration = (np.where(over[:, None], 0.0, self._spline(inside, order)) for order in (1, 2))
        return attitude, rate, acceleration

    @cached_property
    def _spline(self) -> RotationSpline:
        from scipy.spatial.transform import Rotation, RotationSpline  # Takes a while to import.

        return RotationSpline(self.times, Rotation.from_quat(self.attitudes, scalar_first=True))


def _row(line: str, number: int) -> list[float]:
    parts = line.split(",")
    require(len(parts) == 5, f"row {number}", "must have 5 columns", len(parts))
    require(all(map(reads_as_number, parts)), f"row {number}", "must consist of numbers", line)
    return [float(part) for part in parts]


def table_of(reference: Any, control_period: float, horizon: int) -> tuple[FloatArray, FloatArray, FloatArray] | None:
    """Return the motion at the start of each control period, and at rest after the last; None for other references.

    Returns
    -------
    Attitude (horizon + 2, 4), rate and acceleration (horizon + 2, 3).
    """
    if not isinstance(reference, SampledReference):
        return None
    attitude, rate, acceleration = reference.motion(np.arange(horizon + 1) * control_period)
    still = np.zeros((1, 3))
    return np.vstack([attitude, attitude[-1:]]), np.vstack([rate, still]), np.vstack([acceleration, still])
