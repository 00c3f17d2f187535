"""Benchmark: all entries on all splits, in parallel, with stored results that survive a kill."""

import warnings
from collections import defaultdict
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from importlib import import_module
from itertools import islice
from pathlib import Path

from ftac_gym.evaluation.batches import Batch, BatchResult, Evaluation, FlightError, batches, joined
from ftac_gym.evaluation.entries import Entry, entries_of, fitted
from ftac_gym.evaluation.identity import outside_classes
from ftac_gym.evaluation.timing import Stopwatch, step_cost
from ftac_gym.scenarios import SPLITS, frozen
from ftac_gym.task.episodes import Episodes
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.extras import naming_extra, require_extra
from ftac_gym.utils.files import reason_of
from ftac_gym.utils.parameters import require
from ftac_gym.utils.processes import end_with_parent
from ftac_gym.utils.serialization import serializable

with naming_extra():
    from joblib import Parallel, delayed, effective_n_jobs, parallel_config
    from joblib.externals.loky import get_reusable_executor

__all__ = ["BACKENDS", "Benchmark", "Entry", "Progress", "entries_of", "fly", "frozen_episodes"]

BACKENDS = ("local", "ray")
"""Backends that run batches: processes of this machine, or a Ray cluster."""

Progress = Callable[[str, str, int], None]
"""Called with split, name of the entry and number of episodes for each batch that is stored or has been run."""

_GROUP = 8
"""Batches per worker that a Ray cluster is given at a time: it returns results group by group."""

_Key = tuple[str, str, int, int]
"""Split, name of the entry, number of the training seed, number of the batch."""

_Flight = tuple[_Key, BatchResult | FlightError]

_Flights = Generator[_Flight, None, None]


@dataclass(frozen=True, eq=False)
class Benchmark:
    """Results of a benchmark.

    Attributes
    ----------
    entries
        The entries, without those that failed.
    episodes
        Episodes by split.
    evaluations
        One for each training seed, by split and name of the entry.
    reference
        Name of the entry that the others are compared with.
    step_cost
        One control step of one spacecraft [us], by name of the entry; empty if it was not measured.
    episodes_flown, seconds
        Number of episodes that were run now instead of found on disk, and the time for them [s].
    failures
        Failures in flight of the entries that are left out, by their names.
    """

    entries: tuple[Entry, ...]
    episodes: Mapping[str, Episodes]
    evaluations: Mapping[str, Mapping[str, tuple[Evaluation, ...]]]
    reference: str
    step_cost: Mapping[str, float]
    episodes_flown: int
    seconds: float
    failures: Mapping[str, str] = field(default_factory=dict)


def frozen_episodes(splits: Iterable[str] = SPLITS, feasible: int = frozen.FEASIBLE) -> dict[str, Episodes]:
    """Return the frozen episodes of some splits.

    Parameters
    ----------
    splits
        Among :data:`~ftac_gym.scenarios.splits.SPLITS`.
    feasible
        Number of feasible episodes of each; the infeasible ones between them are returned too.

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

    The numbers do not depend on backend and workers. An entry that fails in flight is left out; the others go on.

    Parameters
    ----------
    entries
        The entries.
    episodes
        Episodes by split; each is flown in the scenario that it was drawn from.
    reference
        Name of the entry that the others are compared with.
    folder
        Folder of stored results, in ``SPLIT/batches``, as of :func:`~ftac_gym.evaluation.evaluate`; those are not run
        again. None stores nothing.
    backend
        ``"local"`` for processes of this machine; ``"ray"`` for a Ray cluster: the connected one, else that of
        ``RAY_ADDRESS``, else a new one on this machine. Results are returned and stored here; agents need the same
        path on all machines.
    workers
        Number of parallel processes; -1 for the number of cores.
    progress
        Function to call for each batch.
    measure
        Whether to measure the cost of a control step, in the first of the splits.

    Raises
    ------
    ValueError
        If an entry does not fit a split, before any flight; or if entries share a name, or the reference or the
        backend is unknown.
    FlightError
        If the reference fails in flight, after all flights of the others.
    MissingExtra
        If the backend is Ray and it is not installed.
    """
    names = [entry.name for entry in entries]
    require(len(set(names)) == len(names), "entries", "must have names that differ", names)
    require(reference in names, "reference", f"must be one of {names}", reference)
    require(backend in BACKENDS, "backend", f"must be one of {list(BACKENDS)}", backend)
    require(workers != 0, "workers", "must be positive, or -1 for all cores", workers)
    require(len(episodes) > 0, "episodes", "must be given for a split at least", list(episodes))
    if backend == "ray":
        require_extra("ray")
        import_module("ray.util.joblib").register_ray()
    scenarios = {split: Scenario.from_json(item.scenario_json) for split, item in episodes.items()}
    jobs = {}
    for entry in entries:
        for seed, policy in enumerate(fitted(entry, list(scenarios.values()))):
            for split, scenario in scenarios.items():
                home = None if folder is None else folder / split / "batches"
                for number, batch in enumerate(batches(scenario, policy, episodes[split], home)):
                    # Paths of agents, not agents, are sent to the workers.
                    jobs[split, entry.name, seed, number] = replace(batch, policy=entry.policies[seed])
    results: dict[_Key, BatchResult] = {}
    failures: dict[str, str] = {}

    def finish(key: _Key, result: BatchResult) -> None:
        results[key] = result
        if progress is not None:
            progress(key[0], key[1], len(jobs[key].episodes))

    for key, batch in jobs.items():
        stored = batch.read()
        if stored is not None:
            finish(key, stored)
    missing = {key: batch for key, batch in jobs.items() if key not in results}
    # The calls are made one by one: those of an entry that has failed are left out.
    calls = ((key, batch) for key, batch in missing.items() if key[1] not in failures)
    stopwatch, flown_episodes = Stopwatch(), 0
    with stopwatch.running(), _ended(_flown(calls, backend, workers)) as flown:
        for key, result in flown:
            flown_episodes += len(jobs[key].episodes)
            if isinstance(result, FlightError):
                failures.setdefault(key[1], f"{key[1]} in {key[0]}: {result}")
            else:
                jobs[key].write(result)
                finish(key, result)
    if reference in failures:
        raise FlightError(f"{failures[reference]}; {reference} is the reference")
    remaining = tuple(entry for entry in entries if entry.name not in failures)
    parts = defaultdict(list)
    for key in jobs:
        if key[1] not in failures:
            parts[key[:3]].append(results[key])
    return Benchmark(
        entries=remaining,
        episodes=dict(episodes),
        evaluations={
            split: {
                entry.name: tuple(
                    joined(entry.name, parts[split, entry.name, seed]) for seed in range(len(entry.policies))
                )
                for entry in remaining
            }
            for split in scenarios
        },
        reference=reference,
        step_cost=_step_costs(remaining, next(iter(scenarios.values()))) if measure else {},
        episodes_flown=flown_episodes,
        seconds=stopwatch.seconds,
        failures=failures,
    )


def _step_costs(entries: Sequence[Entry], scenario: Scenario) -> dict[str, float]:
    """Return the costs of the entries' control steps; a warning names those that fail meanwhile."""
    found = {}
    for entry in entries:
        try:
            found[entry.name] = step_cost(entry, scenario)
        except Exception as error:
            warnings.warn(f"control step of {entry.name} cannot be measured: {reason_of(error)}", stacklevel=2)
    return found


def _fly(key: _Key, batch: Batch, kinds: Sequence[type]) -> _Flight:
    """Fly a batch, in any process."""
    for kind in kinds:
        serializable(kind)  # Classes of a script or notebook are sent as they are, and not registered by an import.
    try:
        return key, batch.fly()
    except FlightError as error:
        return key, error
    except ValueError as error:
        raise ValueError(f"{key[1]} in {key[0]}: {error}") from error


@contextmanager
def _ended(flights: _Flights) -> Iterator[_Flights]:
    """End the flights with the block, also after an error."""
    try:
        yield flights
    finally:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # joblib warns of cancelled calls
            flights.close()


def _flown(jobs: Iterable[tuple[_Key, Batch]], backend: str, workers: int) -> _Flights:
    """Yield results in the order in which they are finished."""
    calls = (delayed(_fly)(key, batch, outside_classes(batch.scenario)) for key, batch in jobs)
    if backend == "local":
        unordered = {"return_as": "generator_unordered", "initializer": end_with_parent}
        try:
            yield from Parallel(n_jobs=workers, batch_size=1, **unordered)(calls)
        finally:
            if effective_n_jobs(workers) > 1:
                # Idle workers would hold the output of this process open for minutes.
                get_reusable_executor(reuse=True).shutdown(kill_workers=True)
        return
    with parallel_config(backend="ray"), Parallel(n_jobs=workers, batch_size=1) as parallel:
        # joblib has no generator of results for Ray.
        size = _GROUP * effective_n_jobs(workers)
        while group := list(islice(calls, size)):
            yield from parallel(group)
