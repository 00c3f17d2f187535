"""Read the reproduction reports: which claims and which flights are about a baseline."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from baseline_facts import Reported
from pages import markdown_table

VERDICTS = ("reproduced", "reproduced under an assumption", "not reproduced")


@dataclass(frozen=True)
class Section:
    """A section of a report that holds a table.

    Parameters
    ----------
    title
        Its heading.
    header
        Heads of the columns.
    rows
        Cells, row by row.
    """

    title: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]

    @property
    def anchor(self) -> str:
        """What a link to its heading ends with."""
        return re.sub(r"[^\w\- ]", "", self.title.lower()).replace(" ", "-")


def cells(line: str) -> tuple[str, ...]:
    """Return the cells of a line of a Markdown table, with bars as they are."""
    return tuple(cell.strip().replace(r"\|", "|") for cell in re.split(r"(?<!\\)\|", line.strip())[1:-1])


def sections(text: str) -> list[Section]:
    """Return the sections of a report that hold tables, in their order."""
    found = []
    for block in re.split(r"^## ", text, flags=re.M)[1:]:
        title, _, body = block.partition("\n")
        lines = [cells(line) for line in body.splitlines() if line.startswith("|")]
        if lines:
            found.append(Section(title.strip(), lines[0], tuple(lines[2:])))
    return found


def claims_about(section: Section, pattern: str) -> list[tuple[str, ...]]:
    """Return the rows (where, claim, numbers, verdict, reason) of claims in which a pattern is found."""
    return [row for row in section.rows if re.search(pattern, "\n".join((*row[1:3], row[4])))]


def flights_of(section: Section, pattern: str) -> list[tuple[str, ...]]:
    """Return the rows of flights whose whole name matches a pattern."""
    return [row for row in section.rows if re.fullmatch(pattern, row[0])]


def plain(text: str) -> str:
    """Return text of a report so that Markdown leaves it as it is."""
    return re.sub(r"([*_`^~\[\]<>$])", r"\\\1", text)


def verdicts_in_words(rows: list[tuple[str, ...]], total: int) -> str:
    """Return how many claims, of all that a paper makes, have which verdict."""
    counts = Counter(row[3] for row in rows)
    words = [f"{counts[verdict]} {verdict}" for verdict in VERDICTS if counts[verdict]]
    return f"Of the {total} claims of the paper, {len(rows)} speak of it or are judged by it: {', '.join(words)}"


def reproduction(reported: Reported, source: Path) -> str:
    """Return what a report says of a baseline, as Markdown for a page two folders below ``docs``.

    Parameters
    ----------
    reported
        Where it speaks of it.
    source
        The folder ``docs``.
    """
    path = f"reproduction/{reported.report}/report.md"
    found = sections((source / path).read_text(encoding="utf-8"))
    blocks = []
    claims = next(section for section in found if section.title == "Claims")
    rows = claims_about(claims, reported.claims) if reported.claims else []
    if rows:
        link = f"[report](../../{path}#{claims.anchor})"
        blocks += [f"{verdicts_in_words(rows, len(claims.rows))}. The numbers behind the verdicts are in the {link}."]
        table = [(plain(row[0]), plain(row[1]), row[3], plain(row[4])) for row in rows]
        blocks += [markdown_table(("where", "claim", "verdict", "assumption or reason"), table)]
    schemes = next(section for section in found if section.title.startswith("All schemes"))
    if flown := flights_of(schemes, reported.flights):
        link = f"[report](../../{path}#{schemes.anchor})"
        blocks += [f"Its flights in the paper's example, from the {link}:"]
        blocks += [markdown_table([plain(cell) for cell in schemes.header], [[plain(c) for c in row] for row in flown])]
    return "\n\n".join(block.strip() for block in blocks)
