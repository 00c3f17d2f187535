"""External torque of a scenario: the sum of its disturbances."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import accumulate
from typing import Any

import numpy as np
import numpy.typing as npt

from ftac_gym.task.disturbances import Disturbance
from ftac_gym.task.low_orbit import LowOrbitTorque
from ftac_gym.utils.parameters import FloatArray, require

Source = Disturbance | LowOrbitTorque
"""One disturbance."""


@dataclass(frozen=True)
class ExternalTorque:
    """Sum of disturbances; the sum of none is zero.

    Constants add up, and the harmonics of all stand side by side.

    Attributes
    ----------
    parts
        The disturbances. All have the same ``rate_offset``, see :func:`checked`.
    """

    parts: tuple[Source, ...] = ()

    @classmethod
    def of(cls, disturbance: Source | tuple[Source, ...] | None) -> ExternalTorque:
        """Return the sum of the disturbances of a scenario's field."""
        if disturbance is None:
            return cls()
        return cls(disturbance if isinstance(disturbance, tuple) else (disturbance,))

    @property
    def paths(self) -> Iterator[tuple[str, Source]]:
        """Names of the disturbances in messages, and the disturbances."""
        for index, part in enumerate(self.parts):
            yield "disturbance" if len(self.parts) == 1 else f"disturbance[{index}]", part

    @property
    def rate_offset(self) -> float | None:
        """c of the factor (``|w|^2`` + c) on the whole torque; None for no such factor."""
        return _rate_offset(self.parts[0]) if self.parts else None

    @property
    def uniform_count(self) -> int:
        """Number of uniform deviates of one episode."""
        return sum(part.uniform_count for part in self._drawn)

    def largest_torque(self, moment: float) -> float:
        """Return a bound on the torque [N m], before any scaling with the rate.

        ``moment`` is the largest principal moment of inertia [kg m^2].
        """
        return sum(part.largest_torque(moment) for part in self.parts)

    def swing(self, time: float) -> float:
        """Return a bound on the impulse within a time [N m s], in body axes, of a torque that grows with the rate.

        That of a low orbit does not grow, and counts as none.
        """
        return sum(part.swing(time) for part in self.parts if isinstance(part, Disturbance))

    def draw(self, uniform: FloatArray, inertia: FloatArray) -> tuple[npt.NDArray[np.void], npt.NDArray[np.void]]:
        """Draw N torques.

        Each disturbance uses deviates of its own, in their order: one more at the end leaves the others as they are.

        Parameters
        ----------
        uniform
            (N, uniform_count) uniform deviates in [0, 1).
        inertia
            (N, 3, 3) true inertia [kg m^2], without any varying part.

        Returns
        -------
        Arrays of DISTURBANCE (N,) and HARMONIC (N, harmonics).
        """
        ends = list(accumulate(part.uniform_count for part in self._drawn))
        deviates = np.split(uniform, ends[:-1], axis=1)
        drawn = [part.draw(values, inertia) for part, values in zip(self._drawn, deviates, strict=True)]
        steady, harmonics = zip(*drawn, strict=True)
        if len(drawn) == 1:
            return steady[0], harmonics[0]
        total = steady[0].copy()
        total["constant"] = np.sum([record["constant"] for record in steady], axis=0)
        return total, np.concatenate(harmonics, axis=1)

    @property
    def _drawn(self) -> tuple[Source, ...]:
        return self.parts or (Disturbance(),)


def checked(disturbance: Any) -> Source | tuple[Source, ...] | None:
    """Return the value of a scenario's field: a disturbance alone, a tuple of several, or None.

    Raises
    ------
    ValueError
        If it is or holds something else, is empty, or the disturbances differ in their ``rate_offset``. The plant
        scales the sum of all.
    """
    several = isinstance(disturbance, (tuple, list))
    names = "a Disturbance or LowOrbitTorque or None, or a tuple of Disturbance and LowOrbitTorque objects"
    if not several:
        require(disturbance is None or isinstance(disturbance, Source), "disturbance", f"must be {names}", disturbance)
        return disturbance
    require(len(disturbance) > 0, "disturbance", "must hold one disturbance or more; None is for none", disturbance)
    for index, part in enumerate(disturbance):
        rule = "must be a Disturbance or LowOrbitTorque"
        require(isinstance(part, Source), f"disturbance[{index}]", rule, part)
    first = _rate_offset(disturbance[0])
    for index, part in enumerate(disturbance):
        rule = f"must be {first!r}, as that of disturbance[0]: one factor scales the sum of all disturbances"
        require(_rate_offset(part) == first, f"disturbance[{index}].rate_offset", rule, _rate_offset(part))
    return tuple(disturbance) if len(disturbance) > 1 else disturbance[0]


def _rate_offset(part: Source) -> float | None:
    return part.rate_offset if isinstance(part, Disturbance) else None
