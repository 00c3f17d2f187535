"""Gains of observer and controller of Li et al. 2023: one matrix per rule of the fuzzy model."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any, Self

import numpy as np

from ftac_gym.utils.parameters import FloatArray, require

RULES = 8


def _checked(value: object, shape: tuple[int, ...], name: str) -> FloatArray:
    array = np.asarray(value, dtype=np.float64)
    require(array.shape == shape and bool(np.isfinite(array).all()), name, f"must be finite, {shape}", array.shape)
    return array


class _PerRule:
    """Gains with one matrix per rule."""

    def mean(self) -> Self:
        """Return gains with the mean over all rules at every rule."""
        parts = {item.name: getattr(self, item.name) for item in fields(self)}  # type: ignore[arg-type]
        # Three axes: one matrix per rule.
        return replace(
            self,  # type: ignore[type-var]
            **{name: np.broadcast_to(part.mean(axis=0), part.shape) for name, part in parts.items() if part.ndim == 3},
        )

    def to_dict(self) -> dict[str, Any]:
        """Return plain JSON data."""
        return {item.name: getattr(self, item.name).tolist() for item in fields(self)}  # type: ignore[arg-type]


@dataclass(frozen=True, eq=False)
class ObserverGains(_PerRule):
    """Gains of the observer (16), (17) for k modes and faults along p axes, three for torques on the body.

    Parameters
    ----------
    rate
        K_i (8, 3, 3) [1/s].
    fault
        F_i (8, p, 3) [N m per rad].
    vibration
        G_i (8, 2k, 3), from rad/s to the slope of (eta, eta' + delta w).
    fault_proportional
        theta_1 F_2 (p, 3) [N m s/rad].
    vibration_proportional
        theta_2 G_2 (2k, 3).

    Raises
    ------
    ValueError
        If a shape is wrong or a number is not finite.
    """

    rate: FloatArray
    fault: FloatArray
    vibration: FloatArray
    fault_proportional: FloatArray
    vibration_proportional: FloatArray

    def __post_init__(self) -> None:
        """Check the shapes."""
        faults, rows = len(self.fault_proportional), len(self.vibration_proportional)
        shapes = {
            "rate": (RULES, 3, 3),
            "fault": (RULES, faults, 3),
            "vibration": (RULES, rows, 3),
            "fault_proportional": (faults, 3),
            "vibration_proportional": (rows, 3),
        }
        for name, shape in shapes.items():
            object.__setattr__(self, name, _checked(getattr(self, name), shape, name))


@dataclass(frozen=True, eq=False)
class ControllerGains(_PerRule):
    """Gains of the virtual control of (40).

    Parameters
    ----------
    feedback
        K_c (8, 3, 3) [N m s/rad].

    Raises
    ------
    ValueError
        If the shape is wrong or a number is not finite.
    """

    feedback: FloatArray

    def __post_init__(self) -> None:
        """Check the shape."""
        object.__setattr__(self, "feedback", _checked(self.feedback, (RULES, 3, 3), "feedback"))


def default_fault_proportional() -> FloatArray:
    """Return theta_1 F_2 = 20 diag(2, 1, 1) (Eq. (68); printed with a triangular pattern)."""
    return 20.0 * np.diag([2.0, 1.0, 1.0])


def default_vibration_proportional(modes: int) -> FloatArray:
    """Return theta_2 G_2 (2k, 3): 20 times the rows of the identity, repeated (Eq. (68))."""
    return 20.0 * np.eye(3)[np.arange(2 * modes) % 3]
