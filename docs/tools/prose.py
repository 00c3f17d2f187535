"""Check the prose of the repository: docstrings, comments, messages, and the text of Markdown pages and notebooks.

Usage: ``python docs/tools/prose.py [PATH ...]``; without a path the whole repository is checked.
"""

from __future__ import annotations

import ast
import inspect
import io
import json
import re
import sys
import tokenize
from collections.abc import Iterator
from pathlib import Path

LONGEST = 25
"""Largest number of words in a sentence."""
OPENINGS = ("what", "where", "who", "whose", "whom", "how", "can", "whether", "why")
"""Words that open no docstring."""
BANNED = {
    r"craft": "spacecraft",
    r"contestants?": "policy or benchmark entry",
    r"pilots?": "policy or runner",
    r"surpris\w+": "unmodelled torque",
    r"(?:knows|that know|believes?|believed|forgets|remembers|obeys?|listens)": "a technical verb: code is no person",
    r"(?:gives? way|gave way|clothes|strangers?|hurry|newcomers?)": "a plain technical word",
    r"(?:shall|but for|of late|in spite of|likewise|thereby|whereby|hitherto|nought)": "plain words",
    r"(?:struck|strikes?|striking)": "occurs, acts or affected",
    r"(?:nobody|somebody|anybody|everybody|whoever|no one|someone|anyone|everyone)": "the thing itself",
    r"(?:soften\w*|mended|mends?|repaired|healed)": "scale, correct or clear",
}
"""Patterns of whole words, with the replacement."""
ROOTS = ("ftac_gym", "train", "benchmarks", "docs", "tests", "README.md", "CHANGELOG.md")
SUFFIXES = (".py", ".md", ".ipynb")
SKIPPED = ("generated", "_build", ".ipynb_checkpoints")

_BANNED = {re.compile(rf"\b{pattern}\b", re.IGNORECASE): instead for pattern, instead in BANNED.items()}
_CODE = re.compile(r"\{[\w:]+\}`+[^`]+`+|`+[^`]+`+|\$[^$]+\$|:[\w:]+:`[^`]+`|(?<=\])\([^)]*\)|https?://\S+")
_NO_PROSE = re.compile(r"[|#<!:>]|\.\. |[-=+ ]+$|\S.* {2,}\S")
"""Tables, headings, directives, options, borders, and rows of columns: they hold no sentences."""
_ITEM = re.compile(r" *(?:[-*]|\d+\.) +")


def without_code(text: str) -> str:
    """Replace fenced code, front matter, block equations and literal blocks by empty lines, inline code by ``X``."""
    for pattern in (r"^---\n.*?^---$", r"^ *(```+)(?!\{(?:note|figure|warning)).*?^ *\1$", r"\$\$.*?\$\$"):
        start = r"\A" if pattern.startswith("^---") else ""
        text = re.sub(start + pattern, lambda found: "\n" * found[0].count("\n"), text, flags=re.S | re.M)
    lines, last, literal = text.splitlines(), "", -1
    for index, line in enumerate(lines):
        indent = len(line) - len(line.lstrip())
        if line.strip() and indent <= literal:
            literal = -1
        # An equation is set off by its indentation alone, or follows a double colon.
        set_off = index and not lines[index - 1].strip() and last and indent >= 4 > len(last) - len(last.lstrip())
        if line.strip() and literal < 0 and (set_off or last.endswith("::")) and indent:
            literal = indent - 1
        last = line.rstrip() or last
        lines[index] = "" if literal >= 0 else _CODE.sub("X", line)
    return "\n".join(lines)


def sentences(text: str) -> Iterator[tuple[int, str]]:
    """Yield line offset and text of the sentences of running text; the items of a list are paragraphs."""
    paragraphs: list[tuple[int, int, list[str]]] = [(0, 0, [])]
    for number, line in enumerate(text.splitlines()):
        item = _ITEM.match(line)
        indent = item.end() if item else len(line) - len(line.lstrip())
        prose = line.strip() and not _NO_PROSE.match(line.strip())
        if not prose or item or indent != paragraphs[-1][1]:
            paragraphs.append((number, indent, []))
        if prose:
            paragraphs[-1][2].append(line[indent:].strip())
    for start, _, lines in paragraphs:
        for sentence in re.split(r"(?<=[.!?:])\s+(?=[A-Z`\"(])|(?<=;)\s+", " ".join(lines)):
            if sentence:
                yield start, sentence


def texts(path: Path) -> Iterator[tuple[int, str, str]]:
    """Yield line, kind (``page``, ``docstring``, ``comment`` or ``message``) and text of the prose in a file."""
    source = path.read_text(encoding="utf-8")
    if path.suffix == ".md":
        yield 1, "page", source
        return
    if path.suffix == ".ipynb":
        cells = json.loads(source)["cells"]
        yield 1, "page", "\n\n".join("".join(cell["source"]) for cell in cells if cell["cell_type"] == "markdown")
        return
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
            yield node.lineno, "docstring", inspect.cleandoc(node.value.value)
        elif isinstance(node, ast.Raise) or (isinstance(node, ast.Call) and ast.unparse(node.func) == "require"):
            for part in ast.walk(node):
                if isinstance(part, ast.Constant) and " " in str(part.value):
                    yield part.lineno, "message", str(part.value)
    lines = [""] * (source.count("\n") + 1)
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.COMMENT:
            lines[token.start[0] - 1] = token.string.lstrip("# ")
    yield 1, "comment", "\n".join(lines)


def complaints(path: Path) -> Iterator[str]:
    """Yield a line for each broken rule of a file."""
    for line, kind, text in texts(path):
        first = re.split(r"\W+", text, maxsplit=1)[0].lower()
        if kind == "docstring" and first in OPENINGS:
            yield f"{path}:{line}: a docstring opens with {first!r}: write a noun phrase or an imperative"
        plain = without_code(text)
        for offset, content in enumerate(plain.splitlines()):
            for pattern, instead in _BANNED.items():
                if found := pattern.search(content):
                    yield f"{path}:{line + offset}: {found.group()!r}: write {instead}"
        for offset, sentence in sentences(plain):
            count = len(re.findall(r"[A-Za-z][\w'-]+", sentence))
            if count > LONGEST:
                yield f"{path}:{line + offset}: a sentence of {count} words: at most {LONGEST}: {sentence[:60]!r}"


def main(arguments: list[str]) -> int:
    """Print all complaints; return 1 if there are any."""
    roots = [Path(argument) for argument in arguments or ROOTS]
    files = [file for root in roots for file in ([root] if root.is_file() else sorted(root.rglob("*")))]
    chosen = [file for file in files if file.suffix in SUFFIXES and not set(SKIPPED) & set(file.parts[:-1])]
    found = [line for file in chosen for line in complaints(file)]
    print("\n".join([*found, f"{len(found)} complaints about the prose of {len(chosen)} files"]))
    return min(len(found), 1)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
