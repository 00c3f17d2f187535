"""Folders of agents: a design with one agent for each training seed, and those that come with the package."""

import csv
import math
import os
import re
from collections.abc import Mapping
from pathlib import Path

from ftac_gym.utils.files import reading
from ftac_gym.utils.parameters import require

SHIPPED = Path(__file__).parent
"""Folder of the agents that come with the package: a folder for each design, in it one for each training seed."""

EVALUATIONS_FILE = "evaluations.csv"
"""File of the evaluations during a training."""


def evaluations(folder: Path) -> list[dict[str, float]]:
    """Return the evaluations of a training run, oldest first; none if there is no file.

    Raises
    ------
    ValueError
        If the file is damaged.
    """
    path = folder / EVALUATIONS_FILE
    if not os.path.lexists(path):
        return []
    with reading(path, "remove the damaged line, or the file if it is no table", csv.Error):
        # A value that was cut off is a number too.
        text = path.read_text(encoding="utf-8")
        require(text.endswith("\n"), "the last line", "must be whole", text[-20:])
        rows = csv.DictReader(text.splitlines())
        columns = list(rows.fieldnames or ())
        for name in ("steps", "mean_return"):
            require(columns.count(name) == 1, "line 1", f"must have the column {name} once", columns)
        return [_numbers(row, line) for line, row in enumerate(rows, 2)]


def _numbers(row: Mapping[str | None, str | None], line: int) -> dict[str, float]:
    numbers: dict[str, float] = {}
    for name, text in row.items():
        try:
            numbers[str(name)] = float(text or "")
        except (TypeError, ValueError):  # None is the column, or the value, of a line that is too long or too short
            require(False, f"line {line}", f"must have a number for each column, {name} too", text)
    require(numbers["steps"].is_integer(), f"line {line}", "must have a whole number of steps", numbers["steps"])
    return numbers


def seeds(folder: Path) -> list[Path]:
    """Return the folders of the training seeds in the folder of a design, in their order.

    Anything else beside them, for example a copy ``seed_0_backup``, is no seed.
    """
    found = {
        int(path.name[5:]): path for path in folder.glob("seed_*") if re.fullmatch("seed_(0|[1-9][0-9]*)", path.name)
    }
    return [found[seed] for seed in sorted(found)]


def designs() -> list[str]:
    """Return the names of the designs that come with the package."""
    return sorted(path.name for path in SHIPPED.iterdir() if seeds(path))


def agent_folders(path: Path) -> list[Path]:
    """Return the folder or file of each agent at a path: one for each training seed, in their order.

    Parameters
    ----------
    path
        A folder with one folder for each training seed (``seed_K``), the folder of a run, that of an agent, or the zip
        file of a model.
    """
    return [folder / "agent" if (folder / "agent").is_dir() else folder for folder in seeds(path) or [path]]


def training_curve(agent: Path) -> list[dict[str, float]]:
    """Return the evaluations of an agent's training, oldest first; none if they are not stored."""
    # A run has its evaluations beside the agent, an agent that was handed on in its own folder.
    return evaluations(agent.parent if agent.name == "agent" else agent)


def best_agent(path: Path) -> Path:
    """Return the agent at a path that is the best of its training seeds in its own evaluations.

    The episodes of these evaluations are those of the validation: neither training nor test has them.
    """

    def best_score(agent: Path) -> tuple[float, float]:
        return max(map(score, training_curve(agent)), default=(-math.inf, -math.inf))

    return max(agent_folders(path), key=best_score)


def score(row: Mapping[str, float]) -> tuple[float, float]:
    """Return what agents are compared by in their evaluations: the mean availability, and the mean return in a tie.

    Both are minus infinity where no episode was feasible, or where the table has no such column.
    """
    values = (row.get("availability", -math.inf), row["mean_return"])
    availability, mean_return = (-math.inf if math.isnan(value) else value for value in values)
    return availability, mean_return
