"""Episodes with the worst results of an agent, or of the reference, and commands that fly them again."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ftac_gym.evaluation.entries import Entry
from ftac_gym.plots import fault_description
from ftac_gym.report.provenance import policy_name
from ftac_gym.report.results import Results, values
from ftac_gym.scenarios import frozen, is_shipped
from ftac_gym.task.episodes import Episodes
from ftac_gym.utils.randomness import keys_from_seeds

COUNT = 5
"""Episodes of each split."""

SHOWN = ("availability", "success", "settling_time", "ape_95", "integrated_error")
"""Metrics that are listed."""

_LOSSES = ("integrated_error", "settling_time")
"""Metrics that order the episodes, the last one first."""


@dataclass(frozen=True, eq=False)
class Worst:
    """An episode in which an entry has a bad result.

    Attributes
    ----------
    index
        Number of the episode in its split.
    entry
        Name of the entry.
    seed
        Its training seed with the worst result, counted from zero.
    faults
        Description of the faults.
    metrics, reference
        Metrics of that seed and of the reference.
    command
        Command that flies both again; empty where a policy has no name or file.
    """

    index: int
    entry: str
    seed: int
    faults: str
    metrics: Mapping[str, float]
    reference: Mapping[str, float]
    command: str


def worst_episodes(results: Results) -> dict[str, list[Worst]]:
    """Return the worst feasible episodes by split: those of the best agent of each tier, else of the reference.

    An agent is judged by the difference of its settling time to the reference's, mean over its seeds. Ties are resolved
    by the difference of the integrated error. The reference is judged by its own metrics.
    """
    agents: dict[str, Entry] = {}
    for entry in results.entries():
        if entry.kind == "agent" and entry.role != "oracle":
            agents.setdefault(entry.tier, entry)
    judged = list(agents.values()) or [_reference(results)]
    return {split: [item for entry in judged for item in _worst(results, split, entry)] for split in results.profiles}


def _reference(results: Results) -> Entry:
    return next(entry for entry in results.entries() if entry.name == results.benchmark.reference)


def _worst(results: Results, split: str, entry: Entry) -> list[Worst]:
    reference, episodes = _reference(results), results.benchmark.episodes[split]
    found, base = (
        {metric: values(results.benchmark, split, name, metric) for metric in SHOWN}
        for name in (entry.name, reference.name)
    )
    losses = [found[metric].mean(axis=0) for metric in _LOSSES]
    if entry.name != reference.name:
        losses = [loss - base[metric].mean(axis=0) for loss, metric in zip(losses, _LOSSES, strict=True)]
    candidates = np.flatnonzero(episodes.feasible)
    order = candidates[np.lexsort([loss[candidates] for loss in losses])[::-1]]
    worst = []
    for index in order[:COUNT].tolist():
        seed = int(np.lexsort([found[metric][:, index] for metric in _LOSSES])[-1])
        worst.append(
            Worst(
                index,
                entry.name,
                seed,
                fault_description(episodes, index),
                {metric: float(item[seed, index]) for metric, item in found.items()},
                {metric: float(item[:, index].mean()) for metric, item in base.items()},
                replay_command(split, episodes, index, [policy_name(entry, seed), policy_name(reference, 0)]),
            )
        )
    return worst


def replay_command(split: str, episodes: Episodes, index: int, names: Sequence[str | None]) -> str:
    """Return the command that flies a feasible episode again and draws it.

    Parameters
    ----------
    split
        Scenario of the episodes.
    episodes
        Its episodes.
    index
        Index of the episode.
    names
        Names of policies (:func:`~ftac_gym.report.provenance.policy_name`), the reference last.

    Returns
    -------
    The command, or nothing if a policy has no name, or the scenario is a user's own and lies in a file.
    """
    known = [name for name in names if name is not None]
    if len(known) < len(names) or not is_shipped(split):
        return ""
    # The list ends with this episode: no other one need be flown.
    count = int(episodes.feasible[: index + 1].sum())
    words = ["ftac-evaluate", "--policies", *dict.fromkeys(known), "--reference", known[-1]]
    if (episodes.key[index] == keys_from_seeds([frozen.seed_of(split, "validation")])).all():
        words += ["--episodes-of", "validation"]
    return shlex.join([*words, "--scenario", split, "--splits", "--episodes", str(count), "--detail", str(index)])
