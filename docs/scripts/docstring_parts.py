"""Read the docstrings of the package: their sections, their parameters, their tables."""

from __future__ import annotations

import inspect
import re

_ROLE = re.compile(r":(class|func|meth|mod|data|attr|exc):(`[^`]+`)")


def to_markdown(text: str) -> str:
    """Return text of a docstring as Markdown: its roles are written differently there."""
    return _ROLE.sub(r"{py:\1}\2", text)


def document(subject: object) -> str:
    """Return the docstring of an object without its indent."""
    return inspect.getdoc(subject) or ""


def numpy_section(text: str, title: str) -> dict[str, str]:
    """Return the entries of a NumPy section by name, each as one line of Markdown.

    Parameters
    ----------
    text
        Docstring without its indent.
    title
        ``"Parameters"``, ``"Raises"``, ...
    """
    match = re.search(rf"^{title}\n-{{3,}}\n(.*?)(?=^\w[\w ]*\n-{{3,}}\n|\Z)", text, re.S | re.M)
    entries: dict[str, str] = {}
    names: list[str] = []
    for line in match[1].splitlines() if match else []:
        if line and not line[0].isspace():
            names = [name.strip() for name in line.split(",")]
        elif line.strip():
            for name in names:
                entries[name] = f"{entries.get(name, '')} {line.strip()}".strip()
    return {name: to_markdown(text) for name, text in entries.items()}


def field_meanings(cls: type) -> dict[str, str]:
    """Return what each field of a data class means, those it inherits included."""
    meanings: dict[str, str] = {}
    for base in reversed(cls.__mro__):
        if base.__doc__ and base is not object:
            meanings |= numpy_section(inspect.cleandoc(base.__doc__), "Parameters")
    return meanings


def markdown_sections(text: str) -> dict[str, str]:
    """Return the sections of a docstring that is divided by Markdown headings of the second level; "" is its head."""
    parts = re.split(r"^## (.*)$", text, flags=re.M)
    return {"": parts[0].strip()} | {
        title.strip(): body.strip() for title, body in zip(parts[1::2], parts[2::2], strict=True)
    }


def simple_table(text: str) -> list[list[str]]:
    """Return the rows of the first simple table of reStructuredText in a docstring, continued cells joined."""
    lines = text.splitlines()
    borders = [index for index, line in enumerate(lines) if re.fullmatch(r"\s*=+( +=+)+", line)]
    starts: list[int | None] = [match.start() for match in re.finditer(r"=+", lines[borders[0]])]
    rows: list[list[str]] = []
    for line in lines[borders[0] + 1 : borders[1]]:
        cells = [line[start:end].strip() for start, end in zip(starts, [*starts[1:], None], strict=True)]
        if cells[0]:
            rows.append(cells)
        else:
            rows[-1] = [f"{old} {new}".strip() for old, new in zip(rows[-1], cells, strict=True)]
    return rows
