"""Reproductions of papers: their claims, beside numbers from flights under their equations.

Each paper is a folder: ``plans`` has its flights, ``measures`` what they are judged by, ``claims`` the verdicts with
their texts, ``report`` the studies and figures.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import ModuleType
from typing import NamedTuple

from ftac_gym.utils.extras import naming_extra

with naming_extra():
    from matplotlib.figure import Figure

    from ftac_gym.evaluation.tables import Cells
    from ftac_gym.reproduction import cao_2022, chen_2018, li_2023, ma_2023, zhang_zhou_2019
    from ftac_gym.reproduction.recordings import Plan, Recordings
    from ftac_gym.reproduction.verdicts import Finding, Measure, Reproduction, written


class Paper(NamedTuple):
    """Reproduction of a paper.

    Attributes
    ----------
    name
        Folder of the paper.
    plans
        Flights that the claims and the studies need, by name.
    findings
        Findings for the claims, from the flights.
    measures
        Measures of a flight in the texts of the claims.
    studies
        Tables of the extra studies, by title.
    draw
        Figures, by file name without ending.
    """

    name: str
    plans: Callable[[], dict[str, Plan]]
    findings: Callable[[Recordings], dict[str, Finding]]
    measures: Mapping[str, Measure]
    studies: Callable[[Recordings], dict[str, Cells]]
    draw: Callable[[Recordings], dict[str, Figure]]

    def evaluate(self, flights: Recordings) -> Reproduction:
        """Judge the claims, make the tables and draw the figures."""
        claims = written(self.name, self.findings(flights), flights, self.measures)
        return Reproduction(claims, self.studies(flights), self.draw(flights))


def _paper(folder: ModuleType) -> Paper:
    plans, claims, report = folder.plans, folder.claims, folder.report
    name = folder.__name__.rpartition(".")[2]
    return Paper(name, plans.plans, claims.findings, claims.MEASURES, report.studies, report.draw)


PAPERS = {paper.name: paper for paper in map(_paper, (cao_2022, chen_2018, li_2023, ma_2023, zhang_zhou_2019))}
"""Papers by the name of their folder."""

__all__ = ["PAPERS", "Paper"]
