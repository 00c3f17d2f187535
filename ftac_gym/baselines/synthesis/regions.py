"""Regions of the complex plane for poles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ftac_gym.utils.parameters import FloatArray, finite, positive


@dataclass(frozen=True)
class Disc:
    """The disc O(centre, radius) of the complex plane (Lemma 3 of Li et al. 2023).

    Parameters
    ----------
    centre
        On the real axis [1/s].
    radius
        [1/s].

    Raises
    ------
    ValueError
        If the radius is not positive.
    """

    centre: float
    radius: float

    def __post_init__(self) -> None:
        """Check the fields."""
        finite(self.centre, "centre")
        positive(self.radius, "radius")

    def reach(self, matrices: FloatArray) -> FloatArray:
        """Return the largest distance of a pole from the centre, for matrices (..., n, n)."""
        farthest: FloatArray = np.abs(poles(matrices) - self.centre).max(axis=-1)
        return farthest


def poles(matrices: FloatArray) -> npt.NDArray[np.complex128]:
    """Return the eigenvalues (..., n) of matrices (..., n, n)."""
    values: npt.NDArray[np.complex128] = np.linalg.eigvals(matrices).astype(np.complex128)
    return values
