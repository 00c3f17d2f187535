"""Torque and momentum envelopes of a wheel array.

Both are zonotopes, sum_j [-r_j, r_j] D[:, j]. A vector t lies inside one exactly if
``|n.t|`` <= sum_j r_j ``|n.D[:, j]|`` for the normal n of every pair of wheel axes.
"""

from dataclasses import dataclass, field
from itertools import combinations

import numpy as np
import numpy.typing as npt

from ftac_gym.attitude import cross
from ftac_gym.utils.parameters import FloatArray

BoolArray = npt.NDArray[np.bool_]

UNLIMITED = 1e12
"""Torque or momentum of a wheel without a limit: infinity times zero would be undefined."""

ROUNDING = 1e-9
"""Relative tolerance: a load exactly on the envelope is inside."""


def envelope_normals(axes: FloatArray) -> FloatArray:
    """Return the unit normals of the facets of a wheel array's envelope.

    Parameters
    ----------
    axes
        (3, m) wheel axes.

    Returns
    -------
    Array (facets, 3), one row for each pair of axes that are not parallel.
    """
    first, second = np.array(list(combinations(range(axes.shape[1]), 2)), dtype=int).reshape(-1, 2).T
    normals = cross(axes.T[first], axes.T[second])
    lengths = np.linalg.norm(normals, axis=1)
    distinct = lengths > 1e-9
    return normals[distinct] / lengths[distinct, None]


@dataclass(frozen=True, eq=False)
class Load:
    """Sets of vectors: points, plus or minus margins.

    Attributes
    ----------
    point
        (N, 3) centres.
    margin
        (N, 3) half-widths of a box in body axes.
    """

    point: FloatArray
    margin: FloatArray = field(default_factory=lambda: np.zeros((1, 3)))


class Envelope:
    """The zonotopes sum_j [-r_j, r_j] D[:, j] of a wheel array, for any reach r of the wheels.

    Parameters
    ----------
    axes
        (3, m) wheel axes.
    """

    def __init__(self, axes: FloatArray) -> None:
        self._axes = axes
        self._normals = envelope_normals(axes).T
        self._across = np.abs(axes.T @ self._normals)

    def room(self, load: Load, reach: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the room that a load leaves along each normal, and the envelope itself, both (N, facets)."""
        support = np.minimum(reach, UNLIMITED) @ self._across
        # The vector of the set that is farthest along each normal.
        farthest = np.abs(load.point @ self._normals) + load.margin @ np.abs(self._normals)
        return support - farthest, support

    def contains(self, load: Load, reach: FloatArray) -> BoolArray:
        """Return whether loads lie inside (N,); none does if the wheels with any reach do not span space."""
        free, support = self.room(load, reach)
        gram = np.einsum("nj,ij,kj->nik", (reach > 0.0).astype(float), self._axes, self._axes)
        return np.all(free >= -ROUNDING * support, axis=1) & (np.linalg.eigvalsh(gram)[:, 0] > 1e-9)
