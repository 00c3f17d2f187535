"""The auxiliary anti-saturation system of Zhang and Zhou 2019; it has no effect and is off by default."""

from __future__ import annotations

import numpy as np

from ftac_gym.baselines.memory import Memory
from ftac_gym.utils.parameters import FloatArray, finite, positive, require, whole


class AntiSaturation:
    """xi' = -L2 xi - (h^2 / ``|xi|^2``) xi - H Theta while ``|xi|`` >= dk, else xi' = 0; the law subtracts L1 xi.

    Eqs. (39), (73), with H = J^-1 D E^, Theta = sat(u) - u and h = ``|H|`` ``|Theta|``. From ``d|xi|/dt`` <= -(L2
    ``|xi|^2`` - h ``|xi|`` + h^2) / ``|xi|``, which is negative for every h if L2 > 1/4 (the paper itself asks for L2 >
    1/2), ``|xi|`` can only fall; it reaches dk in about dk + ``|xi|^2``/h^2 seconds and stays there. All else in the
    output of an explicit integrator is an effect of its step, as ``substeps`` shows.

    Parameters
    ----------
    memory
        Store of xi.
    period
        Control period [s].
    to_acceleration
        J^-1 D, (3, m).
    gain, decay
        L1 and L2 [1/s], with L2 > L1^2/2 + 1/2.
    smallest
        dk.
    initial
        Each component of xi(0).
    substeps
        Euler steps per period.

    Raises
    ------
    ValueError
        If a value breaks a rule.
    """

    def __init__(
        self,
        memory: Memory,
        period: float,
        to_acceleration: FloatArray,
        gain: float = 1.0,
        decay: float = 2.0,
        smallest: float = 1e-3,
        initial: float = 0.1,
        substeps: int = 1,
    ) -> None:
        self._gain, self._decay = positive(gain, "gain"), positive(decay, "decay")
        rule = "must exceed L1^2/2 + 1/2 (Theorems 2 and 3)"
        require(decay > 0.5 * gain * gain + 0.5, "decay", rule, decay)
        self._smallest = positive(smallest, "smallest")
        self._substeps = whole(substeps, 1, "substeps")
        self._step = period / self._substeps
        self._to_acceleration = to_acceleration
        self._memory = memory
        memory.add("anti_saturation", (3,), initial=finite(initial, "initial"))

    @property
    def variable(self) -> FloatArray:
        """Xi (N, 3)."""
        return self._memory["anti_saturation"]

    @property
    def correction(self) -> FloatArray:
        """L1 xi (N, 3), to be subtracted from the acceleration."""
        return self._gain * self.variable

    def update(self, excess: FloatArray, effectiveness: FloatArray | None) -> None:
        """Take in Theta = sat(u) - u (N, m) [N m] and the estimated effectiveness (N, m)."""
        weak = np.ones_like(excess) if effectiveness is None else effectiveness
        matrices = self._to_acceleration * weak[:, None, :]
        push = np.einsum("nij,nj->ni", matrices, excess)
        size = np.linalg.norm(matrices, 2, axis=(1, 2)) * np.linalg.norm(excess, axis=1)
        variable = self.variable
        for _ in range(self._substeps):
            length = np.linalg.norm(variable, axis=1)
            works = (length >= self._smallest)[:, None]
            decay = self._decay + (size / np.maximum(length, self._smallest)) ** 2
            variable = variable - np.where(works, self._step * (decay[:, None] * variable + push), 0.0)
        self._memory["anti_saturation"] = variable
