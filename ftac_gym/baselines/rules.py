"""Rules for the values of gains: functions ``rule(value, field)`` that return the checked value or raise a ValueError.

The functions ``positive``, ``non_negative``, ``finite`` and ``flag`` of :mod:`ftac_gym.utils.parameters` are rules too.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from ftac_gym.utils.parameters import finite, positive, require, whole

Check = Callable[[Any, str], Any]
"""A function of a value and the name of its field that returns the value to use."""


@dataclass(frozen=True)
class Rule:
    """A check with its description.

    Parameters
    ----------
    words
        Description in the documentation.
    convert
        Check of the type, which returns the value to use.
    holds
        Condition on that value; None for no condition.
    demand
        The condition in messages, after "must".
    """

    words: str
    convert: Check
    holds: Callable[[Any], bool] | None = None
    demand: str = ""

    def __call__(self, value: Any, field: str) -> Any:
        """Return the value to use."""
        converted = self.convert(value, field)
        require(self.holds is None or self.holds(converted), field, f"must {self.demand}", value)
        return converted


def choice(*choices: str) -> Rule:
    """Return the rule of one of a few texts."""
    words = "one of " + ", ".join(f'``"{text}"``' for text in choices)
    return Rule(words, _unchanged, choices.__contains__, f"be one of {list(choices)}")


def interval(low: float, high: float, closed: bool = False) -> Rule:
    """Return the rule of a number between two ends, of which the upper one may be included."""
    words = f"within ({low:g}, {high:g}{']' if closed else ')'}"
    return Rule(words, finite, lambda number: low < number < high or (closed and number == high), f"lie {words}")


def at_most(high: float) -> Rule:
    """Return the rule of a positive number up to an end."""
    return Rule(f"positive, at most {high:g}", positive, lambda number: number <= high, f"not exceed {high:g}")


def at_least(low: float) -> Rule:
    """Return the rule of a finite number from an end on."""
    return Rule(f"at least {low:g}", finite, lambda number: number >= low, f"be at least {low:g}")


def whole_number(least: int) -> Rule:
    """Return the rule of a whole number from a least one on."""
    return Rule(f"a whole number, at least {least}", lambda value, field: whole(value, least, field))


def optional(rule: Check) -> Rule:
    """Return the rule of None, or of a value that keeps another rule."""
    words = f"None or {words_of(rule)}"
    return Rule(words, lambda value, field: None if value is None else rule(value, field))


def mapping(value: Any, field: str) -> Mapping[str, Any] | None:
    """Return the gains of a part, or None for its defaults."""
    require(value is None or isinstance(value, Mapping), field, "must be a mapping of gains or None", value)
    return value


def words_of(rule: Check) -> str:
    """Return the description of a rule."""
    return rule.words if isinstance(rule, Rule) else rule.__name__.replace("_", "-")


def _unchanged(value: Any, field: str) -> Any:
    return value
