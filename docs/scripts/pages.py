"""What the scripts that write pages share."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path


def write_if_changed(path: Path, text: str) -> None:
    """Write a text file, unless it has this content already: what did not change is not built again."""
    path.parent.mkdir(parents=True, exist_ok=True)
    if not path.exists() or path.read_text(encoding="utf-8") != text:
        path.write_text(text, encoding="utf-8")


def markdown_table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a Markdown table; bars within cells are escaped."""
    lines = [list(header), ["---"] * len(header), *(list(row) for row in rows)]
    return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines) + "\n"


def remove_strangers(folder: Path, kept: Iterable[Path]) -> None:
    """Delete the files of a generated folder that nothing writes any longer."""
    names = set(kept)
    for path in folder.iterdir():
        if path.is_file() and path not in names:
            path.unlink()
