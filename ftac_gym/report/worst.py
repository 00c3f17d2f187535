"""Episodes in which an agent, or the reference, does worst, and how to fly them again."""

from __future__ import annotations

import json
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ftac_gym import baselines
from ftac_gym.plots import faults_in_words
from ftac_gym.report.results import Results, values
from ftac_gym.task.episodes import Episodes

if TYPE_CHECKING:
    from ftac_gym.evaluation.benchmark import Benchmark, Entry

COUNT = 5
"""Episodes of each split."""

SHOWN = ("success", "settling_time", "final_error", "integrated_error")
"""Metrics that are listed."""


@dataclass(frozen=True, eq=False)
class Worst:
    """An episode in which an entry does badly.

    Attributes
    ----------
    split, index
        Which episode.
    entry
        Name of the entry.
    seed
        Which of its training seeds does worst there, from 0 on.
    faults
        What is wrong, in words.
    own, reference
        Metrics of that seed and of the reference.
    command
        What flies both again; empty where a policy has no name or file.
    """

    split: str
    index: int
    entry: str
    seed: int
    faults: str
    own: Mapping[str, float]
    reference: Mapping[str, float]
    command: str


def worst_episodes(results: Results) -> list[Worst]:
    """Return the worst feasible episodes of every split, those of the best agent of each tier, else of the reference.

    An agent is judged by how much longer than the reference it takes to settle, mean over its seeds, and by how much
    larger its integrated error is where that is the same; the reference by its own.
    """
    benchmark = results.benchmark
    agents: dict[str, Entry] = {}
    for entry in results.entries():
        if entry.kind == "agent" and entry.role != "bound":
            agents.setdefault(entry.tier, entry)
    judged = list(agents.values()) or [entry for entry in results.entries() if entry.name == benchmark.reference]
    return [item for split in benchmark.episodes for entry in judged for item in _worst(benchmark, split, entry)]


def _worst(benchmark: Benchmark, split: str, entry: Entry) -> list[Worst]:
    own, base = (
        {metric: values(benchmark, split, name, metric) for metric in SHOWN}
        for name in (entry.name, benchmark.reference)
    )
    own_loss, base_loss = (
        [item[metric].mean(axis=0) for metric in ("integrated_error", "settling_time")] for item in (own, base)
    )
    if entry.name != benchmark.reference:
        own_loss = [mine - other for mine, other in zip(own_loss, base_loss, strict=True)]
    episodes = benchmark.episodes[split]
    candidates = np.flatnonzero(episodes.feasible)
    order = np.lexsort([loss[candidates] for loss in own_loss])[::-1]
    reference = next(item for item in benchmark.entries if item.name == benchmark.reference)
    found = []
    for index in candidates[order[:COUNT]].tolist():
        seed = int(np.lexsort([own[metric][:, index] for metric in ("integrated_error", "settling_time")])[-1])
        found.append(
            Worst(
                split,
                index,
                entry.name,
                seed,
                faults_in_words(episodes, index),
                {metric: float(item[seed, index]) for metric, item in own.items()},
                {metric: float(item[:, index].mean()) for metric, item in base.items()},
                replay_command(split, episodes, index, [policy_name(entry, seed), policy_name(reference, 0)]),
            )
        )
    return found


def replay_command(split: str, episodes: Episodes, index: int, names: Sequence[str | None]) -> str:
    """Return the command that flies a feasible episode again and draws it.

    Parameters
    ----------
    split
        Scenario of the episodes.
    episodes
        Its episodes.
    index
        Which of them.
    names
        Policies as :func:`policy_name` calls them, the reference last.

    Returns
    -------
    The command, or nothing if a policy has no name.
    """
    known = [name for name in names if name is not None]
    if len(known) < len(names):
        return ""
    # The list ends with this episode: nothing else need be flown.
    count = int(episodes.feasible[: index + 1].sum())
    words = ["python", "train/evaluate.py", "--policies", *dict.fromkeys(known), "--reference", known[-1]]
    return shlex.join([*words, "--scenario", split, "--splits", "--episodes", str(count), "--detail", str(index)])


def law_of(entry: Entry) -> str | None:
    """Return the name of the law of a baseline of this package; None for anything else."""
    policy = entry.policies[0]
    fingerprint = getattr(policy, "fingerprint", None)
    law = json.loads(fingerprint)[0] if entry.kind == "baseline" and fingerprint else policy
    return law if isinstance(law, str) and law in baselines.names() else None


def policy_name(entry: Entry, seed: int) -> str | None:
    """Return what ``train/evaluate.py --policies`` calls a policy of an entry; None if it has no name for it."""
    law = law_of(entry)
    if law is not None:
        return f"{law} tuned" if entry.gains == "tuned" else law
    if not isinstance(entry.policies[seed], (str, Path)):
        return None
    path = Path(entry.policies[seed]).absolute()
    return str(path.relative_to(Path.cwd()) if path.is_relative_to(Path.cwd()) else path)
