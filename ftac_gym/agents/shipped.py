"""Folders of agents: a design with one agent for each training seed, and those that come with the package."""

from __future__ import annotations

import csv
import math
from pathlib import Path

from ftac_gym.utils.parameters import require

SHIPPED = Path(__file__).parent
"""Where the agents that come with the package lie: a folder for each design, in it one for each training seed."""

EVALUATIONS_FILE = "evaluations.csv"


def evaluations(folder: Path) -> list[dict[str, float]]:
    """Return the evaluations on the way of a training run, oldest first; none if there is no file of them."""
    path = folder / EVALUATIONS_FILE
    if not path.exists():
        return []
    with path.open() as file:
        return [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]


def seeds(folder: Path) -> list[Path]:
    """Return the folders of the training seeds in a folder of one design, in their order."""
    return sorted(folder.glob("seed_*"), key=lambda path: int(path.name.removeprefix("seed_")))


def designs() -> list[str]:
    """Return the names of the designs that come with the package."""
    return sorted(path.name for path in SHIPPED.iterdir() if seeds(path))


def shipped(design: str) -> Path:
    """Return the folder of an agent that comes with the package: of its seeds, the best in its own evaluations.

    Those episodes are neither of training nor of the test.

    Raises
    ------
    ValueError
        If there is no such design; the message lists those that there are.
    """
    require(design in designs(), "agent", f"must be one of {designs()}", design)

    def best(path: Path) -> float:
        return max((row["mean_return"] for row in evaluations(path)), default=-math.inf)

    return max(seeds(SHIPPED / design), key=best)
