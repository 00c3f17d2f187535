"""Folders of agents: a design with one agent for each training seed, and those that come with the package."""

import csv
import math
from pathlib import Path

SHIPPED = Path(__file__).parent
"""Folder of the agents that come with the package: a folder for each design, in it one for each training seed."""

EVALUATIONS_FILE = "evaluations.csv"
"""File of the evaluations during a training."""


def evaluations(folder: Path) -> list[dict[str, float]]:
    """Return the evaluations of a training run, oldest first; none if there is no file."""
    path = folder / EVALUATIONS_FILE
    if not path.exists():
        return []
    with path.open() as file:
        return [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]


def seeds(folder: Path) -> list[Path]:
    """Return the folders of the training seeds in the folder of a design, in their order."""
    return sorted(folder.glob("seed_*"), key=lambda path: int(path.name.removeprefix("seed_")))


def designs() -> list[str]:
    """Return the names of the designs that come with the package."""
    return sorted(path.name for path in SHIPPED.iterdir() if seeds(path))


def agent_folders(path: Path) -> list[Path]:
    """Return the folder or file of each agent at a path: one for each training seed, in their order.

    Parameters
    ----------
    path
        A folder with one folder for each training seed (``seed_*``), the folder of a run, that of an agent, or the zip
        file of a model.
    """
    return [folder / "agent" if (folder / "agent").is_dir() else folder for folder in seeds(path) or [path]]


def training_curve(agent: Path) -> list[dict[str, float]]:
    """Return the evaluations of an agent's training, oldest first; none if they are not stored."""
    # A run has its evaluations beside the agent, an agent that was handed on in its own folder.
    return evaluations(agent.parent if agent.name == "agent" else agent)


def best_agent(path: Path) -> Path:
    """Return the agent at a path that is the best of its training seeds in its own evaluations.

    The episodes of these evaluations belong neither to training nor to the test.
    """

    def mean_return(agent: Path) -> float:
        return max((row["mean_return"] for row in training_curve(agent)), default=-math.inf)

    return max(agent_folders(path), key=mean_return)
