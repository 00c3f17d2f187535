"""Hyperparameters by algorithm and environment id, in the format of RL Baselines3 Zoo."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml
from stable_baselines3.common.utils import LinearSchedule

from ftac_gym import baselines
from ftac_gym.agents.interface import Interface, Wrappers, base_of, wrappers_from_yaml
from ftac_gym.baselines.gains import merged, nested
from ftac_gym.utils.files import reading
from ftac_gym.utils.parameters import require
from ftac_gym.utils.serialization import reads_as_number
from ftac_gym.wrappers.fault_estimate import source_gains

CONFIGS = Path(__file__).parent / "configs"
"""Folder of the files of hyperparameters, one for each algorithm."""
ALGORITHMS = ("ppo", "recurrent_ppo", "sac", "tqc")
SCHEDULED = ("learning_rate", "clip_range")
"""Hyperparameters that may be ``lin_VALUE``: falling to zero over the run."""


@dataclass(frozen=True)
class Hyperparameters:
    """Hyperparameters of one environment.

    Parameters
    ----------
    interface
        From ``env_kwargs`` (the observation tier) and ``env_wrapper`` (ActionHold in it is the hold).
    n_timesteps, n_envs
        Length of the run, in decisions of the agent over all spacecraft; spacecraft in parallel.
    env_kwargs
        Further arguments of the environment in training: scenario, reward.
    policy
        Stable-Baselines3's name of the policy.
    policy_kwargs
        Its arguments.
    normalize
        Whether observations and rewards are normalised.
    settings
        Hyperparameters of the algorithm itself.
    """

    interface: Interface
    n_timesteps: int
    n_envs: int
    env_kwargs: Mapping[str, Any] = field(default_factory=dict)
    policy: str = "MlpPolicy"
    policy_kwargs: Mapping[str, Any] = field(default_factory=dict)
    normalize: bool = False
    settings: Mapping[str, Any] = field(default_factory=dict)

    def arguments(self) -> dict[str, Any]:
        """Return the arguments of the algorithm, with schedules as functions."""
        scheduled = {
            name: LinearSchedule(float(value.removeprefix("lin_")), 0.0, 1.0)
            for name, value in self.settings.items()
            if name in SCHEDULED and isinstance(value, str)
        }
        return {**self.settings, **scheduled}


def read_hyperparameters(path: Path, environment_id: str, changes: Mapping[str, Any] | None = None) -> Hyperparameters:
    """Read the hyperparameters of an environment.

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
        If the file is damaged, has neither the id nor a default, or an entry breaks a rule.
    """
    with reading(path, "correct it", yaml.YAMLError):
        known = yaml.safe_load(path.read_text(encoding="utf-8"))
        entries = isinstance(known, dict) and all(isinstance(entry, dict) for entry in known.values())
        require(entries, "file", "must have a table of entries for each environment id", known)
    rule = f"must be one of {sorted(known)}, which {path.name} has"
    require(environment_id in known or "default" in known, "env_id", rule, environment_id)
    settings = merged(known.get(environment_id, known.get("default")), nested(changes or {}))
    env_kwargs = dict(settings.pop("env_kwargs", {}))
    wrappers, hold = wrappers_from_yaml(settings.pop("env_wrapper", None) or [])
    fields = {name: settings.pop(name) for name in Hyperparameters.__dataclass_fields__ if name in settings}
    for name in ("n_timesteps", "n_envs"):
        number = float(fields.get(name, 0))
        require(number >= 1.0 and number.is_integer(), name, "must be a positive integer", fields.get(name))
        fields[name] = int(number)
    for name in SCHEDULED:
        value = settings.get(name)
        numeric = not isinstance(value, str) or reads_as_number(value.removeprefix("lin_"))
        require(numeric, name, "must be a number or lin_NUMBER", value)
    fields["normalize"] = bool(fields.get("normalize"))
    interface = Interface(env_kwargs.pop("observation", "attitude"), wrappers, hold)
    return Hyperparameters(interface, env_kwargs=env_kwargs, settings=settings, **fields)


def with_base_gains(interface: Interface) -> Interface:
    """Return an interface with all gains of its base and of its observer.

    An agent must not change when their defaults do.
    """
    wrappers = []
    for name, arguments in interface.wrappers:
        if (base := base_of(name, arguments)) is not None:
            known = baselines.defaults(base)
            changes = {key: value for key, value in arguments.items() if key in known}
            others = {key: value for key, value in arguments.items() if key not in ("gains", *known)}
            gains = merged(known, baselines.chosen(base, arguments.get("gains", "default"), changes))
            arguments = {"base": base, **others, **gains}
        elif name == "FaultEstimateObservation":
            arguments = {**source_gains(arguments.get("source")), **arguments}
        wrappers.append((name, arguments))
    return Interface(interface.observation, tuple(wrappers), interface.hold, interface.critic_sees_faults)


def wrappers_from_text(texts: Sequence[str]) -> Wrappers:
    """Return the wrappers of a command line, each a name and arguments as NAME=VALUE, with values in YAML.

    Raises
    ------
    ValueError
        If an argument has no value.
    """
    wrappers = []
    for text in texts:
        name, *arguments = text.split(maxsplit=1)
        # Spaces may be part of a value: "ranges={rate_limit: [0.1, 0.2]}".
        assignments = re.split(r"\s+(?=\w+=)", arguments[0]) if arguments else []
        wrappers.append((name, parse_assignments(assignments, "wrappers")))
    return tuple(wrappers)


def parse_assignments(texts: Sequence[str], field_name: str) -> dict[str, Any]:
    """Return texts NAME=VALUE as a dict, with values in YAML.

    Raises
    ------
    ValueError
        If a text has no value.
    """
    values = {}
    for text in texts:
        name, sign, value = text.partition("=")
        require(bool(sign and name), field_name, "must be words NAME=VALUE", text)
        values[name] = yaml.safe_load(value)
        if isinstance(values[name], str) and reads_as_number(value):
            values[name] = float(value)  # YAML 1.1 reads 1e-4 as text
    return values
