"""Nominal parameters of the spacecraft: what a designer knows before launch."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ftac_gym.parameters import FloatArray, Matrix, matrix, require
from ftac_gym.wheels import WheelArray


@dataclass(frozen=True)
class Spacecraft:
    """A rigid body with reaction wheels.

    Parameters
    ----------
    inertia
        Total inertia with the wheels locked, 3 x 3 in body axes [kg m^2].
    wheels
        The reaction wheels.
    allow_unphysical_inertia
        Accept an inertia that no mass distribution has. Some published scenarios print one.

    Raises
    ------
    ValueError
        If the inertia is not symmetric, not positive definite, or its principal moments break the triangle
        inequality (the largest may not exceed the sum of the others).
    """

    inertia: Matrix
    wheels: WheelArray
    allow_unphysical_inertia: bool = False

    def __post_init__(self) -> None:
        """Check and normalise the fields."""
        require(isinstance(self.wheels, WheelArray), "wheels", "must be a WheelArray", self.wheels)
        inertia = matrix(self.inertia, 3, 3, "inertia")
        require(bool(np.allclose(inertia, inertia.T, rtol=1e-9)), "inertia", "must be symmetric", self.inertia)
        moments = np.linalg.eigvalsh(inertia)
        require(moments[0] > 0.0, "inertia", "must be positive definite; principal moments", moments.tolist())
        if not self.allow_unphysical_inertia:
            require(
                moments[2] <= (moments[0] + moments[1]) * (1.0 + 1e-9),
                "inertia",
                "must satisfy the triangle inequality (or pass allow_unphysical_inertia=True); principal moments",
                moments.tolist(),
            )
        object.__setattr__(self, "inertia", tuple(tuple(float(value) for value in row) for row in inertia))

    @property
    def inertia_matrix(self) -> FloatArray:
        """The inertia as an array (3, 3) [kg m^2]."""
        return np.array(self.inertia)
