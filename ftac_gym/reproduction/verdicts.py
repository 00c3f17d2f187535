"""Claims of a paper, the numbers measured, and the verdict."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import partial
from importlib.resources import files
from typing import Any

from matplotlib.figure import Figure

from ftac_gym.evaluation.tables import Cells
from ftac_gym.reproduction.recordings import Recording, Recordings
from ftac_gym.reproduction.wording import percent, settled
from ftac_gym.utils.parameters import require

Measure = Callable[[Recording], Any]

MEASURES: Mapping[str, Measure] = {
    "settled": settled,
    "settled_1deg": partial(settled, angle=1.0),
    "steady": Recording.steady,
    "chatter": Recording.chatter,
    "peak": Recording.peak,
    "energy": Recording.energy,
    "saturated": lambda recording: percent(recording.saturated()),
}
"""Measures of a flight for the texts of all papers."""


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


class Finding:
    """Verdict on a claim, and the values for its text.

    Parameters
    ----------
    as_printed, otherwise
        Whether the claim holds as printed, and under the assumption in its note.
    **values
        Values for the text.
    """

    def __init__(self, as_printed: bool, otherwise: bool = False, /, **values: Any) -> None:
        self.verdict = judge(as_printed, otherwise)
        self.values = values


class _Measured(dict[str, Any]):
    """Measure of recordings by their names, taken at its first use."""

    def __init__(self, flights: Recordings, measure: Measure) -> None:
        self._flights, self._measure = flights, measure

    def __missing__(self, name: str) -> Any:
        self[name] = self._measure(self._flights[name])
        return self[name]


def written(
    paper: str, findings: Mapping[str, Finding], flights: Recordings, measures: Mapping[str, Measure]
) -> list[Claim]:
    """Return the claims of a paper, in the order of its texts.

    The file ``claims.toml`` of the paper has a table for each claim, with its source, its statement, the text of the
    numbers found and a note. Fields in braces stand for

    - values of the finding,
    - entries of the table ``shared``,
    - measures of a flight, as in ``{steady[NAME]:.2f}``.

    Parameters
    ----------
    paper
        Folder of the paper.
    findings
        Findings by the name of the claim's table.
    flights
        The flights.
    measures
        Measures of a flight by name, in addition to :data:`MEASURES`.

    Raises
    ------
    ValueError
        If a claim has no finding or a finding no claim.
    """
    texts = tomllib.loads((files("ftac_gym.reproduction") / paper / "claims.toml").read_text(encoding="utf-8"))
    known: dict[str, Any] = {name: _Measured(flights, item) for name, item in {**MEASURES, **measures}.items()}
    known.update({name: text.format(**known) for name, text in texts.pop("shared", {}).items()})
    require(set(texts) == set(findings), "findings", f"must be those of {sorted(texts)}", sorted(findings))
    claims = []
    for name, text in texts.items():
        fields = {**known, **findings[name].values}
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
    studies: dict[str, Cells]
    figures: dict[str, Figure]
