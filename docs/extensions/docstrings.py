"""What the package's docstrings need before Sphinx reads them.

They are NumPy docstrings for people who read the source, with habits that reStructuredText takes for something else:
headings in Markdown, as Gymnasium has them; |x| for magnitudes; formulas set off by their indent alone; prose where a
type is expected.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sphinx.application import Sphinx

_LITERAL = re.compile(r"(``.+?``|`.+?`)")
_TYPED = re.compile(r"(\w[\w, ]*) : (.+)")
_SPECIAL = re.compile(r"\||(?<=, )\*(?=\w+\))")
_SECTION = re.compile(r"-{3,}$")
_ARRAY = re.compile(r"~?numpy\.ndarray\[~?tuple\[~?(?:typing\.)?Any, \.\.\.\], ~?numpy\.dtype\[~?([\w.]+)\]\]")
_OBJECT = re.compile(r"= <.*?>")
_NO_TYPE = "NoType"
"""Stands where Napoleon expects the type of what is returned, and is taken out again: types are in the signature."""


def _indent(line: str) -> int:
    return len(line) - len(line.lstrip())


def mark_formulas(lines: list[str]) -> list[str]:
    """Return the lines with a literal block wherever an indented block follows a paragraph."""
    marked: list[str] = []
    last = ""
    for index, line in enumerate(lines):
        if line.strip():
            follows = index > 0 and not lines[index - 1].strip()
            if follows and last and _indent(line) >= 4 and _indent(last) == 0 and not last.endswith("::"):
                marked += ["::", ""]
            last = line
        marked.append(line)
    return marked


def escape(lines: list[str]) -> list[str]:
    """Return the lines with bars and stars escaped, but for literals: |x| is a magnitude, and (N, *shape) a shape."""
    escaped, block = [], None
    for line in lines:
        if block is not None and line.strip() and _indent(line) <= block:
            block = None
        if block is None:
            parts = _LITERAL.split(line)
            parts[::2] = [_SPECIAL.sub(r"\\\g<0>", part) for part in parts[::2]]
            escaped.append("".join(parts))
            if line.rstrip().endswith("::"):
                block = _indent(line)
        else:
            escaped.append(line)
    return escaped


def describe_returns(lines: list[str]) -> list[str]:
    """Return the lines with what is returned as a description instead of as a type."""
    for index in range(len(lines) - 1):
        if lines[index] in ("Returns", "Yields") and _SECTION.match(lines[index + 1]):
            start = end = index + 2
            while end < len(lines) and not (end + 1 < len(lines) and _SECTION.match(lines[end + 1])):
                end += 1
            described = [f"    {line}" if line.strip() else "" for line in lines[start:end]]
            return [*lines[:start], _NO_TYPE, *described, *describe_returns(lines[end:])]
    return lines


def name_fields(lines: list[str]) -> list[str]:
    """Return the lines with attributes listed as parameters, several to a line if need be: they are fields of data."""
    pairs = zip(lines, [*lines, ""][1:], strict=True)
    return ["Parameters" if line == "Attributes" and _SECTION.match(under) else line for line, under in pairs]


def describe_types(lines: list[str]) -> list[str]:
    """Return the lines with the words behind ``name :`` as the first sentence of the description."""
    described: list[str] = []
    for line in lines:
        match = _TYPED.fullmatch(line)
        described += [match[1], f"    {match[2]}."] if match else [line]
    return described


def prepare(what: str, lines: list[str]) -> list[str]:
    """Return the lines of a docstring as Sphinx should see them.

    Parameters
    ----------
    what
        What the docstring belongs to, as autodoc names it.
    lines
        Its lines.
    """
    lines = [f".. rubric:: {line[3:]}" if line.startswith("## ") else line for line in lines]
    lines = describe_types(describe_returns(escape(mark_formulas(lines))))
    if what == "class":
        lines = name_fields(lines)
    # The docstring of an attribute has no type before its first colon: it begins with an empty comment instead.
    return ["..", "", *lines] if what in ("attribute", "data", "property") else lines


def shorten(signature: str) -> str:
    """Return a signature, or what it returns, with arrays by their short names and defaults that can be parsed."""
    signature = _ARRAY.sub(r"numpy.typing.NDArray[\1]", signature)
    signature = signature.replace("numpy.typing.NDArray[numpy.float64]", "ftac_gym.utils.parameters.FloatArray")
    return _OBJECT.sub("= ...", signature)


def _sign(
    app: Sphinx, what: str, name: str, subject: object, options: object, signature: str | None, returned: str | None
) -> tuple[str | None, str | None]:
    return signature and shorten(signature), returned and shorten(returned)


def _before(app: Sphinx, what: str, name: str, subject: object, options: object, lines: list[str]) -> None:
    lines[:] = prepare(what, lines)


def _after(app: Sphinx, what: str, name: str, subject: object, options: object, lines: list[str]) -> None:
    lines[:] = [line for line in lines if not line.endswith(f"type: {_NO_TYPE}")]


def setup(app: Sphinx) -> dict[str, Any]:
    """Come before Napoleon, and after it."""
    app.connect("autodoc-process-signature", _sign)
    app.connect("autodoc-process-docstring", _before, priority=100)
    app.connect("autodoc-process-docstring", _after, priority=900)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
