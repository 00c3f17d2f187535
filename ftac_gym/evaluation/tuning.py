"""Tuning of a baseline's gains for an objective with CMA-ES; needs the ``train`` extra.

A study is a folder with a journal and continues where it stopped. CMA-ES is asked for a whole generation, which one
process or several fly, before the next. A resumed study asks again for the gains in the journal and flies the rest.
The gains therefore depend neither on the number of workers nor on interruptions, for fixed versions of cmaes and of
this package.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from contextlib import nullcontext
from dataclasses import dataclass, field
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

import ftac_gym
from ftac_gym.baselines import tuned
from ftac_gym.evaluation.tuning_objective import FAILED, Search, value_of
from ftac_gym.evaluation.tuning_study import JOURNAL, Study, Trial
from ftac_gym.utils.extras import naming_extra
from ftac_gym.utils.files import locked, write_text
from ftac_gym.utils.parameters import require, whole
from ftac_gym.utils.processes import worker_pool

with naming_extra():
    from cmaes import CMA

__all__ = ["JOURNAL", "Result", "Study", "Trial", "store", "tune"]

SPREAD = 1.0 / 6.0
"""Initial standard deviation of CMA-ES, as a share of each range; its initial mean is the middle."""


@dataclass(frozen=True)
class Result:
    """Outcome of a study.

    Attributes
    ----------
    search
        Subject of the study.
    trials, failed
        Number of gains that were flown, and of those that the baseline refused or that gave no finite value.
    gains
        The best gains.
    value
        Their mean objective over the episodes of the search.
    """

    search: Search = field(repr=False)
    trials: int
    failed: int
    gains: dict[str, Any]
    value: float


def tune(
    search: Search,
    folder: Path,
    trials: int,
    workers: int = 1,
    progress: Callable[[int, float], None] | None = None,
) -> Result:
    """Run a study, or the rest of it.

    Parameters
    ----------
    search
        Subject of the study.
    folder
        Folder of the study.
    trials
        Number of gains that are flown in all, those in the journal included. A study with more stays as it is.
    workers
        Processes that fly; they do not change the result.
    progress
        Called at the start and after every trial with the number of trials and the best value so far.

    Raises
    ------
    ValueError
        If a number is not whole and positive, another process uses the folder, it holds another study, or none of the
        gains could be flown.
    OSError
        If the journal cannot be written, for example to a full disk. All finished trials are in it.
    """
    whole(trials, 1, "trials")
    whole(workers, 1, "workers")
    with locked(folder):
        return _tune(search, folder, trials, workers, progress)


def _tune(
    search: Search, folder: Path, trials: int, workers: int, progress: Callable[[int, float], None] | None
) -> Result:
    study, size, dimensions = Study(search, folder), search.population, len(search.space)
    bounds = np.tile([0.0, 1.0], (dimensions, 1))
    middle = np.full(dimensions, 0.5) if search.first == "default" else search.shares_at(search.start())
    optimizer = CMA(middle, SPREAD, bounds, seed=search.sampler_seed, population_size=size)

    def report() -> None:
        if progress is not None:
            progress(len(study.trials), study.best.value)

    def values(gains: list[dict[str, Any]], first: int) -> list[float]:
        """Return the values of consecutive trials; fly those within the budget that are not in the journal."""
        rule = "must hold the gains that this version of cmaes and of the baseline asks for; tune in a new folder"
        require(study.expect(gains, first), "folder", rule, str(folder))
        stored = study.trials[first : first + len(gains)]
        missing = gains[len(stored) : max(trials - first, 0)]
        recovered = [study.recover(item) for item in missing]
        unknown = [item for item, value in zip(missing, recovered, strict=True) if value is None]
        flown = iter(mapping(partial(value_of, search), unknown))
        for item, value in zip(missing, recovered, strict=True):
            study.add(Trial(item, next(flown) if value is None else value))
            report()
        return [trial.value for trial in study.trials[first : first + len(gains)]]

    report()
    with worker_pool(min(workers, size)) if workers > 1 else nullcontext() as pool:
        mapping: Any = map if pool is None else pool.map
        # The first trial is the baseline's own gains; then come generations.
        values([search.gains_at(search.start())], 0)
        for first in range(1, trials, size):
            # A generation is asked for in full even if the budget cuts it: a larger budget later flies the same gains.
            points = [optimizer.ask() for _ in range(size)]
            found = values([search.gains_at(search.point_at(point)) for point in points], first)
            if len(found) == size:
                optimizer.tell([(point, -value) for point, value in zip(points, found, strict=True)])
    failed = sum(trial.value == FAILED for trial in study.trials)
    require(failed < len(study.trials), "trials", "must have one whose gains can be flown", len(study.trials))
    return Result(search, len(study.trials), failed, study.best.gains, study.best.value)


def store(
    result: Result, command: str, commit: str | None, validation: Mapping[str, float], path: Path | None = None
) -> Path:
    """Write tuned gains and their provenance to a file, and return it.

    Parameters
    ----------
    result
        Outcome of the study.
    command
        Command line that finds it again.
    commit
        Git commit of the code, or None.
    validation
        Value by name of the gains, over the episodes of the validation.
    path
        The file, whose path is then the name of the gains; by default that of the package for ``gains="tuned"``.

    Raises
    ------
    ValueError
        If the gains do not reproduce the value of the study: the baseline has changed since.
    """
    search = result.search
    today = value_of(search, result.gains)
    same = math.isclose(today, result.value, rel_tol=1e-6, abs_tol=1e-9)
    rule = f"must be what the gains still give, {today!r}: the baseline has changed; tune it in a new folder"
    require(same, search.objective, rule, result.value)
    provenance = {
        "command": command,
        "commit": commit,
        "ftac_gym": ftac_gym.__version__,
        "sampler": f"CMA of cmaes {version('cmaes')}",
        **search.setting,
        "scenario": search.scenario.name,
        "trials": result.trials,
        "value": result.value,
        "validation_digest": search.validation().digest(),
        "validation_values": dict(validation),
    }
    path = Path(str(tuned.FOLDER)) / f"{search.baseline}.json" if path is None else path
    write_text(path, json.dumps({"gains": result.gains, "provenance": provenance}, indent=2) + "\n")
    return path
