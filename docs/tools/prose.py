"""Check of the prose: docstrings, comments, messages in code, and the text of Markdown pages.

Usage: ``python docs/tools/prose.py [PATH ...]``; without a path the whole repository is checked.
"""

from __future__ import annotations

import ast
import io
import re
import sys
import tokenize
from collections.abc import Iterator
from pathlib import Path

LONGEST = 25
"""Words that a sentence may have."""
OPENINGS = ("what", "where", "who", "whose", "whom", "how", "can", "whether", "why")
"""Words that the first sentence of a docstring must not begin with."""
BANNED = {
    r"craft": "spacecraft",
    r"contestants?": "policy or benchmark entry",
    r"pilots?": "policy or runner",
    r"surpris\w+": "unmodelled torque",
    r"(?:knows|believes|believed|forgets|remembers|obeys?|listens)": "a plain technical verb: code is no person",
    r"(?:gives? way|gave way|clothes|strangers?|hurry|newcomers?)": "a plain technical word",
    r"(?:shall|but for|of late|in spite of|likewise|thereby|whereby|hitherto|nought)": "plain words",
    r"(?:struck|strikes?|striking)": "occurs, acts or affected",
    r"(?:nobody|somebody|anybody|everybody|whoever|no one|someone|anyone|everyone)": "the thing itself",
    r"(?:soften\w*|mended|mends?|repaired|healed)": "scale, correct or clear",
    r"so that it\b.*\bso that": "two sentences",
}
"""Patterns of whole words, with what to write instead."""
ROOTS = ("ftac_gym", "train", "benchmarks", "docs", "tests", "README.md", "CHANGELOG.md")
SKIPPED = ("generated", "_build", "reproduction")

_BANNED = {re.compile(rf"\b{pattern}\b", re.IGNORECASE): instead for pattern, instead in BANNED.items()}


def sentences(text: str) -> Iterator[tuple[int, str]]:
    """Yield line offsets and sentences of running text; code, literals, tables, lists of fields are left out."""
    paragraphs: list[tuple[int, list[str]]] = [(0, [])]
    fenced = False
    for number, line in enumerate(text.splitlines()):
        fenced ^= line.lstrip().startswith(("```", ":::"))
        plain = re.sub(r"`[^`]*`|\$[^$]*\$|\[([^\]]*)\]\([^)]*\)", r"\1 X", line).strip()
        skipped = fenced or not plain or plain.startswith(("|", "#", "```", ">>>", "---", "===", "..", "<", "!"))
        if skipped or re.match(r"[-*] |\d+\. ", plain) or len(line) - len(line.lstrip()) != _indent(paragraphs):
            paragraphs.append((number, []))
        if not skipped:
            paragraphs[-1][1].append(line if not fenced else "")
    for start, lines in paragraphs:
        whole = re.sub(r"`[^`]*`|\$[^$]*\$", "X", " ".join(part.strip() for part in lines))
        for sentence in re.split(r"(?<=[.!?:;])\s+(?=[A-Z`\"(])", whole):
            if sentence:
                yield start, sentence


def _indent(paragraphs: list[tuple[int, list[str]]]) -> int:
    lines = paragraphs[-1][1]
    return len(lines[-1]) - len(lines[-1].lstrip()) if lines else -1


def texts_of(path: Path) -> Iterator[tuple[int, str, bool]]:
    """Yield line, text and whether it is a docstring, for all prose of a file."""
    source = path.read_text(encoding="utf-8")
    if path.suffix == ".md":
        yield 1, source, False
        return
    for node in ast.walk(ast.parse(source)):
        for statement in getattr(node, "body", None) or [] if not isinstance(node, ast.Lambda | ast.IfExp) else []:
            value = getattr(statement, "value", None)
            if isinstance(statement, ast.Expr) and isinstance(value, ast.Constant) and isinstance(value.value, str):
                yield statement.lineno, value.value, True
    comment: list[tuple[int, str]] = []
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.COMMENT:
            comment.append((token.start[0], token.string.lstrip("# ")))
    for line, text in comment:
        yield line, text, False


def complaints(path: Path) -> Iterator[str]:
    """Yield what breaks a rule in a file."""
    for line, text, docstring in texts_of(path):
        first = re.split(r"\W+", text.strip(), maxsplit=1)[0].lower() if docstring else ""
        if first in OPENINGS:
            yield f"{path}:{line}: a docstring opens with {first!r}: write a noun phrase or an imperative"
        for offset, sentence in sentences(text):
            for pattern, instead in _BANNED.items():
                if found := pattern.search(sentence):
                    yield f"{path}:{line + offset}: {found.group()!r}: write {instead}"
            count = len(re.findall(r"[A-Za-z][\w'-]*", sentence))
            if count > LONGEST:
                yield f"{path}:{line + offset}: a sentence of {count} words: at most {LONGEST}: {sentence[:60]!r}"


def main(arguments: list[str]) -> int:
    """Print all complaints; return 1 if there are any."""
    roots = [Path(argument) for argument in arguments or ROOTS]
    files = [file for root in roots for file in ([root] if root.is_file() else sorted(root.rglob("*")))]
    chosen = [file for file in files if file.suffix in (".py", ".md") and not set(SKIPPED) & set(file.parts[:-1])]
    found = [line for file in chosen for line in complaints(file)]
    print("\n".join([*found, f"{len(found)} complaints about the prose of {len(chosen)} files"]))
    return min(len(found), 1)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
