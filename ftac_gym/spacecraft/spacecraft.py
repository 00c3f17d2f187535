"""Nominal parameters of the spacecraft, those available to a designer before launch."""

from dataclasses import dataclass, field

import numpy as np

from ftac_gym.spacecraft.appendages import FlexibleAppendages
from ftac_gym.spacecraft.wheel_array import WheelArray
from ftac_gym.utils.parameters import FloatArray, Matrix, flag, matrix, normalise, require, rows
from ftac_gym.utils.serialization import LATER_PART, serializable


@serializable
@dataclass(frozen=True)
class Spacecraft:
    """A body with reaction wheels, rigid or with flexible appendages.

    Parameters
    ----------
    inertia
        Total inertia with the wheels locked and the appendages still, 3 x 3 in body axes [kg m^2].
    wheels
        The reaction wheels.
    allow_unphysical_inertia
        Accept an inertia that no mass distribution has. Some published scenarios print one.
    appendages
        Flexible appendages; None for a rigid body.

    Raises
    ------
    ValueError
        If the inertia is not symmetric or not positive definite. If its principal moments break the triangle
        inequality: the largest may not exceed the sum of the others. If the appendages carry more inertia than there
        is.
    """

    inertia: Matrix
    wheels: WheelArray
    allow_unphysical_inertia: bool = False
    appendages: FlexibleAppendages | None = field(default=None, metadata=LATER_PART)

    def __post_init__(self) -> None:
        """Check and normalise the fields."""
        normalise(self, flag, "allow_unphysical_inertia")
        require(isinstance(self.wheels, WheelArray), "wheels", "must be a WheelArray", self.wheels)
        inertia = matrix(self.inertia, 3, 3, "inertia")
        require(bool(np.allclose(inertia, inertia.T, rtol=1e-9)), "inertia", "must be symmetric", self.inertia)
        moments = np.linalg.eigvalsh(inertia)
        require(moments[0] > 0.0, "inertia", "must be positive definite; principal moments", moments.tolist())
        rule = "must satisfy the triangle inequality (or pass allow_unphysical_inertia=True); principal moments"
        physical = moments[2] <= (moments[0] + moments[1]) * (1.0 + 1e-9)
        require(physical or self.allow_unphysical_inertia, "inertia", rule, moments.tolist())
        if self.appendages is not None:
            known = isinstance(self.appendages, FlexibleAppendages)
            require(known, "appendages", "must be FlexibleAppendages or None", self.appendages)
            self.appendages.check(inertia)
        object.__setattr__(self, "inertia", rows(inertia))

    @property
    def inertia_matrix(self) -> FloatArray:
        """The inertia as an array (3, 3) [kg m^2]."""
        return np.array(self.inertia)

    @property
    def modes(self) -> int:
        """Number of vibration modes k; zero for a rigid body."""
        return 0 if self.appendages is None else self.appendages.count

    @property
    def quick_inertia(self) -> FloatArray:
        """Inertia without that of the modes, J - delta' delta (3, 3) [kg m^2]: it resists a sudden torque."""
        carried = 0.0 if self.appendages is None else self.appendages.carried_inertia
        return self.inertia_matrix - carried
