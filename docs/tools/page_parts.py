"""Parts of generated pages: Markdown tables, values as text, and the meaning of fields by their docstrings."""

from __future__ import annotations

import dataclasses
import inspect
import math
import re
import shutil
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from docutils import nodes
from docutils.core import publish_doctree
from numpydoc.docscrape import NumpyDocString


def markdown(text: str) -> str:
    """Return text of a docstring as Markdown, in which roles are written differently."""
    return re.sub(r":(class|func|meth|mod|data|attr|exc):(`[^`]+`)", r"{py:\1}\2", text)


def class_link(value: object) -> str:
    """Return a reference to the class of an object."""
    return f"{{py:class}}`~{type(value).__module__}.{type(value).__name__}`"


def table(header: Sequence[str], rows: Iterable[Sequence[str]], literal: bool = False) -> str:
    """Return a Markdown table; bars within cells are escaped, and with ``literal`` all markup."""
    special = r"[|*_`^~\[\]<>$]" if literal else r"\|"
    lines = [[re.sub(special, r"\\\g<0>", cell) for cell in row] for row in (header, *rows)]
    lines.insert(1, ["---"] * len(header))
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def section(cls: type, title: str) -> dict[str, str]:
    """Return the entries of a section in the NumPy docstrings of a class and its base classes by name."""
    found: dict[str, str] = {}
    for base in reversed(inspect.getmro(cls)[:-1]):
        for entry in NumpyDocString(inspect.cleandoc(base.__doc__ or ""))[title]:
            text = markdown(" ".join(line.strip() for line in entry.desc))
            found |= dict.fromkeys((entry.name or entry.type).split(", "), text)
    return found


def table_rows(text: str) -> list[list[str]]:
    """Return the cells of the tables in a docstring, row by row."""
    tree = publish_doctree(inspect.cleandoc(text), settings_overrides={"report_level": 5})
    return [[entry.astext().replace("\n", " ") for entry in row.children] for row in tree.findall(nodes.row)]


def show(value: Any, interval: bool = False) -> str:
    """Return a value as text; with ``interval`` a pair of numbers is a range instead of a vector."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int | float):
        return f"{value:.4g}"
    if isinstance(value, tuple):
        numbers = all(isinstance(item, int | float) for item in value)
        if not numbers and not interval:
            return "; ".join(", ".join(map(show, item)) if isinstance(item, tuple) else show(item) for item in value)
        cells = [show(item, interval) for item in value]
        if numbers and interval and len(cells) == 2:
            return " to ".join(cells)
        same = len(cells) > 1 and len(set(cells)) == 1
        return f"{cells[0]} each" if same else (", " if numbers else "; ").join(cells)
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        inner = [f"{name} {f'({text})' if ', ' in text else text}" for name, text in field_values(value).items()]
        return f"{type(value).__name__}: " + ", ".join(inner)
    return str(value)


def field_values(part: Any, changed: bool = False) -> dict[str, str]:
    """Return the fields of a part as text by name: those with an effect, or those that differ from the default."""
    values = {item: getattr(part, item.name) for item in dataclasses.fields(part)}
    return {
        item.name: show(value, interval="Interval" in str(item.type))
        for item, value in values.items()
        if value is not None and (value != item.default or (np.any(value) and not changed))
    }


def field_table(part: Any, *without: str) -> str:
    """Return a table of the fields of a part, except some: value, in degrees too where it is an angle, and meaning."""
    meanings, rows = section(type(part), "Parameters"), []
    for name, text in field_values(part).items():
        value, meaning = getattr(part, name), meanings.get(name, "")
        angles = value if isinstance(value, tuple) and len(value) == 2 else (value,)
        unit = re.search(r"\[rad(/s)?\]", meaning)
        if unit and all(isinstance(angle, float) and angle != 0.0 for angle in angles):
            text += f" ({' to '.join(show(math.degrees(angle)) for angle in angles)} deg{unit[1] or ''})"
        rows += [] if name in without else [(f"`{name}`", text, meaning)]
    return table(("field", "value", "meaning"), rows)


def write_pages(folder: Path, pages: Mapping[str, str | bytes]) -> None:
    """Write the files of a generated folder by their names, and nothing else into it."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for name, content in pages.items():
        (folder / name).write_bytes(content.encode() if isinstance(content, str) else content)
