"""The first-order Levant differentiator as a command filter."""

from __future__ import annotations

import numpy as np

from ftac_gym.baselines.components.surfaces import signed_power
from ftac_gym.baselines.memory import Memory
from ftac_gym.utils.parameters import FloatArray, positive, whole


class LevantFilter:
    """f1' = -b1 sig(f1 - a)^(1/2) + f2, f2' = -b2 sign(f2 - f1'), Eq. (30) of Chen et al. 2018.

    The difference f2 - f1' is b1 sig(f1 - a)^(1/2): its sign is that of f1 - a, and the equation is not implicit. The
    state f1 follows the input a, and f1' its derivative, if ``|a''|`` stays below b2 with a margin. With Euler steps
    this holds for control periods up to about 10 ms. ``substeps`` remove the chatter of f1, which then lags a moving
    input by the hold; f1' follows the steps of the held input, not the derivative.

    Parameters
    ----------
    memory
        Store of f1 and f2.
    first, second
        b1, b2.
    period
        Control period [s].
    substeps
        Euler steps per period.
    at_input
        Whether f1 starts at the first input instead of at zero.

    Raises
    ------
    ValueError
        If a value breaks a rule.
    """

    def __init__(
        self, memory: Memory, first: float, second: float, period: float, substeps: int, at_input: bool = False
    ) -> None:
        self._first, self._second = positive(first, "first"), positive(second, "second")
        self.substeps = whole(substeps, 1, "substeps")
        self.step = period / self.substeps
        self._memory = memory
        memory.add("filtered_command", (3,))
        memory.add("filtered_slope", (3,))
        memory.add("filter_started", (1,), initial=not at_input)

    def output(self, command: FloatArray) -> FloatArray:
        """Return f1 (N, 3), for the input a (N, 3)."""
        return np.where(self._memory["filter_started"], self._memory["filtered_command"], command)

    def rate(self, command: FloatArray) -> FloatArray:
        """Return f1' (N, 3) for the input a (N, 3)."""
        behind = self.output(command) - command
        return self._memory["filtered_slope"] - self._first * signed_power(behind, 0.5)

    def advance(self, command: FloatArray) -> None:
        """Take one Euler sub-step with the input a (N, 3)."""
        memory, value, change = self._memory, self.output(command), self.rate(command)
        memory["filtered_command"] = value + self.step * change
        memory["filtered_slope"] = memory["filtered_slope"] - (self.step * self._second) * np.sign(value - command)
        memory["filter_started"] = np.ones_like(memory["filter_started"])
