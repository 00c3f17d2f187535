"""Numbers as text, and tables of them, for the reports of all papers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, TypeVar

import numpy as np

from ftac_gym.evaluation.tables import Cells
from ftac_gym.reproduction.recorder import Recording

Row = TypeVar("Row")
Column = TypeVar("Column")


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
    corner: str, rows: Mapping[str, Row], columns: Mapping[str, Column], cell: Callable[[Row, Column], str]
) -> Cells:
    """Return a table with one cell for each pair of a row and a column.

    Parameters
    ----------
    corner
        Heading of the first column, which holds the names of the rows.
    rows, columns
        Items by name.
    cell
        Text for an item of a row and one of a column.
    """
    body = [[name, *(cell(row, column) for column in columns.values())] for name, row in rows.items()]
    return [[corner, *columns], *body]


def table(corner: str, rows: Mapping[str, Row], columns: Mapping[str, Callable[[Row], str]]) -> Cells:
    """Return a table whose columns are functions of a row; see :func:`grid`."""
    return grid(corner, rows, columns, lambda row, column: column(row))


def named(values: Any, form: str = "{}") -> dict[str, Any]:
    """Return values by their text, for the rows or columns of a :func:`grid`."""
    return {form.format(value): value for value in values}
