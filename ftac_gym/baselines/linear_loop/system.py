"""Linear systems: the part between input and output, and the exact response to commands that are held."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm

from ftac_gym.utils.parameters import FloatArray

NEGLIGIBLE = 1e-6
"""Share of the largest number of a model below which a coupling is rounding."""


@dataclass(frozen=True, eq=False)
class System:
    """Linear system x' = A x + B u, y = C x + D u, in continuous or discrete time.

    Attributes
    ----------
    a, b, c, d
        The matrices.
    """

    a: FloatArray
    b: FloatArray
    c: FloatArray
    d: FloatArray

    def reduced(self) -> System:
        """Return the part that the input moves and the output shows."""
        seen = _invariant(self.a.T, self.c.T)
        a, b, c = seen.T @ self.a @ seen, seen.T @ self.b, self.c @ seen
        moved = _invariant(a, b)
        return System(moved.T @ a @ moved, moved.T @ b, c @ moved, self.d)


def held_parts(plant: System, period: float, late: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the exact transition over a control period, and the effect of a command in its first and its last part.

    Parameters
    ----------
    plant
        The system in continuous time.
    period
        Control period [s].
    late
        Length of the first part [s], in which the command before is still in effect.
    """
    states, commands = plant.b.shape

    def over(time: float) -> tuple[FloatArray, FloatArray]:
        whole = np.zeros((states + commands, states + commands))
        whole[:states, :states], whole[:states, states:] = plant.a * time, plant.b * time
        whole = expm(whole)
        return whole[:states, :states], whole[:states, states:]

    last, rest = over(period - late)
    if late == 0.0:
        return last, np.zeros_like(rest), rest
    begin, first = over(late)
    return last @ begin, last @ first, rest


def _invariant(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return an orthonormal basis (n, r) of what the columns of B reach under A, without what is rounding."""
    basis = np.zeros((len(a), 0))
    added = _directions(b, float(np.abs(b).max(initial=0.0)))
    scale = float(np.linalg.norm(a, 2)) if a.size else 0.0
    while added.shape[1]:
        basis = np.concatenate([basis, added], axis=1)
        further = a @ added
        for _ in range(2):
            further = further - basis @ (basis.T @ further)
        added = _directions(further, scale)
    return basis


def _directions(columns: FloatArray, scale: float) -> FloatArray:
    if not columns.size or scale == 0.0:
        return columns[:, :0]
    left, sizes, _ = np.linalg.svd(columns, full_matrices=False)
    return np.asarray(left[:, sizes > NEGLIGIBLE * scale])
