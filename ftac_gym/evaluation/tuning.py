"""Tune the gains of a baseline for the agents' objective, with CMA-ES; needs the ``train`` extra.

A study lies in a folder and goes on where it stopped. CMA-ES is asked for a whole generation, which is flown, by one
process or by many, before the next. Every trial is asked of a new sampler, whose state comes from the study alone: the
gains do not depend on the number of workers, nor on when and how often the study was killed, as long as the versions of
Optuna, cmaes and this package stay. One process at a time may run a study.
"""

from __future__ import annotations

import json
import logging
import math
import os
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from importlib.metadata import version
from multiprocessing import get_context, parent_process
from pathlib import Path
from typing import Any

import optuna
from optuna.storages import JournalStorage
from optuna.storages.journal import JournalFileBackend, JournalFileSymlinkLock
from optuna.trial import Trial, TrialState

import ftac_gym
from ftac_gym.baselines import tuned
from ftac_gym.evaluation.tuning_objective import FAILED, Search, mean_return
from ftac_gym.utils.parameters import require

JOURNAL = "study.journal"
"""File of a study in its folder."""
STALE = 5
"""Age at which a lock is taken for that of a killed process [s]; writing a trial takes milliseconds."""
_STUDY = "gains"


@dataclass(frozen=True)
class Result:
    """What a study found.

    Attributes
    ----------
    search
        What was tuned.
    trials, failed
        How many gains were flown, and how many of them were refused by the law or gave no finite return.
    gains
        The best.
    mean_return
        Their mean return over the feasible episodes of the search.
    """

    search: Search = field(repr=False)
    trials: int
    failed: int
    gains: dict[str, Any]
    mean_return: float


@contextmanager
def _quiet() -> Iterator[None]:
    """Let Optuna speak only of what is wrong."""
    before = optuna.logging.get_verbosity()
    optuna.logging.set_verbosity(logging.WARNING)
    try:
        yield
    finally:
        optuna.logging.set_verbosity(before)


def open_study(search: Search, folder: Path) -> optuna.Study:
    """Return the study in a folder, a new one if there is none.

    Raises
    ------
    ValueError
        If the study there has another setting; the message names what differs.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with _quiet():
        # The lock is a link to the journal. It has to be an absolute one: Optuna takes away the lock of a killed
        # process by the age of what it links to, and waits for ever, busily, for one that leads nowhere.
        journal = str((folder / JOURNAL).resolve())
        lock = JournalFileSymlinkLock(journal, grace_period=STALE)
        storage = JournalStorage(JournalFileBackend(journal, lock))
        # Optuna's own load_if_exists writes to a study that may be refused.
        if _STUDY in optuna.get_all_study_names(storage):
            study = optuna.load_study(study_name=_STUDY, storage=storage)
        else:
            study = optuna.create_study(study_name=_STUDY, storage=storage, direction="maximize")
        # Through JSON, as the study on disk is.
        now = json.loads(json.dumps(search.setting))
        then = study.user_attrs.get("setting")
        if then is None:
            study.set_user_attr("setting", now)
            then = now
        different = [
            name if isinstance(value, dict) or name == "scenario" else f"{name} ({then.get(name)!r}, now {value!r})"
            for name, value in now.items()
            if then.get(name) != value
        ]
        rule = f"must hold a study of the same setting; this one differs in {', '.join(different)}"
        require(not different, "folder", rule, str(folder))
        if not study.get_trials(deepcopy=False):
            study.enqueue_trial(search.start())
    return study


def _ask(study: optuna.Study, search: Search, number: int) -> Trial | None:
    """Return the trial of a number, with its point, or None if it is finished."""
    # A sampler that has been asked before draws from another place of its random numbers than one that has not.
    study.sampler = optuna.samplers.CmaEsSampler(seed=search.sampler_seed, popsize=search.population)
    known = study.get_trials(deepcopy=False)
    if number < len(known) and known[number].state.is_finished():
        return None
    if number < len(known) and known[number].state == TrialState.RUNNING:
        # A killed study asked for it but did not fly it. What it had not drawn yet is drawn as it would have been.
        trial = Trial(study, known[number]._trial_id)
    else:
        trial = study.ask()
    for name, item in search.space.items():
        trial.suggest_float(name, item.low, item.high, log=item.log)
    return trial


def _end_with_parent() -> None:
    parent = parent_process()
    assert parent is not None
    parent.join()
    os._exit(1)


def _watch_parent() -> None:
    """Let a worker end when the process that it works for is killed: it would wait for work forever."""
    threading.Thread(target=_end_with_parent, daemon=True).start()


@contextmanager
def _mapping(workers: int) -> Iterator[Callable[..., Iterable[float]]]:
    if workers == 1:
        yield map
        return
    # Spawned, not forked: a fork copies locks that other threads may hold.
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn"), initializer=_watch_parent) as pool:
        yield pool.map


def _finished(study: optuna.Study) -> list[optuna.trial.FrozenTrial]:
    return study.get_trials(deepcopy=False, states=(TrialState.COMPLETE,))


def _best(study: optuna.Study) -> float:
    return max((trial.value for trial in _finished(study) if trial.value is not None), default=FAILED)


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
        What to tune.
    folder
        Where the study lies, or shall lie.
    trials
        How many gains are flown in all, those on disk among them. A study that has more stays as it is.
    workers
        Processes that fly; they do not change the result.
    progress
        Called at the start and after every trial with the number of trials and the best mean return so far.

    Raises
    ------
    ValueError
        If a number is not positive, the study on disk has another setting, or none of the gains could be flown.
    """
    require(trials > 0, "trials", "must be positive", trials)
    require(workers > 0, "workers", "must be positive", workers)
    study = open_study(search, folder)
    size = search.population

    def report() -> None:
        if progress is not None:
            progress(len(_finished(study)), _best(study))

    report()
    with _quiet(), _mapping(min(workers, size)) as mapping:
        # The first trial is alone: CMA-ES learns the space from it. Then come generations.
        for first in (0, *range(1, trials, size)):
            last = first + size if first else 1
            # Of a generation that the budget cuts, all are asked: a larger budget later flies the same ones.
            asked = [trial for number in range(first, last) if (trial := _ask(study, search, number)) is not None]
            flown = [trial for trial in asked if trial.number < trials]
            values = mapping(partial(mean_return, search), [search.gains_at(trial.params) for trial in flown])
            for trial, value in zip(flown, values, strict=True):
                study.tell(trial, value)
                report()
    done = _finished(study)
    best = max(done, key=lambda trial: trial.values[0])
    failed = sum(trial.values[0] == FAILED for trial in done)
    require(failed < len(done), "trials", "must have one whose gains can be flown", len(done))
    return Result(search, len(done), failed, search.gains_at(best.params), best.values[0])


def store(result: Result, command: str, commit: str | None, fresh: Mapping[str, float]) -> Path:
    """Write tuned gains and where they come from into the package, for ``gains="tuned"``; return the file.

    Parameters
    ----------
    result
        What was found.
    command
        Command line that finds it again.
    commit
        Git commit of the code, or None.
    fresh
        Mean return by name of the gains, over the feasible episodes of the next seed.

    Raises
    ------
    ValueError
        If the gains do not give today what the study says: the law has changed since.
    """
    search = result.search
    today = mean_return(search, result.gains)
    same = math.isclose(today, result.mean_return, rel_tol=1e-6, abs_tol=1e-9)
    rule = f"must be what the gains still give, {today!r}: the law has changed since the study; tune it in a new folder"
    require(same, "mean_return", rule, result.mean_return)
    provenance = {
        "command": command,
        "commit": commit,
        "ftac_gym": ftac_gym.__version__,
        "sampler": f"optuna {version('optuna')}, CmaEsSampler of cmaes {version('cmaes')}",
        "sampler_seed": search.sampler_seed,
        "population": search.population,
        "baseline": search.baseline,
        "scenario": search.scenario.name,
        "seed": search.seed,
        "episodes": search.episodes,
        "trials": result.trials,
        "mean_return": result.mean_return,
        "fresh_seed": search.seed + 1,
        "fresh_mean_return": dict(fresh),
    }
    path = Path(str(tuned.FOLDER)) / f"{search.baseline}.json"
    path.parent.mkdir(parents=True, exist_ok=True)
    partial_file = path.with_suffix(".partial")
    partial_file.write_text(json.dumps({"gains": result.gains, "provenance": provenance}, indent=2) + "\n")
    partial_file.replace(path)
    return path
