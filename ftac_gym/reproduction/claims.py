"""Claims of a paper, what was measured, and the verdict."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import Enum

from matplotlib.figure import Figure

from ftac_gym.evaluation.tables import Cells


class Verdict(Enum):
    """What became of a claim."""

    REPRODUCED = "reproduced"
    ASSUMED = "reproduced under an assumption"
    NOT = "not reproduced"


@dataclass(frozen=True)
class Claim:
    """A claim as printed and what was found.

    Attributes
    ----------
    source
        Where it stands.
    statement
        What it says, in our words.
    found
        The numbers measured.
    verdict
        What follows from them.
    note
        The assumption, or why not.
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


def claim_table(claims: Sequence[Claim]) -> Cells:
    """Return the claims as rows of text, with a heading."""
    rows = [[item.source, item.statement, item.found, item.verdict.value, item.note] for item in claims]
    return [["where", "claim", "our numbers", "verdict", "assumption or reason"], *rows]


@dataclass(frozen=True)
class Reproduction:
    """All that reproducing a paper gives.

    Attributes
    ----------
    claims
        The claim table.
    studies
        Tables of the extra studies, by title.
    figures
        Figures, by file name without ending.
    """

    claims: Sequence[Claim]
    studies: dict[str, Cells] = field(default_factory=dict)
    figures: dict[str, Figure] = field(default_factory=dict)
