"""Run several policies on identical episodes, in batches that survive a kill, and compare them."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

import ftac_gym
from ftac_gym.evaluation.metrics import SHARES, Metrics
from ftac_gym.evaluation.rollout import rollout
from ftac_gym.evaluation.statistics import Estimate, estimate, interquartile_mean, mean, paired_difference
from ftac_gym.evaluation.threads import one_torch_thread
from ftac_gym.faults import label_of
from ftac_gym.policies import Policy, resolve
from ftac_gym.task.episodes import Episodes
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray

BATCH = 100
"""Episodes that are run side by side and saved together."""


@cache
def code_digest() -> str:
    """Return a hash of the package's sources: results of other code are not to be mixed with this code's."""
    root = Path(ftac_gym.__file__).parent
    return hashlib.sha256(b"".join(path.read_bytes() for path in sorted(root.rglob("*.py")))).hexdigest()


@dataclass(frozen=True, eq=False)
class Evaluation:
    """What a policy achieved.

    Attributes
    ----------
    policy
        Its name.
    metrics
        Arrays (N,) by name.
    attitude_error
        (T + 1, N) true pointing error [deg], single precision.
    """

    policy: str
    metrics: Metrics
    attitude_error: npt.NDArray[np.float32]


BatchResult = dict[str, npt.NDArray[Any]]
"""What is kept of a batch: arrays (N,) by metric, and ``attitude_error`` (T + 1, N) [deg]."""


def batches(episodes: Episodes) -> list[Episodes]:
    """Cut episodes into batches."""
    return [episodes[start : start + BATCH] for start in range(0, len(episodes), BATCH)]


def fly_batch(scenario: Scenario, contestant: Policy, batch: Episodes) -> BatchResult:
    """Run a contestant through a batch."""
    with one_torch_thread():
        history = rollout(scenario, contestant, batch)
    return {**history.metrics(), "attitude_error": np.degrees(history.attitude_error).astype(np.float32)}


def batch_file(folder: Path | None, contestant: Policy, scenario: Scenario, batch: str) -> Path | None:
    """Return where the result of a batch lies or shall lie; None if it is not kept.

    Parameters
    ----------
    folder
        Folder of the batches; None keeps nothing.
    contestant
        Who flies; one without a fingerprint cannot be told from others, and nothing of it is kept.
    scenario
        The task.
    batch
        Digest of the episodes.
    """
    fingerprint = getattr(contestant, "fingerprint", None)
    if folder is None or fingerprint is None:
        return None
    identity = f"{code_digest()} {fingerprint} {scenario.to_json()} {batch}"
    return folder / f"{hashlib.sha256(identity.encode()).hexdigest()[:20]}.npz"


def read_batch(path: Path | None) -> BatchResult | None:
    """Return the result in a file; None if there is none."""
    if path is None or not path.exists():
        return None
    with np.load(path) as data:
        return dict(data)


def write_batch(path: Path | None, result: BatchResult) -> None:
    """Write a result to a file, which appears whole or not at all; nothing without a path."""
    if path is None:
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_suffix(".partial")
    with partial.open("wb") as file:
        np.savez_compressed(file, **result)  # type: ignore[arg-type]
    partial.rename(path)


def assembled(name: str, results: Sequence[BatchResult]) -> Evaluation:
    """Join the results of all batches, in the order of the episodes."""
    histories = np.concatenate([result["attitude_error"] for result in results], axis=1)
    metrics = {
        key: np.concatenate([result[key] for result in results]) for key in results[0] if key != "attitude_error"
    }
    return Evaluation(name, metrics, histories)


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
        Where finished batches are kept; a batch that lies there and was made by the same policy on the same episodes
        is not run again. None keeps nothing.
    progress
        Called with the number of episodes finished.
    """
    contestant = resolve(policy)
    finished = []
    for batch in batches(episodes):
        path = batch_file(folder, contestant, scenario, batch.digest())
        result = read_batch(path)
        if result is None:
            result = fly_batch(scenario, contestant, batch)
            write_batch(path, result)
        finished.append(result)
        if progress is not None:
            progress(len(batch))
    return assembled(name if name is not None else str(policy), finished)


@dataclass(frozen=True)
class Row:
    """One policy in a table: estimates by metric, and paired differences to the reference."""

    policy: str
    estimates: Mapping[str, Estimate]
    differences: Mapping[str, Estimate]


ERROR_AND_VIBRATION = "error_and_vibration"
"""Integrated error plus modal energy, each over the mean of the policy that others are compared with: what tables of
flexible craft have besides the metrics of episodes. It is a mean."""

_BOUND_METRICS = ("bound_kept", "bound_margin")
_VIBRATION_METRICS = ("jitter", "modal_energy", "residual_energy", "vibration_torque")

TABLE_METRICS = (
    "success",
    "settling_time",
    "final_error",
    "integrated_error",
    "peak_after_fault",
    "recovery_time",
    "energy",
    "chatter",
    *_BOUND_METRICS,
    *_VIBRATION_METRICS,
)
"""Metrics of the table, as far as the scenario has them (of rigid craft not the jitter either).

Of shares it is the mean, of the others the interquartile mean.
"""


def compare(evaluations: list[Evaluation], reference: str, chosen: npt.NDArray[np.bool_]) -> list[Row]:
    """Tabulate policies over some of the episodes.

    Parameters
    ----------
    evaluations
        One per policy, all on the same episodes.
    reference
        Name of the policy that the others are compared with; differences are policy minus reference.
    chosen
        (N,) which episodes count.

    Raises
    ------
    ValueError
        If the reference is not among the policies.
    """
    by_name = {evaluation.policy: evaluation for evaluation in evaluations}
    if reference not in by_name:
        raise ValueError(f"reference must be one of {sorted(by_name)}, got {reference!r}")
    base = by_name[reference].metrics
    rows = []
    bounded, flexible = (not np.isnan(base[metric]).all() for metric in ("bound_kept", "modal_energy"))
    left_out = (*(() if bounded else _BOUND_METRICS), *(() if flexible else _VIBRATION_METRICS))
    metrics = [metric for metric in TABLE_METRICS if metric not in left_out]
    for evaluation in evaluations:
        estimates, differences = {}, {}
        for metric in metrics:
            statistic = mean if metric in SHARES else interquartile_mean
            values = evaluation.metrics[metric][chosen]
            estimates[metric] = estimate(values, statistic)
            if evaluation.policy != reference:
                differences[metric] = paired_difference(values, base[metric][chosen])
        if flexible:
            sums = [_error_and_vibration(item, base, chosen) for item in (evaluation.metrics, base)]
            estimates[ERROR_AND_VIBRATION] = estimate(sums[0], mean)
            if evaluation.policy != reference:
                differences[ERROR_AND_VIBRATION] = paired_difference(sums[0], sums[1])
        rows.append(Row(evaluation.policy, estimates, differences))
    return rows


def _error_and_vibration(metrics: Metrics, base: Metrics, chosen: npt.NDArray[np.bool_]) -> FloatArray:
    """Return the sum of integrated error and modal energy (N,), each over the reference's mean: the reference has 2."""
    parts = (metrics[name][chosen] / np.mean(base[name][chosen]) for name in ("integrated_error", "modal_energy"))
    total: FloatArray = sum(parts, start=np.zeros(int(chosen.sum())))
    return total


def fault_classes(episodes: Episodes) -> npt.NDArray[np.str_]:
    """Return what is wrong in each episode, in words: a fault kind, "healthy", or how many faults there are.

    Several faults of one wheel count as one, of the kind that stands last in :class:`~ftac_gym.faults.FaultKind`.
    """
    kinds = np.concatenate([episodes.faults["kind"].max(axis=2), episodes.sensor_faults["kind"]], axis=1)
    counts = (kinds > 0).sum(axis=1)
    labels = []
    for row, count in zip(kinds, counts, strict=True):
        labels.append(label_of(int(row.max())) if count <= 1 else f"{count} faults")
    return np.array(labels)
