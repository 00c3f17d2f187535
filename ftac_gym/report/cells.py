"""Tables of a page, before they are written in HTML."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ftac_gym.evaluation import tables
from ftac_gym.evaluation.metrics import UNITS
from ftac_gym.evaluation.statistics import Estimate

if TYPE_CHECKING:
    from ftac_gym.evaluation.benchmark import Entry

UNKNOWN, MINUS, TIMES = "\N{EN DASH}", "\N{MINUS SIGN}", "\N{MULTIPLICATION SIGN}"


@dataclass(frozen=True)
class Cell:
    """A cell.

    Attributes
    ----------
    text, note
        What it says, and what it says in small print.
    key
        What the table is sorted by, "nan" if the value is unknown; by the text if None.
    mark
        "better", "worse" or nothing.
    code
        Whether the text is something to type.
    """

    text: str
    note: str = ""
    key: float | None = None
    mark: str = ""
    code: bool = False


@dataclass(frozen=True)
class Line:
    """A row of a table.

    Attributes
    ----------
    cells
        The first is the heading of the row.
    entry
        Whose row it is, so that it can be hidden with others like it; None for a row of no single entry.
    marked
        Whether it is to be set off, as the reference is.
    """

    cells: Sequence[Cell]
    entry: Entry | None = None
    marked: bool = False


@dataclass(frozen=True)
class Table:
    """A table; headings have their units as notes."""

    headings: Sequence[Cell]
    rows: Sequence[Line]
    caption: str = ""


def heading(metric: str) -> Cell:
    """Return the heading of a metric's column."""
    return Cell(metric.replace("_", " "), UNITS.get(metric, ""))


def number(value: float, digits: int = 3) -> Cell:
    """Return a number, "–" if it is NaN."""
    if value != value:
        return Cell(UNKNOWN, key=value)
    text = f"{value:.0f}" if abs(value) >= 1000.0 else f"{value:.{digits}g}"
    return Cell(text.replace("-", MINUS), key=value)


def estimated(item: Estimate) -> Cell:
    """Return an estimate with its interval as a note."""
    text, _, interval = tables.number(item).replace("-", MINUS).partition(" ")
    return Cell(text if item.count else UNKNOWN, interval, item.value)


def difference(metric: str, item: Estimate) -> Cell:
    """Return a difference, marked if its interval excludes zero."""
    words = tables.verdict(metric, item)
    mark = next((word for word in ("better", "worse") if words.endswith(word)), "")
    cell = estimated(item)
    text = f"{'+' if item.value > 0.0 else ''}{cell.text} {mark}".strip()
    return Cell(text, cell.note, item.value, mark)


def seeds(count: int) -> str:
    """Return a number of training seeds in words."""
    return f"{count} {'seed' if count == 1 else 'seeds'}"


def entry_cell(entry: Entry, reference: str) -> Cell:
    """Return the heading of an entry's row."""
    kind = f"agent, {seeds(len(entry.policies))}" if entry.kind == "agent" else f"{entry.gains or 'own'} gains"
    return Cell(entry.name, f"{kind}, reference" if entry.name == reference else kind)
