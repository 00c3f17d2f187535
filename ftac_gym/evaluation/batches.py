"""Evaluation of a policy in batches of episodes, whose stored results survive a kill."""

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ftac_gym.evaluation.metrics import Metrics
from ftac_gym.evaluation.rollout import rollout
from ftac_gym.evaluation.threads import one_torch_thread
from ftac_gym.policies import Policy, resolve
from ftac_gym.task.episodes import Episodes
from ftac_gym.task.scenario import Scenario

BATCH = 100
"""Number of episodes that are run side by side and stored together."""

BatchResult = dict[str, npt.NDArray[Any]]
"""Result of a batch: arrays (N,) by metric, and ``attitude_error`` (T + 1, N) [deg]."""


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
    """

    policy: str
    metrics: Metrics
    attitude_error: npt.NDArray[np.float32]


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
    """

    scenario: Scenario
    policy: Any
    episodes: Episodes
    path: Path | None

    def fly(self) -> BatchResult:
        """Run the policy through the episodes."""
        with one_torch_thread():
            history = rollout(self.scenario, self.policy, self.episodes)
        return {**history.metrics(), "attitude_error": np.degrees(history.attitude_error).astype(np.float32)}

    def read(self) -> BatchResult | None:
        """Return the stored result; None if there is none."""
        if self.path is None or not self.path.exists():
            return None
        with np.load(self.path) as data:
            return dict(data)

    def write(self, result: BatchResult) -> None:
        """Store a result in the file of the batch, which appears complete or not at all."""
        if self.path is None:
            return
        self.path.parent.mkdir(parents=True, exist_ok=True)
        partial = self.path.with_suffix(".partial")
        with partial.open("wb") as file:
            np.savez_compressed(file, **result)  # type: ignore[arg-type]
        partial.rename(self.path)


@cache
def code_digest() -> str:
    """Return a hash of the package's sources: stored results of other code are not used."""
    sources = sorted(Path(__file__).parents[1].rglob("*.py"))
    return hashlib.sha256(b"".join(path.read_bytes() for path in sources)).hexdigest()


def batches(scenario: Scenario, policy: Policy, episodes: Episodes, folder: Path | None) -> list[Batch]:
    """Return the batches of some episodes.

    Parameters
    ----------
    scenario
        The task.
    policy
        A policy; without a fingerprint it cannot be told from others, and its results are not stored.
    episodes
        The episodes.
    folder
        Folder of the results; None stores nothing.
    """
    fingerprint = getattr(policy, "fingerprint", None)
    identity = f"{code_digest()} {fingerprint} {scenario.to_json()}"
    found = []
    for start in range(0, len(episodes), BATCH):
        part, path = episodes[start : start + BATCH], None
        if folder is not None and fingerprint is not None:
            path = folder / f"{hashlib.sha256(f'{identity} {part.digest()}'.encode()).hexdigest()[:20]}.npz"
        found.append(Batch(scenario, policy, part, path))
    return found


def joined(name: str, results: Sequence[BatchResult]) -> Evaluation:
    """Return the evaluation of a policy from the results of all batches, in the order of the episodes."""
    axes = {key: int(key == "attitude_error") for key in results[0]}
    metrics = {key: np.concatenate([result[key] for result in results], axis=axis) for key, axis in axes.items()}
    return Evaluation(name, attitude_error=metrics.pop("attitude_error"), metrics=metrics)


def evaluate(
    scenario: Scenario,
    policy: Any,
    episodes: Episodes,
    name: str | None = None,
    folder: Path | None = None,
    progress: Callable[[int], None] | None = None,
) -> Evaluation:
    """Run a policy through episodes in batches.

    Parameters
    ----------
    scenario
        The task.
    policy
        See :func:`~ftac_gym.policies.resolve`.
    episodes
        The episodes.
    name
        Name for tables; the default is the policy's own.
    folder
        Folder of stored results. A batch of the same policy, task, episodes and code is not run again. None stores
        nothing.
    progress
        Called with the number of episodes of each finished batch.
    """
    results = []
    for batch in batches(scenario, resolve(policy, scenario.name), episodes, folder):
        result = batch.read()
        if result is None:
            result = batch.fly()
            batch.write(result)
        results.append(result)
        if progress is not None:
            progress(len(batch.episodes))
    return joined(name if name is not None else str(policy), results)
