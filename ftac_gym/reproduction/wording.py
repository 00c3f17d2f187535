"""Numbers as text, and tables of them, for the reports of all papers."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from itertools import product
from typing import Any, TypeVar

import numpy as np

from ftac_gym.evaluation.tables import Cells
from ftac_gym.reproduction.recordings import Recording

Row = TypeVar("Row")
Column = TypeVar("Column")
Value = TypeVar("Value")


def seconds(time: float) -> str:
    """Return a time [s] as text; infinity is "never"."""
    return f"{time:.1f} s" if np.isfinite(time) else "never"


def settled(recording: Recording, angle: float = 0.1) -> str:
    """Return the settling time of the first spacecraft for an angle [deg] as text."""
    return seconds(recording.settling(angle))


def percent(share: float, digits: int = 0) -> str:
    """Return a share in percent as text."""
    return f"{100.0 * share:.{digits}f} %"


def listed(values: Mapping[str, Any], form: str = "{}", separator: str = ", ", link: str = " ") -> str:
    """Return values by name as text.

    Parameters
    ----------
    values
        Values by name; a tuple fills as many fields of the format.
    form
        Format of a value, for :meth:`str.format`.
    separator
        Text between two entries.
    link
        Text between a name and its value.
    """
    texts = {name: form.format(*(value if isinstance(value, tuple) else (value,))) for name, value in values.items()}
    return separator.join(f"{name}{link}{text}" for name, text in texts.items())


def listed_times(times: Mapping[str, float]) -> str:
    """Return times by name [s] as text; infinity is "never"."""
    return listed({name: seconds(time) for name, time in times.items()})


def grid(
    corner: str | tuple[str, ...],
    rows: Mapping[Any, Row],
    columns: Mapping[str, Column],
    cell: Callable[[Row, Column], str],
) -> Cells:
    """Return a table with one cell for each pair of a row and a column.

    Parameters
    ----------
    corner
        Heading of the first column, which holds the names of the rows; several headings for names that are tuples.
    rows, columns
        Items by name.
    cell
        Text for an item of a row and one of a column.
    """
    body = [[*_parts(name), *(cell(row, column) for column in columns.values())] for name, row in rows.items()]
    return [[*_parts(corner), *columns], *body]


def _parts(name: str | tuple[str, ...]) -> tuple[str, ...]:
    return name if isinstance(name, tuple) else (name,)


def table(corner: str, rows: Mapping[str, Row], columns: Mapping[str, Callable[[Row], str]]) -> Cells:
    """Return a table whose columns are functions of a row; see :func:`grid`."""
    return grid(corner, rows, columns, lambda row, column: column(row))


def each(values: Iterable[Value], form: str, cell: Callable[[Row, Value], str]) -> dict[str, Callable[[Row], str]]:
    """Return columns of a :func:`table`, one for each value, named by a format."""

    def column(value: Value) -> Callable[[Row], str]:
        return lambda row: cell(row, value)

    return {form.format(value): column(value) for value in values}


def named(values: Iterable[Value], form: str = "{}") -> dict[str, Value]:
    """Return values by their text, for the rows or columns of a :func:`grid`."""
    return {form.format(value): value for value in values}


def pairs(first: Iterable[str], second: Iterable[str]) -> dict[tuple[str, str], tuple[str, str]]:
    """Return all pairs of names, for rows of a :func:`grid` with two columns of names."""
    return {pair: pair for pair in product(first, second)}


def milliseconds(periods: Iterable[float]) -> dict[str, float]:
    """Return periods [s] by their text in milliseconds."""
    return {f"{1000 * period:g}": period for period in periods}
