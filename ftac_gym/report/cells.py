"""Cells of the report's tables."""

from __future__ import annotations

from dataclasses import dataclass, replace

from ftac_gym.evaluation import tables
from ftac_gym.evaluation.metrics import share_of
from ftac_gym.evaluation.rows import Row
from ftac_gym.evaluation.statistics import Estimate

MINUS = "\N{MINUS SIGN}"


@dataclass(frozen=True)
class Cell:
    """A cell.

    Attributes
    ----------
    text, note
        Text, and a line in small print.
    key
        Value by which the table is sorted, NaN if it is unknown; the text if None.
    mark
        "better", "worse" or nothing.
    """

    text: str
    note: str = ""
    key: float | None = None
    mark: str = ""


UNKNOWN = Cell("\N{EN DASH}", key=float("nan"))


def number(value: float) -> Cell:
    """Return a number; :data:`UNKNOWN` for NaN."""
    return UNKNOWN if value != value else Cell(tables.short(value).replace("-", MINUS), key=value)


def estimated(item: Estimate) -> Cell:
    """Return an estimate; its interval is a note, with the number of values if the metric is not defined for all."""
    interval = f"[{tables.short(item.low)}, {tables.short(item.high)}]".replace("-", MINUS)
    return replace(number(item.value), note=f"{interval}{share_of(item.defined, item.total)}" if item.count else "")


def difference(metric: str, item: Estimate, scale: float = 1.0) -> Cell:
    """Return a difference times a scale, marked if its interval excludes zero."""
    mark = tables.judgement(metric, item)
    cell = estimated(replace(item, value=scale * item.value, low=scale * item.low, high=scale * item.high))
    return replace(cell, text=f"{'+' if item.value > 0.0 else ''}{cell.text} {mark}".rstrip(), mark=mark)


def compared(metric: str, row: Row) -> Cell:
    """Return an estimate, marked if the interval of its difference to the reference excludes zero."""
    mark = tables.judgement(metric, row.differences[metric]) if row.differences else ""
    return replace(estimated(row.estimates[metric]), mark=mark)


def chance(item: Estimate) -> Cell:
    """Return a probability, marked if its interval excludes one half."""
    mark = "better" if item.low > 0.5 else "worse" if item.high < 0.5 else ""
    return replace(estimated(item), text=f"{item.value:.2f}", mark=mark) if item.count else UNKNOWN
