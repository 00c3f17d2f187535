"""Adaptive gains: numbers that grow with a drive and decay by a leak."""

from __future__ import annotations

from ftac_gym.baselines.memory import Memory
from ftac_gym.utils.parameters import FloatArray, non_negative


class LeakyAdaptation:
    """x' = gain * drive - leak * x, one Euler step per call.

    The adaptive laws of the papers are of this form: Eqs. (51), (52) of Ma et al. 2023, (45), (66), (71) of Chen et al.
    2018, the bounds of Zhang and Zhou 2019 (no leak), h of the family of Shen et al.

    Parameters
    ----------
    memory
        Store of x.
    name
        Its name there.
    columns
        Numbers per spacecraft.
    gain
        Not negative.
    leak
        [1/s]; zero for no decay.
    period
        Time between two updates [s].
    initial
        x at the start.

    Raises
    ------
    ValueError
        If a value breaks a rule, or the leak would make x change its sign in one step.
    """

    def __init__(
        self, memory: Memory, name: str, columns: int, gain: float, leak: float, period: float, initial: float = 0.0
    ) -> None:
        self._gain = non_negative(gain, "gain") * period
        self._leak = non_negative(leak, "leak") * period
        if self._leak > 1.0:
            raise ValueError(f"leak must be at most one over the control period, {1.0 / period!r} 1/s, got {leak!r}")
        self._memory, self._name = memory, name
        memory.add(name, (columns,), initial=non_negative(initial, "initial"))

    @property
    def value(self) -> FloatArray:
        """X (N, columns)."""
        return self._memory[self._name]

    def update(self, drive: FloatArray) -> None:
        """Take in the drive of this period (N, columns)."""
        value = self.value
        change = self._gain * drive
        self._memory[self._name] = value + (change if self._leak == 0.0 else change - self._leak * value)
