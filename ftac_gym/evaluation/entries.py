"""Entries of a benchmark: baselines with default and tuned gains, agents over their seeds, and any other policies."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ftac_gym import baselines
from ftac_gym.agents.agent import Agent
from ftac_gym.agents.shipped import agent_folders, training_curve
from ftac_gym.agents.storage import read_card
from ftac_gym.baselines import tuned
from ftac_gym.policies import TUNED, DeferredBaseline, Policy, PolicyRunner, check_task, policy_label, resolve
from ftac_gym.policies.policy import named_gains
from ftac_gym.policies.resolve import agent_path, is_unshipped
from ftac_gym.scenarios import SPLITS
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import fields_named, require

ALL = "all"
"""Name of all baselines that fit, with both sets of gains."""


@dataclass(frozen=True)
class Entry:
    """A policy with a name in a table, a competitor or an oracle.

    Attributes
    ----------
    name
        Name in tables; no two entries share one.
    policies
        Policies as :func:`~ftac_gym.policies.resolve` takes them, one per training seed; a single one for a baseline.
        They can be pickled. What was named by text remains text, so that every process loads it itself.
    tier
        Information tier: ``"attitude"``, ``"telemetry"`` or ``"oracle"``.
    kind
        ``"baseline"``, or ``"agent"`` for agents and all policies from outside of the package.
    gains
        ``"tuned"`` or ``"default"``, empty for agents.
    provenance
        Origin: of tuned gains what is stored with them, of agents their cards, as ``"cards"``, and of other policies
        their name, as ``"source"``.
    curves
        Of agents: rows of the evaluations while training, for each seed for which they are stored.
    """

    name: str
    policies: tuple[Any, ...]
    tier: str
    kind: str
    gains: str
    provenance: Mapping[str, Any]
    curves: tuple[tuple[Mapping[str, float], ...], ...] = ()

    @property
    def role(self) -> str:
        """``"policy"``, or ``"oracle"`` if the truth about the faults is an input: a reference, no competitor."""
        return "oracle" if self.tier == "oracle" else "policy"


def entries_of(names: Sequence[Any] | Mapping[str, Any], scenario: Scenario) -> tuple[Entry, ...]:
    """Return the entries of some names.

    Parameters
    ----------
    names
        Policies as :func:`~ftac_gym.policies.resolve` takes them, by name or as objects; a mapping gives them the names
        in the tables. An agent with a folder for each training seed (``seed_K``) is one entry with all of them.
        ``"all"`` stands for every baseline that fits the scenario and gives a finite command: with default gains, and
        with tuned ones of the scenario's family.
    scenario
        The task, or one of the splits that share it.

    Raises
    ------
    ValueError
        If a name is unknown, or two entries have one name; if a baseline does not fit or has no tuned gains of this
        family; if an agent cannot be loaded, or its seeds are of different designs.
    MissingExtra
        If the library of a model is not installed.
    """
    entries: list[Entry] = []
    for name, item in names.items() if isinstance(names, Mapping) else ((None, item) for item in names):
        if isinstance(item, str) and item == ALL:
            entries += _every_baseline(scenario)
            continue
        entry = _entry(item, scenario)
        entries.append(entry if name is None else replace(entry, name=name))
    unique = list({entry.name: entry for entry in entries}.values())
    # The same baseline named twice is one entry; other policies of one name differ.
    known = baselines.names()
    given = [entry.name for entry in entries if entry.kind == "agent" or named_gains(entry.name)[0] not in known]
    rule = "must be custom classes and other policies of different names, and agents in folders of different names"
    require(len(given) == len(set(given)), "policies", rule, given)
    return tuple(unique)


def _entry(item: Any, scenario: Scenario) -> Entry:
    if isinstance(item, (str, Path)) and not is_unshipped(item):
        with fields_named(policy=f"policies (beside {ALL!r})"):
            path = agent_path(item, scenario.name)
        return _baseline(item, scenario) if path is None else _agent(path)
    policy = resolve(item, scenario.name)
    if isinstance(policy, DeferredBaseline):
        return _baseline(item, scenario)
    command = getattr(policy, "command", "")
    curve = tuple(getattr(policy, "curve", ()))
    return Entry(
        name=policy_label(item),
        policies=(item if isinstance(item, str) else policy,),
        tier=getattr(policy, "information", policy.tier),
        kind="agent",
        gains="",
        provenance={"source": policy_label(item), **({"command": command} if command else {})},
        curves=(curve,) if curve else (),
    )


def fitted(entry: Entry, scenarios: Sequence[Scenario]) -> tuple[Policy, ...]:
    """Return the policies of an entry, after all of them have acted in every scenario.

    Raises
    ------
    ValueError
        If one does not fit; the message names the entry and the remedy.
    """
    policies = []
    for item in entry.policies:
        try:
            policies.append(resolve(item))
            check_fit(policies[-1], scenarios)
        except ValueError as error:
            # Messages of this package's baselines start with their name.
            named = str(error).startswith(entry.name)
            raise ValueError(str(error) if named else f"{entry.name}: {error}") from None
    return tuple(policies)


def check_fit(policy: Policy, scenarios: Sequence[Scenario]) -> None:
    """Let a policy act for a control period in every scenario.

    Raises
    ------
    ValueError
        If it does not fit one of them, or raises any error; the message names the remedy.

    Warns
    -----
    SampledInstability
        If a control period is too long for the gains of a baseline.
    """
    for scenario in scenarios:
        check_task(policy, scenario)
        try:
            runner = PolicyRunner(scenario, policy)
            runner.reset(scenario.draw(0, 1))
            runner.step()
        except ValueError:
            raise
        except Exception as error:
            raise ValueError(f"{type(error).__name__}: {error}") from error
        if isinstance(policy, DeferredBaseline):
            policy.check_period(scenario)


def _family(scenario: Scenario) -> str:
    """Return the scenario on which gains for this one are tuned."""
    return SPLITS[0] if scenario.name in SPLITS else scenario.name


def _baseline(name: Any, scenario: Scenario) -> Entry:
    policy = resolve(name)
    assert isinstance(policy, DeferredBaseline)
    custom = policy.name not in baselines.names()
    shown = policy_label(policy)
    free = not custom or shown not in baselines.names()
    require(free, "policies", "must be a class whose name no baseline has", shown)
    provenance = tuned.record(str(policy.name), policy.gains)["provenance"] if policy.gains != "default" else {}
    # Of a file, the user says that its gains are for this task.
    found = _family(scenario) if tuned.is_file(policy.gains) else provenance.get("scenario", _family(scenario))
    require(found == _family(scenario), f"gains of {shown}", f"must be tuned on {_family(scenario)}", found)
    tier = baselines.build(policy.name, scenario, gains=policy.gains).information
    return Entry(shown, (policy,), tier, "baseline", "tuned" if provenance else policy.gains, provenance)


def _every_baseline(scenario: Scenario) -> list[Entry]:
    entries = []
    in_family = [name for name in tuned.names() if tuned.record(name)["provenance"]["scenario"] == _family(scenario)]
    for baseline in baselines.names():
        for name in (f"{baseline}{TUNED}", baseline) if baseline in in_family else (baseline,):
            try:
                entry = _baseline(name, scenario)
                check_fit(entry.policies[0], [scenario])
            except ValueError:
                continue  # the baseline is for another spacecraft or reference, or gives no finite command
            entries.append(entry)
    return entries


def _agent(path: Path) -> Entry:
    folders = agent_folders(path)
    agents = [Agent.load(folder) for folder in folders]
    same = all(agent.interface == agents[0].interface for agent in agents)
    require(same, "agent", "must have seeds of one design: one interface in all cards", str(path))
    curves = [tuple(training_curve(folder)) for folder in folders]
    return Entry(
        name=path.resolve().parent.name if path.name == "agent" else path.name,
        policies=tuple(str(folder.resolve()) for folder in folders),
        tier=agents[0].information,
        kind="agent",
        gains="",
        provenance={"cards": [read_card(folder) for folder in folders]},
        curves=tuple(curve for curve in curves if curve),
    )
