"""Origins of entries: names on the command line, gains, cards, and costs of tuning or training."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ftac_gym import baselines
from ftac_gym.evaluation.entries import Entry
from ftac_gym.policies import DeferredBaseline, policy_label
from ftac_gym.policies.resolve import is_unshipped
from ftac_gym.report.cells import UNKNOWN, Cell


def baseline_name(entry: Entry) -> str | None:
    """Return the name of a baseline of this package; None for anything else."""
    policy = entry.policies[0]
    return str(policy.name) if isinstance(policy, DeferredBaseline) and policy.name in baselines.names() else None


def policy_name(entry: Entry, seed: int) -> str | None:
    """Return the name or path that ``ftac-evaluate --policies`` takes for a policy; None if it has none."""
    name = baseline_name(entry)
    if name is not None:
        return policy_label(entry.policies[0])
    if not isinstance(entry.policies[seed], (str, Path)):
        return None
    if is_unshipped(entry.policies[seed]):
        return str(entry.policies[seed])
    path = Path(entry.policies[seed]).absolute()
    return str(path.relative_to(Path.cwd()) if path.is_relative_to(Path.cwd()) else path)


def card(entry: Entry) -> str:
    """Return tier, role, gains and provenance of an entry, as JSON."""
    parts: dict[str, Any] = {"tier": entry.tier, "role": entry.role}
    if entry.kind == "agent":
        parts |= entry.provenance
    else:
        parts |= {"gains": gains_of(entry), "provenance": dict(entry.provenance)}
    return json.dumps(parts, indent=2, default=str, ensure_ascii=False)


def gains_of(entry: Entry) -> dict[str, Any]:
    """Return all gains of a baseline of this package, defaults among them; none of other entries."""
    name = baseline_name(entry)
    # The fingerprint of a baseline holds its name and the gains that differ from the defaults.
    return {} if name is None else {**baselines.defaults(name), **json.loads(entry.policies[0].fingerprint)[1]}


def command(entry: Entry) -> str:
    """Return the command that trained the first seed of an agent or tuned a baseline; empty if it is unknown."""
    return str(next((item.get("command", "") for item in _sources(entry)), ""))


def effort(entry: Entry) -> Cell:
    """Return the steps of training or the episodes of tuning."""
    sources = _sources(entry)
    if entry.kind == "agent":
        steps = _sum(sources, "run_steps", "steps")
        if steps == steps:
            seeds = "1 seed" if len(entry.policies) == 1 else f"{len(entry.policies)} seeds"
            return Cell(f"{steps / 1e6:.3g} million steps", f"{seeds} in all", steps)
    elif sources and "trials" in sources[0]:
        trials, episodes = int(sources[0]["trials"]), int(sources[0].get("episodes", 1))
        return Cell(
            f"{trials} trials \N{MULTIPLICATION SIGN} {episodes} episodes",
            f"{trials * episodes} flown",
            trials * episodes,
        )
    return UNKNOWN


def training_minutes(entry: Entry) -> float:
    """Return the training time of all seeds of an agent [min]; NaN if it is unknown."""
    return _sum(_sources(entry), "run_seconds", "training_seconds") / 60.0 if entry.kind == "agent" else float("nan")


def _sources(entry: Entry) -> list[Mapping[str, Any]]:
    """Return the cards of an agent, one per seed as far as they are known, or the provenance of tuned gains."""
    found = entry.provenance.get("cards", [entry.provenance] if entry.provenance else [])
    return list(found.values() if isinstance(found, Mapping) else found)


def _sum(cards: list[Mapping[str, Any]], run: str, agent: str) -> float:
    """Return the sum over cards of a field of the run, else of the agent: one saved early cost the whole run."""
    found = [float(item.get(run, item.get(agent, float("nan")))) for item in cards]
    return sum(found) if found else float("nan")
