"""The attitude error as a quaternion with a sign, which selects the direction of the turn."""

from __future__ import annotations

import numpy as np

from ftac_gym.baselines.components.rows import dot
from ftac_gym.baselines.memory import Memory
from ftac_gym.utils.parameters import FloatArray, within


class HybridError:
    """q_e on the double cover, without jumps of its sign, and the logic variable h that selects the direction.

    A rotation has two quaternions. The one nearer to that of the last call is taken, at the start the given one.
    The error is continuous for every sign of the sensor. The variable h starts at 1 and jumps to -h in the jump set::

        h e_4 <= -eta,  0 < eta < 1    (Eqs. (13)-(16) of Ma et al. 2023)

    Turning h e_v to zero takes the short way wherever h e_4 > 0. It takes the other way only within 2 asin(eta) beyond
    half a turn, where that is at most 4 asin(eta) longer. Without a hysteresis h stays 1, and e_4 goes to 1 from every
    start, which is unwinding.

    Parameters
    ----------
    memory
        Store of the error and h.
    hysteresis
        eta; None keeps h at 1.

    Raises
    ------
    ValueError
        If the hysteresis is not within (0, 1).
    """

    def __init__(self, memory: Memory, hysteresis: float | None) -> None:
        self._hysteresis = None if hysteresis is None else within(hysteresis, 0.0, 1.0, "hysteresis")
        self._memory = memory
        memory.add("lifted_error", (4,))
        memory.add("logic", (1,), initial=1.0)

    def peek(self, error: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the lifted error (N, 4) and h (N, 1) for errors (N, 4) of either sign; the memory is unchanged."""
        last = self._memory["lifted_error"]
        lifted = np.where(dot(last, error) < 0.0, -error, error)
        logic = self._memory["logic"]
        if self._hysteresis is not None:
            logic = np.where(logic * lifted[:, :1] <= -self._hysteresis, -logic, logic)
        return lifted, logic

    def update(self, error: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Take in errors (N, 4) of either sign and return the lifted error (N, 4) and h (N, 1)."""
        lifted, logic = self.peek(error)
        self._memory["lifted_error"], self._memory["logic"] = lifted, logic
        return lifted, logic
