"""Claims of a paper, the numbers measured, and the verdict."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from importlib.resources import files
from typing import Any

from matplotlib.figure import Figure

from ftac_gym.evaluation.tables import Cells
from ftac_gym.utils.parameters import require


class Verdict(Enum):
    """Outcome of a claim."""

    REPRODUCED = "reproduced"
    ASSUMED = "reproduced under an assumption"
    NOT = "not reproduced"


@dataclass(frozen=True)
class Claim:
    """A claim of a paper with the numbers found for it.

    Attributes
    ----------
    source
        Section, figure, table or theorem of the paper.
    statement
        Content of the claim, in our words.
    found
        The numbers measured.
    verdict
        Outcome by these numbers.
    note
        The assumption, or the reason why the claim does not hold.
    """

    source: str
    statement: str
    found: str
    verdict: Verdict
    note: str = ""


def judge(as_printed: bool, otherwise: bool = False) -> Verdict:
    """Return the verdict for a claim that holds as printed, or else under the assumption in its note."""
    if as_printed:
        return Verdict.REPRODUCED
    return Verdict.ASSUMED if otherwise else Verdict.NOT


@dataclass(frozen=True)
class Finding:
    """Verdict on a claim, and the values for its text."""

    verdict: Verdict
    values: Mapping[str, Any]


def finding(as_printed: bool, otherwise: bool = False, /, **values: Any) -> Finding:
    """Return the verdict of :func:`judge` with values for the text of a claim."""
    return Finding(judge(as_printed, otherwise), values)


def written(paper: str, findings: Mapping[str, Finding], values: Mapping[str, Any] | None = None) -> list[Claim]:
    """Return the claims of a paper, in the order of its texts.

    The file ``claims.toml`` of the paper has a table for each claim, with its source, its statement, the text of the
    numbers found and a note. In the last two, fields in braces stand for values of the finding or for entries of the
    table ``shared``.

    Parameters
    ----------
    paper
        Folder of the paper.
    findings
        Findings by the name of the claim's table.
    values
        Values for the texts of all claims.

    Raises
    ------
    ValueError
        If a claim has no finding or a finding no claim.
    """
    texts = tomllib.loads((files("ftac_gym.reproduction") / paper / "claims.toml").read_text(encoding="utf-8"))
    shared = dict(values or {})
    shared.update({name: text.format(**shared) for name, text in texts.pop("shared", {}).items()})
    require(set(texts) == set(findings), "findings", f"must be those of {sorted(texts)}", sorted(findings))
    claims = []
    for name, text in texts.items():
        fields = {**shared, **findings[name].values}
        found, note = (text.get(part, "").format(**fields) for part in ("found", "note"))
        claims.append(Claim(text["source"], text["statement"], found, findings[name].verdict, note))
    return claims


def claim_table(claims: Sequence[Claim]) -> Cells:
    """Return the claims as rows of text, with a heading."""
    rows = [[item.source, item.statement, item.found, item.verdict.value, item.note] for item in claims]
    return [["where", "claim", "our numbers", "verdict", "assumption or reason"], *rows]


@dataclass(frozen=True)
class Reproduction:
    """Claims, studies and figures of a paper that was reproduced.

    Attributes
    ----------
    claims
        The claims in the order of the report.
    studies
        Tables of the extra studies, by title.
    figures
        Figures, by file name without ending.
    """

    claims: Sequence[Claim]
    studies: dict[str, Cells] = field(default_factory=dict)
    figures: dict[str, Figure] = field(default_factory=dict)
