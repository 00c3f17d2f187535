"""True inertia of a spacecraft, which differs from the nominal one."""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ftac_gym.utils.parameters import (
    FloatArray,
    Matrix,
    Vector,
    flag,
    matrix,
    non_negative,
    normalise,
    require,
    rows,
    vector,
)
from ftac_gym.utils.serialization import serializable

INERTIA = np.dtype(
    [("constant", "f8", (3, 3)), ("amplitude", "f8", (3,)), ("frequency", "f8", (3,)), ("phase", "f8", (3,))]
)
"""Per spacecraft: J(t) = constant + diag(amplitude * sin(frequency * t + phase)) [kg m^2, rad/s, rad]."""


@serializable
@dataclass(frozen=True)
class InertiaUncertainty:
    """Difference of the true inertia from the nominal one.

    The random part acts on the mass distribution, not on the inertia. With the second moment of mass
    S = tr(J)/2 I - J, the true one is (I + E) S (I + E)' for a random symmetric stretch E. Every drawn inertia then
    belongs to some body (positive definite, triangle inequality kept), however large the uncertainty is.

    Parameters
    ----------
    relative
        The second moment along each body axis is stretched by a factor uniform in 1 +- relative, with shears of up
        to relative/8. Between 0 and 1.
    offset
        Constant offset [kg m^2], 3 x 3 symmetric, added to the inertia.
    amplitude, frequency, phase
        The varying part diag(amplitude sin(frequency t + phase)) of the papers [kg m^2, rad/s, rad].
    rate_torque
        Whether Euler's equation has the term -J' w of a varying inertia. The papers leave it out.
    """

    relative: float = 0.0
    offset: Matrix | None = None
    amplitude: Vector = (0.0, 0.0, 0.0)
    frequency: Vector = (0.0, 0.0, 0.0)
    phase: Vector = (0.0, 0.0, 0.0)
    rate_torque: bool = False

    def __post_init__(self) -> None:
        """Check and normalise the fields."""
        normalise(self, non_negative, "relative")
        require(self.relative < 1.0, "relative", "must be below 1", self.relative)
        if self.offset is not None:
            offset = matrix(self.offset, 3, 3, "offset")
            require(bool(np.allclose(offset, offset.T)), "offset", "must be symmetric", self.offset)
            object.__setattr__(self, "offset", rows(offset))
        normalise(self, lambda value, name: vector(value, 3, name), "amplitude", "frequency", "phase")
        normalise(self, flag, "rate_torque")

    @property
    def uniform_count(self) -> int:
        """Number of uniform deviates of one episode."""
        return 6

    def extremes(self, nominal: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return matrices (3, 3) whose eigenvalues bound the principal moments of the inertia [kg m^2].

        The moments of a stretched body lie between those of the nominal one times the squares of the extreme
        stretches. Gershgorin's circles bound these.
        """
        shear, swing = self.relative / 4.0, np.diag(np.abs(self.amplitude))
        offset = np.zeros((3, 3)) if self.offset is None else np.array(self.offset)
        least, largest = max(math.sqrt(1.0 - self.relative) - shear, 0.0), math.sqrt(1.0 + self.relative) + shear
        return least**2 * nominal + offset - swing, largest**2 * nominal + offset + swing

    def draw(self, nominal: FloatArray, uniform: FloatArray) -> npt.NDArray[np.void]:
        """Draw the true inertia of N spacecraft.

        Parameters
        ----------
        nominal
            (3, 3) nominal inertia [kg m^2].
        uniform
            (N, 6) uniform deviates.

        Returns
        -------
        Array of INERTIA (N,).

        Raises
        ------
        ValueError
            If the offset or the varying part can make an inertia that is not positive definite.
        """
        table = exact_inertia(nominal, len(uniform))
        if self.relative > 0.0:
            signed = 2.0 * uniform - 1.0
            stretch = np.zeros((len(uniform), 3, 3))
            for axis in range(3):
                stretch[:, axis, axis] = np.sqrt(1.0 + self.relative * signed[:, axis])
            for column, (row, other) in enumerate(((0, 1), (0, 2), (1, 2))):
                stretch[:, row, other] = stretch[:, other, row] = self.relative / 8.0 * signed[:, 3 + column]
            mass_moment = 0.5 * np.trace(nominal) * np.eye(3) - nominal
            stretched = stretch @ mass_moment @ stretch
            table["constant"] = np.trace(stretched, axis1=1, axis2=2)[:, None, None] * np.eye(3) - stretched
        if self.offset is not None:
            table["constant"] += np.array(self.offset)
        lowest = np.linalg.eigvalsh(table["constant"] - np.diag(np.abs(self.amplitude)))[:, 0].min(initial=np.inf)
        require(bool(lowest > 0.0), "inertia_uncertainty", "must keep the inertia positive definite", float(lowest))
        for name in ("amplitude", "frequency", "phase"):
            table[name] = getattr(self, name)
        return table


def exact_inertia(nominal: FloatArray, count: int) -> npt.NDArray[np.void]:
    """Return INERTIA records (count,) of spacecraft whose true inertia is the nominal one."""
    table = np.zeros(count, INERTIA)
    table["constant"] = nominal
    return table
