"""Evaluation of a policy in batches of episodes, whose stored results survive a kill."""

import hashlib
import math
import warnings
import zipfile
import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ftac_gym import scenarios
from ftac_gym.dynamics.divergence import DivergenceError
from ftac_gym.evaluation.episodes import FEASIBLE, judging_episodes
from ftac_gym.evaluation.identity import identity
from ftac_gym.evaluation.metrics import UNITS, Metrics, Recoveries
from ftac_gym.evaluation.rollout import rollout
from ftac_gym.policies import DeferredBaseline, Policy, PolicyRunner, check_task, policy_label, resolve
from ftac_gym.scenarios import ScenarioLike
from ftac_gym.task.episodes import Episodes
from ftac_gym.task.scenario import Scenario, success_steps
from ftac_gym.utils.files import reading, reason_of, replacing
from ftac_gym.utils.parameters import require

BATCH = 100
"""Number of episodes that are run side by side and stored together."""

DIGEST = "digest"
"""Entry of a stored result beside the arrays: their SHA-256."""

BatchResult = dict[str, npt.NDArray[Any]]
"""Result of a batch: arrays (N,) by metric, and those of :data:`_HISTORIES` and :data:`_RECOVERIES`."""

_HISTORIES = ("attitude_error", "relative_error")
"""Arrays of a batch with the episode on the second axis [deg], in single precision."""

_RECOVERIES = {item.name: f"recovery_{item.name}" for item in fields(Recoveries)}
"""Arrays of a batch with the episode and the fault on the axes, by the fields of the recoveries."""


@dataclass(frozen=True, eq=False)
class Evaluation:
    """Result of a policy.

    Attributes
    ----------
    policy
        Name of the policy.
    metrics
        Arrays (N,) by name.
    attitude_error
        (T + 1, N) true pointing error [deg], single precision.
    relative_error
        (window, N) angle between the true error and its mean over the window of success [deg], single precision.
    recoveries
        Recoveries from the faults of the N episodes.
    """

    policy: str
    metrics: Metrics
    attitude_error: npt.NDArray[np.float32]
    relative_error: npt.NDArray[np.float32]
    recoveries: Recoveries


class FlightError(ValueError):
    """Failure of a policy in flight; the message names the episode."""


@dataclass(frozen=True, eq=False)
class Batch:
    """Episodes that a policy flies side by side.

    Attributes
    ----------
    scenario
        The task.
    policy
        See :func:`~ftac_gym.policies.resolve`.
    episodes
        The episodes.
    path
        File of the result; None if it is not stored.
    first
        Number of the first episode in the evaluation.
    """

    scenario: Scenario
    policy: Any
    episodes: Episodes
    path: Path | None
    first: int = 0

    def fly(self) -> BatchResult:
        """Run the policy through the episodes.

        Raises
        ------
        FlightError
            If it raises an error, or flies a spacecraft to a state that is not finite.
        ValueError
            If it does not fit the scenario.
        """
        try:
            return self._flown(slice(None))
        except Exception as error:
            PolicyRunner(self.scenario, resolve(self.policy, self.scenario.name))
            raise self._failure(error) from error

    def _flown(self, part: slice) -> BatchResult:
        history = rollout(self.scenario, self.policy, self.episodes[part])
        errors = {name: np.degrees(getattr(history, name)).astype(np.float32) for name in _HISTORIES}
        recoveries = history.recoveries()
        return {
            **history.metrics(),
            **errors,
            **{name: getattr(recoveries, part) for part, name in _RECOVERIES.items()},
        }

    def _failure(self, error: Exception) -> FlightError:
        """Return the error of the first episode that fails alone, which halving finds; else that of the batch."""
        low, high, found = 0, len(self.episodes), error
        while high - low > 1:
            middle = (low + high) // 2
            try:
                self._flown(slice(low, middle))
                low = middle
            except Exception as half:
                high, found = middle, half
        try:
            self._flown(slice(low, high))
            where, found = f"episodes {self.first} to {self.first + len(self.episodes) - 1} together", error
        except Exception as alone:
            where, found = f"episode {self.first + low}", alone
        kind = "" if isinstance(found, (ValueError, DivergenceError)) else f"{type(found).__name__}: "
        return FlightError(f"{where}: {kind}{reason_of(found)}")

    def read(self) -> BatchResult | None:
        """Return the stored result; None if there is none, or a damaged one, which a warning names."""
        if self.path is None or not self.path.exists():
            return None
        try:
            remedy = "its episodes are flown again"
            with reading(self.path, remedy, zipfile.BadZipFile, zlib.error), self.path.open("rb") as file:
                return self._checked(dict(np.load(file, allow_pickle=False)))
        except ValueError as error:
            warnings.warn(str(error), stacklevel=2)
            return None

    def _checked(self, result: BatchResult) -> BatchResult:
        count = len(self.episodes)
        samples = self.scenario.horizon + 1
        faults = math.prod(self.episodes.faults.shape[1:]) + self.episodes.sensor_faults.shape[1]
        types: dict[str, tuple[tuple[int, ...], str]] = dict.fromkeys(UNITS, ((count,), "float64"))
        types["attitude_error"] = ((samples, count), "float32")
        types["relative_error"] = ((success_steps(self.scenario), count), "float32")
        types |= dict.fromkeys(_RECOVERIES.values(), ((count, faults), "float64"))
        types["recovery_kind"], types["recovery_recovered"] = ((count, faults), "int64"), ((count, faults), "bool")
        digest = str(result.pop(DIGEST, "absent"))
        found = {name: (array.shape, array.dtype.name) for name, array in result.items()}
        for name in {**types, **found}:
            rule = f"must be {types.get(name, 'absent')}"
            require(types.get(name) == found.get(name), f"array {name}", rule, found.get(name))
        require(digest == _digest(result), DIGEST, "must be that of the arrays", digest)
        return result

    def write(self, result: BatchResult) -> None:
        """Store a result in the file of the batch, which appears complete or not at all."""
        if self.path is None:
            return
        with replacing(self.path) as file:
            np.savez_compressed(file, **result, **{DIGEST: np.array(_digest(result))})  # type: ignore[arg-type]


def _digest(result: BatchResult) -> str:
    """Return the SHA-256 of the arrays with their names and types."""
    digest = hashlib.sha256()
    for name, array in sorted(result.items()):
        digest.update(f"{name} {array.dtype.str} {array.shape} ".encode())
        digest.update(array.tobytes())
    return digest.hexdigest()


def batches(scenario: Scenario, policy: Policy, episodes: Episodes, folder: Path | None) -> list[Batch]:
    """Return the batches of some episodes.

    Parameters
    ----------
    scenario
        The task.
    policy
        A policy; results of one without an :func:`~ftac_gym.evaluation.identity.identity` are not stored.
    episodes
        The episodes.
    folder
        Folder of the results; None stores nothing.
    """
    known = None if folder is None else identity(scenario, policy)
    found = []
    for start in range(0, len(episodes), BATCH):
        part, path = episodes[start : start + BATCH], None
        if folder is not None and known is not None:
            path = folder / f"{hashlib.sha256(f'{known} {part.digest()}'.encode()).hexdigest()[:20]}.npz"
        found.append(Batch(scenario, policy, part, path, start))
    return found


def joined(name: str, results: Sequence[BatchResult]) -> Evaluation:
    """Return the evaluation of a policy from the results of all batches, in the order of the episodes."""
    axes = {key: int(key in _HISTORIES) for key in results[0]}
    arrays = {key: np.concatenate([result[key] for result in results], axis=axis) for key, axis in axes.items()}
    return Evaluation(
        name,
        metrics={metric: arrays[metric] for metric in UNITS},
        recoveries=Recoveries(**{part: arrays[key] for part, key in _RECOVERIES.items()}),
        **{key: arrays[key] for key in _HISTORIES},
    )


def evaluate(
    scenario: ScenarioLike,
    policy: Any,
    episodes: Episodes | int = FEASIBLE,
    name: str | None = None,
    folder: Path | None = None,
    progress: Callable[[int], None] | None = None,
) -> Evaluation:
    """Run a policy through episodes in batches.

    Parameters
    ----------
    scenario
        The task; see :func:`ftac_gym.scenarios.resolve`.
    policy
        See :func:`~ftac_gym.policies.resolve`.
    episodes
        Episodes, or the number of feasible ones: those of the frozen list for a split, and drawn ones otherwise
        (:func:`~ftac_gym.evaluation.episodes.judging_episodes`).
    name
        Name for tables; the default is the policy's own.
    folder
        Folder of stored results, which several processes may share. A batch of the same policy, task, episodes, code
        and data is not run again unless its file is damaged, which a warning says. None stores nothing.
    progress
        Called with the number of episodes of each finished batch.

    Raises
    ------
    FlightError
        If the policy fails in flight; the message names policy, scenario and episode.
    ValueError
        If it does not fit the scenario.

    Warns
    -----
    SampledInstability
        If the control period is too long for the gains of a baseline.
    """
    task, shown, results = scenarios.resolve(scenario), name if name is not None else policy_label(policy), []
    resolved = resolve(policy, task.name)
    check_task(resolved, task)
    if isinstance(resolved, DeferredBaseline):
        resolved.check_period(task)
    for batch in batches(task, resolved, judging_episodes(task, episodes), folder):
        result = batch.read()
        if result is None:
            try:
                result = batch.fly()
            except FlightError as error:
                raise FlightError(f"{shown} in {task.name}: {error}") from error
            batch.write(result)
        results.append(result)
        if progress is not None:
            progress(len(batch.episodes))
    return joined(shown, results)
