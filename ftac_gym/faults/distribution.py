"""Which faults an episode has: drawn at random, or scheduled."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np

from ftac_gym.faults.fault import UNIFORMS_PER_FAULT, Fault
from ftac_gym.faults.table import no_faults
from ftac_gym.parameters import FloatArray, Vector, require


def _probabilities(values: tuple[float, ...], field: str) -> Vector:
    array = np.asarray(values, dtype=float)
    valid = array.ndim == 1 and array.size > 0 and bool(np.all(array >= 0.0)) and 0.0 < array.sum() < np.inf
    require(valid, field, "must be non-negative weights with a positive sum", values)
    total = float(array.sum())
    # What is normalised already stays as it is, so that a round trip through JSON changes nothing.
    return tuple(float(value) for value in (array if abs(total - 1.0) < 1e-15 * array.size else array / total))


@dataclass(frozen=True)
class FaultDistribution:
    """Random faults: how many wheels fail, which ones, and of what.

    Parameters
    ----------
    kinds
        The fault kinds to choose from; each draws its own timing and magnitude. A kind that names a ``wheel`` always
        strikes that one (for such schedules :class:`FaultSchedule` is the better tool), so here it must be None.
    weights
        Relative frequency of each kind; None for equal weights.
    faulty_wheels
        Relative frequency of 0, 1, 2, ... faulty wheels; the entry for 0 is the share of healthy episodes.

    Raises
    ------
    ValueError
        If there are no kinds, the weights do not match them, or a weight is negative.
    """

    kinds: tuple[Fault, ...]
    weights: Vector | None = None
    faulty_wheels: Vector = (0.0, 1.0)

    def __post_init__(self) -> None:
        """Check and normalise the fields."""
        require(isinstance(self.kinds, (tuple, list)), "kinds", "must be a tuple of Fault objects", self.kinds)
        object.__setattr__(self, "kinds", tuple(self.kinds))
        require(len(self.kinds) > 0, "kinds", "must name at least one fault kind", self.kinds)
        for fault in self.kinds:
            concrete = isinstance(fault, Fault) and type(fault) is not Fault
            require(concrete, "kinds", "must hold Fault objects of a concrete kind", fault)
            require(fault.wheel is None, "kinds", "must leave wheel=None: the distribution chooses it", fault)
        weights = self.weights if self.weights is not None else (1.0,) * len(self.kinds)
        require(len(weights) == len(self.kinds), "weights", f"must match the {len(self.kinds)} kinds", self.weights)
        object.__setattr__(self, "weights", _probabilities(weights, "weights"))
        object.__setattr__(self, "faulty_wheels", _probabilities(self.faulty_wheels, "faulty_wheels"))

    def check(self, wheels: int) -> None:
        """Raise a ValueError if more wheels can fail than the craft has."""
        worst = len(self.faulty_wheels) - 1
        require(worst <= wheels, "faulty_wheels", f"must not exceed the {wheels} wheels of the craft", worst)

    def uniform_count(self, wheels: int) -> int:
        """How many uniform deviates one episode needs."""
        return 1 + wheels + (len(self.faulty_wheels) - 1) * (1 + UNIFORMS_PER_FAULT)

    def draw(self, uniform: FloatArray, torque_limits: FloatArray) -> np.ndarray:
        """Draw the fault table (N, wheels, 1) from uniforms (N, uniform_count) and torque limits (wheels,) [N m]."""
        craft, wheels = len(uniform), len(torque_limits)
        table = no_faults(craft, wheels)
        counts = np.searchsorted(np.cumsum(self.faulty_wheels), uniform[:, 0], side="right")
        order = np.argsort(uniform[:, 1 : 1 + wheels], axis=1)
        weights = np.asarray(self.weights)
        for slot in range(len(self.faulty_wheels) - 1):
            start = 1 + wheels + slot * (1 + UNIFORMS_PER_FAULT)
            chosen = np.searchsorted(np.cumsum(weights), uniform[:, start], side="right").clip(max=len(weights) - 1)
            for index, fault in enumerate(self.kinds):
                rows = np.flatnonzero((counts > slot) & (chosen == index))
                if rows.size == 0:
                    continue
                struck = order[rows, slot]
                part = uniform[rows, start + 1 : start + 1 + UNIFORMS_PER_FAULT]
                table[rows, struck, 0] = fault.draw(part, torque_limits[struck])
        return table


@dataclass(frozen=True)
class FaultSchedule:
    """All the listed faults, in every episode; several may strike the same wheel.

    Raises
    ------
    ValueError
        If a fault names no wheel.
    """

    faults: tuple[Fault, ...]

    def __post_init__(self) -> None:
        """Check and normalise the fields."""
        require(isinstance(self.faults, (tuple, list)), "faults", "must be a tuple of Fault objects", self.faults)
        object.__setattr__(self, "faults", tuple(self.faults))
        for fault in self.faults:
            concrete = isinstance(fault, Fault) and type(fault) is not Fault
            require(concrete, "faults", "must hold Fault objects of a concrete kind", fault)
            require(fault.wheel is not None, "faults", "must each name a wheel", fault)

    def check(self, wheels: int) -> None:
        """Raise a ValueError if a fault names a wheel that the craft does not have."""
        for fault in self.faults:
            known = fault.wheel is not None and fault.wheel < wheels
            require(known, "wheel", f"must be below the number of wheels, {wheels}", fault.wheel)

    def layers(self, wheels: int) -> int:
        """How many faults one wheel can have at most."""
        return max(Counter(fault.wheel for fault in self.faults).values(), default=1)

    def uniform_count(self, wheels: int) -> int:
        """How many uniform deviates one episode needs."""
        return max(1, len(self.faults) * UNIFORMS_PER_FAULT)

    def draw(self, uniform: FloatArray, torque_limits: FloatArray) -> np.ndarray:
        """Draw the fault table (N, wheels, layers) from uniforms (N, uniform_count) and torque limits [N m]."""
        wheels = len(torque_limits)
        table = no_faults(len(uniform), wheels, self.layers(wheels))
        used: Counter[int] = Counter()
        for index, fault in enumerate(self.faults):
            wheel = fault.wheel if fault.wheel is not None else 0
            part = uniform[:, index * UNIFORMS_PER_FAULT : (index + 1) * UNIFORMS_PER_FAULT]
            table[:, wheel, used[wheel]] = fault.draw(part, np.full(len(uniform), torque_limits[wheel]))
            used[wheel] += 1
        return table
