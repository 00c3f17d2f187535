"""Nominal parameters of the spacecraft: what a designer knows before launch."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ftac_gym.parameters import Matrix, Vector, matrix, positive, require, vector

FloatArray = npt.NDArray[np.float64]


def _limits(values: float | Sequence[float] | None, count: int, field: str) -> Vector | None:
    """Return one positive limit per wheel from a scalar or a sequence; None means unlimited."""
    if values is None:
        return None
    if isinstance(values, (int, float, np.number)):
        values = (float(values),) * count
    return tuple(positive(value, f"{field}[{wheel}]") for wheel, value in enumerate(vector(values, count, field)))


@dataclass(frozen=True)
class WheelArray:
    """Reaction wheels: where they point and what they can do.

    Parameters
    ----------
    axes
        The matrix D, 3 x m: column j is the unit axis of wheel j in body axes. A torque tau_j turns the body along
        D[:, j] and takes as much momentum from the wheel.
    torque_limit
        Largest commanded torque of each wheel [N m]; a number for all wheels; None for unlimited.
    momentum_limit
        Largest momentum of each wheel [N m s]; a number for all wheels; None for unlimited.
    momentum_coupling
        Whether the stored momentum enters the gyroscopic torque. False models ideal torquers, as the papers do.

    Raises
    ------
    ValueError
        If D is not 3 x m with m >= 1 and unit columns, or a limit is not positive.
    """

    axes: Matrix
    torque_limit: Vector | float | None
    momentum_limit: Vector | float | None = None
    momentum_coupling: bool = True

    def __post_init__(self) -> None:
        """Check and normalise the fields."""
        axes = matrix(self.axes, 3, None, "axes")
        norms = np.linalg.norm(axes, axis=0)
        require(bool(np.all(np.abs(norms - 1.0) < 1e-6)), "axes", "must have columns of unit length", norms.tolist())
        count = axes.shape[1]
        object.__setattr__(self, "axes", tuple(tuple(float(value) for value in row) for row in axes))
        object.__setattr__(self, "torque_limit", _limits(self.torque_limit, count, "torque_limit"))
        object.__setattr__(self, "momentum_limit", _limits(self.momentum_limit, count, "momentum_limit"))

    @property
    def count(self) -> int:
        """Number of wheels m."""
        return len(self.axes[0])

    @property
    def axis_matrix(self) -> FloatArray:
        """The matrix D, array (3, m)."""
        return np.array(self.axes)

    @property
    def torque_limits(self) -> FloatArray:
        """Torque limits [N m], array (m,), infinite where unlimited."""
        return np.full(self.count, np.inf) if self.torque_limit is None else np.array(self.torque_limit)

    @property
    def momentum_limits(self) -> FloatArray:
        """Momentum limits [N m s], array (m,), infinite where unlimited."""
        return np.full(self.count, np.inf) if self.momentum_limit is None else np.array(self.momentum_limit)

    @classmethod
    def sign_pyramid(cls, torque_limit: float, momentum_limit: float | None, coupling: bool = True) -> WheelArray:
        """Four wheels along (+-1, +-1, 1)/sqrt 3: the layout with the largest torque envelope after one loss."""
        signs = ((1.0, -1.0, -1.0, 1.0), (1.0, 1.0, -1.0, -1.0), (1.0, 1.0, 1.0, 1.0))
        axes = tuple(tuple(sign / math.sqrt(3.0) for sign in row) for row in signs)
        return cls(axes, torque_limit, momentum_limit, coupling)


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
