"""Fly all contestants through all splits, in parallel, in batches that survive a kill."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from copy import copy
from dataclasses import dataclass
from importlib import import_module
from itertools import islice
from pathlib import Path
from typing import Any

from joblib import Parallel, delayed, effective_n_jobs, parallel_config

from ftac_gym.evaluation.compare import (
    BatchResult,
    Evaluation,
    assembled,
    batch_file,
    batches,
    fly_batch,
    read_batch,
    write_batch,
)
from ftac_gym.evaluation.entries import Entry, entries_of, fitted
from ftac_gym.evaluation.timing import Stopwatch, step_cost
from ftac_gym.policies import resolve
from ftac_gym.scenarios import SPLITS, frozen
from ftac_gym.task.episodes import Episodes
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import require

__all__ = ["BACKENDS", "Benchmark", "Entry", "Progress", "entries_of", "fly", "frozen_episodes"]

BACKENDS = ("local", "ray")
"""Where batches are flown: in processes of this machine, or on a Ray cluster."""

Progress = Callable[[str, str, int], None]
"""Called with split, name of the entry and number of episodes for each batch that is there or has been flown."""

_GROUP = 8
"""Batches per worker that a Ray cluster is given at a time: it hands results back group by group."""


@dataclass(frozen=True, eq=False)
class Benchmark:
    """What everyone achieved.

    Attributes
    ----------
    entries
        Who took part.
    episodes
        What was flown, by split.
    evaluations
        One for each training seed, by split and name of the entry.
    reference
        Name of the entry that the others are compared with.
    step_cost
        One control step of one craft [us], by name of the entry; empty if it was not measured.
    episodes_flown, seconds
        How many episodes were flown now, not found on disk, and how long that took [s].
    """

    entries: tuple[Entry, ...]
    episodes: Mapping[str, Episodes]
    evaluations: Mapping[str, Mapping[str, tuple[Evaluation, ...]]]
    reference: str
    step_cost: Mapping[str, float]
    episodes_flown: int
    seconds: float


@dataclass(frozen=True)
class _Key:
    """Whose batch it is: split, name of the entry, number of the training seed, number of the batch."""

    split: str
    entry: str
    seed: int
    batch: int


@dataclass(frozen=True, eq=False)
class _Task:
    """A batch to fly; its episodes say of which scenario they are."""

    key: _Key
    policy: Any
    batch: Episodes


_Flights = Generator[tuple[_Key, BatchResult], None, None]


def frozen_episodes(splits: Iterable[str] = SPLITS, feasible: int = frozen.FEASIBLE) -> dict[str, Episodes]:
    """Return the frozen episodes of some splits.

    Parameters
    ----------
    splits
        Among :data:`ftac_gym.scenarios.SPLITS`.
    feasible
        How many feasible episodes are wanted of each; the infeasible ones on the way are there too.

    Raises
    ------
    ValueError
        If a split is unknown, or has fewer episodes.
    """
    splits = tuple(splits)
    for split in splits:
        require(split in SPLITS, "splits", f"must be among {list(SPLITS)}", split)
    return {split: frozen.load(split, feasible) for split in splits}


def fly(
    entries: Sequence[Entry],
    episodes: Mapping[str, Episodes],
    reference: str,
    folder: Path | None = None,
    backend: str = "local",
    workers: int = -1,
    progress: Progress | None = None,
    measure: bool = True,
) -> Benchmark:
    """Fly all entries through the episodes of all splits.

    The numbers do not depend on backend and workers.

    Parameters
    ----------
    entries
        Who takes part.
    episodes
        What is flown, by split; each is flown in the scenario that it was drawn from.
    reference
        Name of the entry that the others are compared with.
    folder
        Where finished batches are kept, in ``SPLIT/batches``, as :func:`~ftac_gym.evaluation.compare.evaluate` does;
        those that lie there are not flown again. None keeps nothing.
    backend
        ``"local"`` for processes of this machine; ``"ray"`` for a Ray cluster: that which is connected to, else that
        of ``RAY_ADDRESS``, else a new one on this machine. Results travel back and are written here; agents have to
        lie under the same path on all machines.
    workers
        How many fly in parallel; -1 for as many as there are cores.
    progress
        What to call for each batch.
    measure
        Whether to measure the cost of a control step, in the first of the splits.

    Raises
    ------
    ValueError
        If an entry does not fit a split, before anything is flown; or if entries share a name, or the reference or the
        backend is unknown.
    ImportError
        If Ray is asked for and not installed.
    """
    names = [entry.name for entry in entries]
    require(len(set(names)) == len(names), "entries", "must have names that differ", names)
    require(reference in names, "reference", f"must be one of {names}", reference)
    require(backend in BACKENDS, "backend", f"must be one of {list(BACKENDS)}", backend)
    require(workers != 0, "workers", "must be positive, or -1 for all cores", workers)
    require(len(episodes) > 0, "episodes", "must be given for a split at least", list(episodes))
    if backend == "ray":
        _register_ray()
    tasks = {split: Scenario.from_json(item.scenario_json) for split, item in episodes.items()}
    contestants = {entry.name: fitted(entry, list(tasks.values())) for entry in entries}
    report = progress if progress is not None else _silent
    results: dict[_Key, BatchResult] = {}
    paths: dict[_Key, Path | None] = {}
    missing: list[_Task] = []
    for split, scenario in tasks.items():
        home = None if folder is None else folder / split / "batches"
        for number, batch in enumerate(batches(episodes[split])):
            digest = batch.digest()
            for entry in entries:
                for seed, contestant in enumerate(contestants[entry.name]):
                    key = _Key(split, entry.name, seed, number)
                    paths[key] = batch_file(home, contestant, scenario, digest)
                    found = read_batch(paths[key])
                    if found is None:
                        missing.append(_Task(key, entry.policies[seed], batch))
                    else:
                        results[key] = found
                        report(split, entry.name, len(batch))
    stopwatch = Stopwatch()
    with stopwatch.running(), _ended(_flown(missing, backend, workers)) as flown:
        for key, result in flown:
            write_batch(paths[key], result)
            results[key] = result
            report(key.split, key.entry, result["attitude_error"].shape[1])
    evaluations = {
        split: {entry.name: _joined(entry, split, len(batches(episodes[split])), results) for entry in entries}
        for split in tasks
    }
    return Benchmark(
        entries=tuple(entries),
        episodes=dict(episodes),
        evaluations=evaluations,
        reference=reference,
        step_cost={entry.name: step_cost(entry, next(iter(tasks.values()))) for entry in entries} if measure else {},
        episodes_flown=sum(len(task.batch) for task in missing),
        seconds=stopwatch.seconds,
    )


def _silent(split: str, entry: str, episodes: int) -> None:
    """Report nothing."""


def _joined(entry: Entry, split: str, count: int, results: Mapping[_Key, BatchResult]) -> tuple[Evaluation, ...]:
    """Return the evaluations of an entry, one per training seed."""
    return tuple(
        assembled(entry.name, [results[_Key(split, entry.name, seed, number)] for number in range(count)])
        for seed in range(len(entry.policies))
    )


def _fly_task(task: _Task) -> tuple[_Key, BatchResult]:
    """Fly a batch, in whatever process."""
    try:
        contestant = resolve(copy(task.policy))
        return task.key, fly_batch(Scenario.from_json(task.batch.scenario_json), contestant, task.batch)
    except ValueError as error:
        raise ValueError(f"{task.key.entry} in {task.key.split}: {error}") from error


@contextmanager
def _ended(flights: _Flights) -> Iterator[_Flights]:
    """End the flights with the block, whatever ends it: nobody flies on for nothing."""
    try:
        yield flights
    finally:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # joblib's, of what is cancelled: that is meant
            flights.close()


def _flown(tasks: Sequence[_Task], backend: str, workers: int) -> _Flights:
    """Yield results as they come."""
    calls = (delayed(_fly_task)(task) for task in tasks)
    if backend == "local":
        yield from Parallel(n_jobs=workers, batch_size=1, return_as="generator_unordered")(calls)
        return
    with parallel_config(backend="ray"), Parallel(n_jobs=workers, batch_size=1) as parallel:
        # joblib has no generator of results for Ray.
        size = _GROUP * effective_n_jobs(workers)
        while group := list(islice(calls, size)):
            yield from parallel(group)


def _register_ray() -> None:
    """Make Ray known to joblib."""
    try:
        import_module("ray.util.joblib").register_ray()
    except ImportError:
        raise ImportError("backend 'ray' needs Ray: pip install 'ftac-gym[cluster]'") from None
