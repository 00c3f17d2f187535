"""Evaluations of a training run: the table of all, and the best agent, which survives any kill."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from ftac_gym.agents.shipped import EVALUATIONS_FILE, evaluations, score
from ftac_gym.agents.storage import CARD_FILE, read_card
from ftac_gym.evaluation.files import write_rows
from ftac_gym.utils.files import reading, replacing
from ftac_gym.utils.parameters import require

AGENT = "agent"
"""Folder of the best agent in that of a run."""


class Evaluations:
    """Table of a run's evaluations, one for each number of steps, with that of the agent in the folder ``agent``.

    The card of the agent holds its evaluation, so that both change in one moment, and no later evaluation is compared
    with a forgotten one. A resumed run repeats the evaluations after its checkpoint, except that of the agent: as long
    as it is the best, its row stays.

    Parameters
    ----------
    folder
        Folder of the run.
    steps
        Steps of the checkpoint that the run continues from.

    Raises
    ------
    ValueError
        If the table or the card of the agent is damaged. A torn last line of the table is left out, with a word.
    """

    def __init__(self, folder: Path, steps: int) -> None:
        self._path = folder / EVALUATIONS_FILE
        _drop_torn_line(self._path)
        self._rows = {int(row["steps"]): row for row in evaluations(folder) if row["steps"] <= steps}
        self._best: tuple[float, float] | None = None
        if (folder / AGENT / CARD_FILE).exists():
            best = _evaluation_of(folder / AGENT)
            self._best = score(best)
            self._rows[int(best["steps"])] = best

    def add(self, steps: int, metrics: Mapping[str, float], save: Callable[[dict[str, Any]], None]) -> None:
        """Add an evaluation to the table, after saving its agent if that is the best so far.

        Parameters
        ----------
        steps
            Steps of the agent.
        metrics
            Its evaluation, ``mean_return`` among the metrics.
        save
            Function that saves the agent in the folder ``agent`` with this evaluation in its card.
        """
        row = {"steps": float(steps), **metrics}
        # The first agent is saved even if no evaluation episode was feasible.
        if self._best is None or score(row) > self._best:
            # JSON has no NaN.
            save({name: value if math.isfinite(value) else None for name, value in metrics.items()})
            self._best = score(row)
            # A row of later steps was that of the agent before.
            self._rows = {key: value for key, value in self._rows.items() if key < steps} | {steps: row}
        self._rows.setdefault(steps, row)
        self._write()

    def _write(self) -> None:
        rows = [{**self._rows[steps], "steps": steps} for steps in sorted(self._rows)]
        names = list(dict.fromkeys(name for row in rows for name in row))
        write_rows(self._path, [names, *([row.get(name, "nan") for name in names] for row in rows)])


def _evaluation_of(agent: Path) -> dict[str, float]:
    """Return the evaluation in the card of a run's agent, as a row of the table."""
    card = read_card(agent)
    with reading(agent / CARD_FILE, "remove the folder of this agent: the next best one will be kept"):
        metrics = card["evaluation"]
        for name, value in metrics.items():
            require(value is None or type(value) in (int, float), name, "must be a number or null", value)
        row = {name: math.nan if value is None else float(value) for name, value in metrics.items()}
        return {"steps": float(card["steps"]), "mean_return": row["mean_return"], **row}


def _drop_torn_line(path: Path) -> None:
    """Leave out a last line that was written in part."""
    if not path.exists():
        return
    with reading(path, "restore it, or remove it to go on without the earlier rows"):
        whole, newline, torn = path.read_bytes().rpartition(b"\n")
    if torn and newline:
        print(f"{path}: the last line is torn and left out: {torn[:40]!r}")  # noqa: T201
        with replacing(path) as file:
            file.write(whole + newline)
