"""Who takes part in a benchmark: baselines with default and tuned gains, agents over training seeds, and bounds."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ftac_gym import baselines
from ftac_gym.agents.shipped import evaluations, seeds
from ftac_gym.baselines import tuned
from ftac_gym.baselines.custom import is_path, label
from ftac_gym.envs import SpacecraftFTCVectorEnv
from ftac_gym.evaluation.rollout import BaselineContestant, Contestant, resolve_policy
from ftac_gym.scenarios import SPLITS
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import require

ALL = "all"
"""Stands for every baseline that fits, with both sets of gains."""

TUNED = " tuned"
"""What follows the name of a baseline that flies with its tuned gains."""


@dataclass(frozen=True)
class Entry:
    """A contestant of a benchmark, or a bound.

    Attributes
    ----------
    name
        Name in tables; no two entries share one.
    policies
        What :func:`~ftac_gym.evaluation.rollout.rollout` takes, one per training seed; a single one for a baseline.
        They can be pickled; agents are paths.
    role
        ``"contestant"``, or ``"bound"`` if it knows the faults.
    tier
        What it knows: ``"attitude"``, ``"telemetry"`` or ``"oracle"``.
    kind
        ``"agent"`` or ``"baseline"``.
    gains
        ``"tuned"`` or ``"default"``, empty for agents.
    provenance
        Where it comes from: of tuned gains what is stored with them, of agents their cards, as ``"cards"``.
    curves
        Of agents: rows of the evaluations while training, for each seed for which they lie beside it.
    """

    name: str
    policies: tuple[Any, ...]
    role: str
    tier: str
    kind: str
    gains: str
    provenance: Mapping[str, Any]
    curves: tuple[tuple[Mapping[str, float], ...], ...] = ()


def entries_of(names: Sequence[baselines.BaselineLike], scenario: Scenario) -> tuple[Entry, ...]:
    """Return the entries of some names.

    Parameters
    ----------
    names
        ``"all"`` for every baseline that fits the scenario and gives a finite command, with default gains, and with
        tuned ones if some were found in the scenario's family; ``"NAME"`` for a baseline with its default gains,
        ``"NAME tuned"`` with tuned ones; a law of your own, as a class or ``"module:Class"``; or the path of an agent,
        or of a folder with one for each training seed (``seed_*``), each the folder of an agent or of its run.
    scenario
        The task, or one of the splits that share it.

    Raises
    ------
    ValueError
        If a name is unknown, a baseline does not fit or has no tuned gains of this family, an agent cannot be loaded,
        the seeds of one are of different designs, or two entries have one name.
    """
    entries: list[Entry] = []
    for name in names:
        if name == ALL:
            entries += _every_baseline(scenario)
        elif isinstance(name, type) or is_path(name):
            entries.append(_own(name, scenario))
        elif name.removesuffix(TUNED) in baselines.names():
            entries.append(_baseline(name, scenario))
        else:
            known = baselines.names() + [f"{item}{TUNED}" for item in _tuned_for(scenario)]
            rule = f"must be {ALL!r}, one of {known}, or the path of an agent or, as 'module:Class', of a law"
            require(Path(name).exists(), "policies", rule, name)
            entries.append(_agent(Path(name)))
    unique = list({entry.name: entry for entry in entries}.values())
    own = [item for item in entries if item.kind == "agent" or item.name.removesuffix(TUNED) not in baselines.names()]
    given = [entry.name for entry in own]
    rule = "must be laws of your own, and agents in folders of different names"
    require(len(given) == len(set(given)), "policies", rule, given)
    return tuple(unique)


def fitted(entry: Entry, scenarios: Sequence[Scenario]) -> tuple[Contestant, ...]:
    """Return the policies of an entry, ready to be attached, after all of them were tried on all scenarios.

    Raises
    ------
    ValueError
        If one does not fit; the message says whose and what to do.
    """
    contestants = []
    for policy in entry.policies:
        try:
            contestants.append(resolve_policy(policy))
            tried(contestants[-1], scenarios)
        except ValueError as error:
            # Laws of this package say who they are.
            named = str(error).startswith(entry.name)
            raise ValueError(str(error) if named else f"{entry.name}: {error}") from None
    return tuple(contestants)


def tried(contestant: Contestant, scenarios: Sequence[Scenario]) -> None:
    """Let a contestant act once in every scenario.

    Raises
    ------
    ValueError
        If it does not fit one of them; the message says what to do.
    """
    for scenario in scenarios:
        _command(contestant, scenario)


def _command(contestant: Contestant, scenario: Scenario) -> Any:
    """Return the first action of a contestant, on one craft."""
    # A copy: what is attached holds its environment, and would carry it along from then on.
    contestant = copy(contestant)
    env = SpacecraftFTCVectorEnv(num_envs=1, scenario=scenario, observation=contestant.tier)
    observation, _ = contestant.attach(env).reset(seed=0)
    return contestant.predict(observation, None, np.ones(1, dtype=np.bool_), True)[0]


def _family(scenario: Scenario) -> str:
    """Return the scenario on which gains for this one are tuned."""
    return SPLITS[0] if scenario.name in SPLITS else scenario.name


def _tuned_for(scenario: Scenario) -> list[str]:
    """Return the baselines that have tuned gains of the scenario's family."""
    return [name for name in tuned.names() if tuned.record(name)["provenance"]["scenario"] == _family(scenario)]


def _baseline(name: str, scenario: Scenario) -> Entry:
    law, gains = name.removesuffix(TUNED), "tuned" if name.endswith(TUNED) else "default"
    contestant = BaselineContestant(law, gains)
    provenance = tuned.record(law)["provenance"] if gains == "tuned" else {}
    found = provenance.get("scenario", _family(scenario))
    require(found == _family(scenario), f"gains of {name}", f"must be tuned on {_family(scenario)}", found)
    tier = baselines.make(law, scenario, gains=gains).information
    role = "bound" if tier == "oracle" else "contestant"
    return Entry(name, (contestant,), role, tier, "baseline", gains, provenance)


def _own(law: baselines.BaselineLike, scenario: Scenario) -> Entry:
    name = label(law)
    require(name not in baselines.names(), "policies", "must be a class whose name no baseline has", name)
    tier = baselines.make(law, scenario).information
    role = "bound" if tier == "oracle" else "contestant"
    return Entry(name, (BaselineContestant(law),), role, tier, "baseline", "default", {})


def _every_baseline(scenario: Scenario) -> list[Entry]:
    entries = []
    for law in baselines.names():
        for name in (f"{law}{TUNED}", law) if law in _tuned_for(scenario) else (law,):
            try:
                entry = _baseline(name, scenario)
                finite = np.isfinite(_command(entry.policies[0], scenario)).all()
            except ValueError:
                continue  # the law is for another craft or reference
            if finite:
                entries.append(entry)
    return entries


def _agent(path: Path) -> Entry:
    # PyTorch is imported only if an agent flies.
    from ftac_gym.agents.agent import CARD_FILE, Agent

    folders = seeds(path) or [path]
    homes = [folder / "agent" if (folder / "agent").is_dir() else folder for folder in folders]
    agents = [Agent.load(home) for home in homes]
    same = all(agent.interface == agents[0].interface for agent in agents)
    require(same, "agent", "must have seeds of one design: one interface in all cards", str(path))
    files = [home / CARD_FILE for home in homes]
    # A run keeps its evaluations beside the agent, an agent that was handed on in its own folder.
    curves = [tuple(evaluations(home.parent if home.name == "agent" else home)) for home in homes]
    tier = agents[0].information
    return Entry(
        name=path.resolve().parent.name if path.name == "agent" else path.stem if path.is_file() else path.name,
        policies=tuple(str(home.resolve()) for home in homes),
        role="bound" if tier == "oracle" else "contestant",
        tier=tier,
        kind="agent",
        gains="",
        provenance={"cards": [json.loads(file.read_text()) for file in files if file.is_file()]},
        curves=tuple(curve for curve in curves if curve),
    )
