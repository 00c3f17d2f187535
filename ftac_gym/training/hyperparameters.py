"""How to train on an environment: hyperparameters by algorithm and environment id, in RL Baselines3 Zoo's format."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml
from stable_baselines3.common.utils import LinearSchedule

from ftac_gym import baselines
from ftac_gym.agents.agent import WRAPPERS, Interface, base_of
from ftac_gym.baselines.gains import merged, nested
from ftac_gym.utils.parameters import require

ALGORITHMS = ("ppo", "recurrent_ppo", "sac", "tqc")
SCHEDULED = ("learning_rate", "clip_range")
"""Hyperparameters that may be ``lin_VALUE``: falling to zero over the run."""

Wrappers = tuple[tuple[str, dict[str, Any]], ...]
"""Name and arguments of each wrapper, the innermost first."""

_PREFIX = "ftac_gym.wrappers."


@dataclass(frozen=True)
class Recipe:
    """What a file of hyperparameters says of one environment.

    Parameters
    ----------
    interface
        From ``env_kwargs`` (the observation tier), ``env_wrapper`` (ActionHold among them is the hold).
    n_timesteps, n_envs
        Length of the run, in decisions of the agent over all craft; craft in parallel.
    env_kwargs
        Further arguments of the environment in training: scenario, reward.
    policy
        Policy by Stable-Baselines3's name.
    policy_kwargs
        Its arguments.
    normalize
        Whether observations and rewards are normalised.
    settings
        The algorithm's own hyperparameters.
    """

    interface: Interface
    n_timesteps: int
    n_envs: int
    env_kwargs: Mapping[str, Any] = field(default_factory=dict)
    policy: str = "MlpPolicy"
    policy_kwargs: Mapping[str, Any] = field(default_factory=dict)
    normalize: bool = True
    settings: Mapping[str, Any] = field(default_factory=dict)

    def arguments(self) -> dict[str, Any]:
        """Return the algorithm's arguments, schedules made."""
        made = dict(self.settings)
        for name in SCHEDULED:
            value = made.get(name)
            if isinstance(value, str):
                made[name] = LinearSchedule(float(value.removeprefix("lin_")), 0.0, 1.0)
        return made


def read_recipe(path: Path, environment_id: str, changes: Mapping[str, Any] | None = None) -> Recipe:
    """Read the recipe of an environment.

    Parameters
    ----------
    path
        YAML file.
    environment_id
        Key in it; ``default`` is taken if it is not there.
    changes
        Entries to change; a name with dots reaches into an entry (``policy_kwargs.log_std_init``).

    Raises
    ------
    ValueError
        If the file has neither the id nor a default, or an entry breaks a rule.
    """
    known = yaml.safe_load(path.read_text())
    rule = f"must be one of {sorted(known)}, which {path.name} has"
    require(environment_id in known or "default" in known, "env_id", rule, environment_id)
    entry: dict[str, Any] = merged(known.get(environment_id, known.get("default")), nested(changes or {}))
    for name in ("n_timesteps", "n_envs"):
        number = float(entry.get(name, 0))
        require(number >= 1.0 and number.is_integer(), name, "must be a positive integer", entry.get(name))
    wrappers, hold = parse_wrappers(entry.pop("env_wrapper", None) or [])
    settings = {name: value for name, value in entry.items() if name not in Recipe.__dataclass_fields__}
    env_kwargs = dict(entry.get("env_kwargs", {}))
    tier = env_kwargs.pop("observation", "attitude")
    for name in SCHEDULED:
        value = settings.get(name)
        numeric = not isinstance(value, str) or _is_number(value.removeprefix("lin_"))
        require(numeric, name, "must be a number or lin_NUMBER", value)
    return Recipe(
        interface=Interface(tier, wrappers, hold),
        n_timesteps=int(float(entry["n_timesteps"])),
        n_envs=int(entry["n_envs"]),
        env_kwargs=env_kwargs,
        policy=entry.get("policy", "MlpPolicy"),
        policy_kwargs=entry.get("policy_kwargs", {}),
        normalize=bool(entry.get("normalize", False)),
        settings=settings,
    )


def parse_wrappers(items: Sequence[Any] | Mapping[str, Any] | str) -> tuple[Wrappers, int]:
    """Return wrappers and hold that an ``env_wrapper`` entry says.

    Raises
    ------
    ValueError
        If a wrapper is none that an agent can carry along.
    """
    listed = list(items) if isinstance(items, Sequence) and not isinstance(items, str) else [items]
    wrappers, hold = [], 1
    for item in listed:
        name, arguments = next(iter(item.items())) if isinstance(item, Mapping) else (item, {})
        name = str(name).removeprefix(_PREFIX)
        if name == "ActionHold":
            hold *= arguments["steps"]
            continue
        rule = f"must be among {[*WRAPPERS, 'ActionHold']} of ftac_gym.wrappers"
        require(name in WRAPPERS, "env_wrapper", rule, name)
        wrappers.append((name, dict(arguments)))
    return tuple(wrappers), hold


def written_out(interface: Interface) -> Interface:
    """Return an interface with all gains of its base: an agent must not change when the defaults of its base do."""
    wrappers = []
    for name, arguments in interface.wrappers:
        if (base := base_of(name, arguments)) is not None:
            own = {"base", "authority", "fade_angle", "fade_floor", "surprise", "ranges", "gains"}
            changes = {key: value for key, value in arguments.items() if key not in own}
            gains = merged(baselines.defaults(base), baselines.chosen(base, arguments.get("gains", "default"), changes))
            kept = {key: value for key, value in arguments.items() if key in own - {"gains"}}
            arguments = {"base": base, **kept, **gains}
        wrappers.append((name, arguments))
    return Interface(interface.observation, tuple(wrappers), interface.hold, interface.critic_sees_faults)


def parse_words(words: Sequence[str]) -> Wrappers:
    """Return the wrappers that words of a command line say: a name, then arguments as NAME=VALUE, in YAML.

    Raises
    ------
    ValueError
        If an argument has no value.
    """
    wrappers = []
    for word in words:
        # Words that do not name an argument belong to the value before them: "ranges={rate_limit: [0.1, 0.2]}".
        name, *rest = word.split()
        arguments: list[str] = []
        for part in rest:
            if arguments and not re.match(r"\w+=", part):
                arguments[-1] += f" {part}"
            else:
                arguments.append(part)
        wrappers.append((name, parse_values(arguments, "wrappers")))
    return tuple(wrappers)


def parse_values(words: Sequence[str], field_name: str) -> dict[str, Any]:
    """Return NAME=VALUE words as a dict, values in YAML.

    Raises
    ------
    ValueError
        If a word has no value.
    """
    values = {}
    for word in words:
        name, sign, value = word.partition("=")
        require(bool(sign and name), field_name, "must be words NAME=VALUE", word)
        values[name] = yaml.safe_load(value)
        if isinstance(values[name], str) and _is_number(value):
            values[name] = float(value)  # YAML 1.1 takes 1e-4 for text
    return values


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
