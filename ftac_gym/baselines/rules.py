"""Rules for the values of gains: functions ``rule(value, field)`` that return the checked value or raise a ValueError.

The functions ``positive``, ``non_negative`` and ``finite`` of :mod:`ftac_gym.utils.parameters` are rules too.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from ftac_gym.utils.parameters import finite, positive, require, whole

Rule = Callable[[Any, str], Any]
"""A function of a value and the name of its field that returns the value to use."""


@dataclass(frozen=True)
class Choice:
    """One of a few texts."""

    choices: tuple[str, ...]

    def __call__(self, value: Any, field: str) -> str:
        """Return the value."""
        require(value in self.choices, field, f"must be one of {list(self.choices)}", value)
        return str(value)

    def __str__(self) -> str:
        """Return the rule in words."""
        return "one of " + ", ".join(f'``"{choice}"``' for choice in self.choices)


@dataclass(frozen=True)
class Interval:
    """A number between two ends, of which the upper one may be included."""

    low: float
    high: float
    closed: bool = False

    def __call__(self, value: Any, field: str) -> float:
        """Return the value as a float."""
        number = finite(value, field)
        inside = self.low < number < self.high or (self.closed and number == self.high)
        require(inside, field, f"must lie {self}", value)
        return number

    def __str__(self) -> str:
        """Return the rule in words."""
        return f"within ({self.low:g}, {self.high:g}{']' if self.closed else ')'}"


@dataclass(frozen=True)
class AtMost:
    """A positive number up to an end."""

    high: float

    def __call__(self, value: Any, field: str) -> float:
        """Return the value as a float."""
        number = positive(value, field)
        require(number <= self.high, field, f"must not exceed {self.high:g}", value)
        return number

    def __str__(self) -> str:
        """Return the rule in words."""
        return f"positive, at most {self.high:g}"


@dataclass(frozen=True)
class AtLeast:
    """A finite number from an end on."""

    low: float

    def __call__(self, value: Any, field: str) -> float:
        """Return the value as a float."""
        require(self.low <= value < math.inf, field, f"must be at least {self.low:g}, and finite", value)
        return float(value)

    def __str__(self) -> str:
        """Return the rule in words."""
        return f"at least {self.low:g}"


@dataclass(frozen=True)
class Whole:
    """A whole number from a least one on."""

    least: int

    def __call__(self, value: Any, field: str) -> int:
        """Return the value as an int."""
        return whole(value, self.least, field)

    def __str__(self) -> str:
        """Return the rule in words."""
        return f"a whole number, at least {self.least}"


@dataclass(frozen=True)
class Optional:
    """None, or a value that keeps another rule."""

    rule: Rule

    def __call__(self, value: Any, field: str) -> Any:
        """Return the value."""
        return None if value is None else self.rule(value, field)

    def __str__(self) -> str:
        """Return the rule in words."""
        return f"None or {text_of(self.rule)}"


def flag(value: Any, field: str) -> bool:
    """Return the truth of a value."""
    return bool(value)


def mapping(value: Any, field: str) -> Mapping[str, Any] | None:
    """Return the gains of a part, or None for its defaults."""
    require(value is None or isinstance(value, Mapping), field, "must be a mapping of gains or None", value)
    return value


def text_of(rule: Rule) -> str:
    """Return a rule in words."""
    return str(rule) if hasattr(rule, "__dataclass_fields__") else rule.__name__.replace("_", "-")
