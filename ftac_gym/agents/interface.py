"""Observation and meaning of the action of an agent's network."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ftac_gym import baselines, wrappers
from ftac_gym.agents.arguments import check_arguments
from ftac_gym.baselines import observers
from ftac_gym.envs.observation import TIERS
from ftac_gym.utils.parameters import require, whole

WRAPPERS = ("FaultEstimateObservation", "GainScheduling", "ObservationHistory", "ResidualPolicy")
"""Wrappers of which an interface can consist."""

ON_BASE = ("GainScheduling", "ResidualPolicy")
"""Wrappers through which an agent acts on a base, whose own action is an action of zero."""


Wrappers = tuple[tuple[str, dict[str, Any]], ...]
"""Name and arguments of each wrapper, the innermost first."""

_PREFIX = "ftac_gym.wrappers."


@dataclass(frozen=True)
class Interface:
    """Observation and meaning of the action of a policy network.

    Parameters
    ----------
    observation
        Information tier.
    wrappers
        Name in :mod:`ftac_gym.wrappers` and arguments of each wrapper, the innermost first. A base that is a class is
        stored as ``"module:Class"``, so that a card can hold the interface.
    hold
        Control periods for which every action is held.
    critic_sees_faults
        Whether the truth about the faults is at the end of the observation, for the critic alone. The actor of such a
        model has no path from it (:mod:`ftac_gym.training.networks`), and it is zero when the agent flies.

    Raises
    ------
    ValueError
        If a wrapper or one of its arguments is unknown, a value is refused, or a base cannot be imported.
    """

    observation: str = "attitude"
    wrappers: Wrappers = ()
    hold: int = 1
    critic_sees_faults: bool = False

    def __post_init__(self) -> None:
        """Check the wrappers, which are lists if they come from a file."""
        written = wrapper_pairs(self.wrappers)
        object.__setattr__(self, "wrappers", written)
        for name, arguments in written:
            require(name in WRAPPERS, "wrappers", f"must be among {list(WRAPPERS)}", name)
            if "base" in arguments:
                arguments["base"] = baselines.path_of(arguments["base"])
            check_arguments(name, arguments, base_of(name, arguments))
        known = self.observation in TIERS
        require(known, "observation", f"must be one of {list(TIERS)}", self.observation)
        whole = isinstance(self.hold, int) and not isinstance(self.hold, bool)
        require(whole and self.hold > 0, "hold", "must be a positive integer", self.hold)
        told = isinstance(self.critic_sees_faults, bool)
        require(told, "critic_sees_faults", "must be true or false", self.critic_sees_faults)

    @property
    def information(self) -> str:
        """Information tier of the actor's inputs: that of the observation, or of a wrapper or base with more."""
        tiers = {self.observation}
        for name, given in self.wrappers:
            base, arguments = base_of(name, given), given
            if base is not None:
                tiers.add(baselines.baseline_class(base).information)
                arguments = {**baselines.defaults(base), **given}
            source = arguments.get("source", arguments.get("faults"))
            if source == "truth":
                tiers.add("oracle")
            elif source in observers.names():
                tiers.add(observers.information(source))
            if arguments.get("telemetry"):
                tiers.add("telemetry")
        return max(tiers, key=TIERS.index)

    @property
    def bases(self) -> tuple[str, ...]:
        """Baselines through which the agent acts."""
        found = (base_of(name, given) for name, given in self.wrappers)
        return tuple(base for base in found if base is not None)

    @property
    def tuned_bases(self) -> tuple[tuple[str, str], ...]:
        """Those of them whose gains are read from files of tuned gains, with the set of gains or the file."""
        sets = ((base_of(name, given), given.get("gains", "default")) for name, given in self.wrappers)
        return tuple((base, gains) for base, gains in sets if base is not None and gains != "default")

    def wrap(self, env: Any) -> Any:
        """Return an environment, single or vector, with the wrappers."""
        for name, arguments in self.wrappers:
            env = getattr(wrappers, name)(env, **arguments)
        return env

    def wrap_for_training(self, env: Any) -> Any:
        """Return an environment with the wrappers, and with the truth for a critic that sees the faults."""
        env = self.wrap(env)
        return wrappers.FaultEstimateObservation(env, "truth") if self.critic_sees_faults else env


def wrapper_pairs(items: object) -> Wrappers:
    """Return wrappers as pairs of a name and arguments, in new dictionaries; raises ValueError for other data."""
    rule = "must be a list of pairs of a name and a table of arguments"
    require(isinstance(items, (list, tuple)), "wrappers", rule, items)
    assert isinstance(items, (list, tuple))
    for item in items:
        pair = isinstance(item, (list, tuple)) and len(item) == 2
        require(pair and isinstance(item[0], str) and isinstance(item[1], Mapping), "wrappers", rule, items)
    return tuple((name, dict(arguments)) for name, arguments in items)


def base_of(wrapper: str, arguments: Mapping[str, Any]) -> str | None:
    """Return the base on which an agent acts through a wrapper with these arguments; None if it has none."""
    return arguments.get("base", "pd_dob") if wrapper in ON_BASE else None


def wrappers_from_yaml(items: Sequence[Any] | Mapping[str, Any] | str) -> tuple[Wrappers, int]:
    """Return the wrappers and the hold of an ``env_wrapper`` entry, as RL Baselines3 Zoo has it.

    Raises
    ------
    ValueError
        If a wrapper cannot be part of an agent's interface, or is outside of an action hold.
    """
    wrappers, hold = [], 1
    form = "must be a name, or a list of names and of tables NAME: {ARGUMENT: VALUE}"
    entries = [items] if isinstance(items, str | Mapping) else items
    require(isinstance(entries, (list, tuple)), "env_wrapper", form, items)
    for item in entries:
        table = item if isinstance(item, Mapping) else {item: {}} if isinstance(item, str) else {}
        valid = len(table) == 1 and all(isinstance(value, Mapping) for value in table.values())
        require(valid, "env_wrapper", form, item)
        name, arguments = next(iter(table.items()))
        name = str(name).removeprefix(_PREFIX)
        if name == "ActionHold":
            hold *= whole(arguments.get("steps"), 1, "env_wrapper: steps of ActionHold")
            continue
        rule = f"must be among {[*WRAPPERS, 'ActionHold']} of ftac_gym.wrappers"
        require(name in WRAPPERS, "env_wrapper", rule, name)
        require(hold == 1, "env_wrapper", "must have ActionHold last: it is outside of all other wrappers", name)
        wrappers.append((name, dict(arguments)))
    return tuple(wrappers), hold
