"""Agents in the folders of RL Baselines3 Zoo: its model, normaliser, wrappers and arguments of the environment."""

from __future__ import annotations

import zipfile
from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np

from ftac_gym.agents.agent import Agent
from ftac_gym.agents.interface import Interface, wrappers_from_yaml
from ftac_gym.agents.pickles import load_model, load_normalizer
from ftac_gym.envs import SpacecraftFTCEnv
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.extras import require_extra
from ftac_gym.utils.files import reading, reason_of
from ftac_gym.utils.parameters import flag, require

MODELS = ("last", "best")
"""Models in a folder: that of the end of the training, and the best in the Zoo's own evaluations."""

_UNSUPPORTED = ("frame_stack", "vec_env_wrapper")
"""Hyperparameters that change what the agent observes, in a way that this package does not repeat."""

_OF_DISPLAY = ("render_mode", "width", "height")
"""Arguments of the environment that change neither task nor observation."""


@dataclass(frozen=True, eq=False)
class ZooAgent(Agent):
    """An agent of RL Baselines3 Zoo.

    Attributes
    ----------
    scenario
        The task of its training.
    on_task_only
        Whether it flies on this task alone: ``env_kwargs`` of the training had changed it.
    curve
        Evaluations during the training: rows with ``steps`` and ``mean_return``; none without ``evaluations.npz``.
    command
        Command of the training; empty if it is not stored.
    """

    scenario: Scenario | None = None
    on_task_only: bool = False
    curve: tuple[Mapping[str, float], ...] = ()
    command: str = ""

    def check_task(self, scenario: Scenario) -> None:
        """Refuse another task than that of a training with changed ``env_kwargs``.

        Raises
        ------
        ValueError
            If the scenario differs; the message names the fields.
        """
        if self.on_task_only and self.scenario is not None:
            differing = _differences(scenario, self.scenario)
            rule = "must be that of the agent's env_kwargs (ZooAgent.scenario; transfer=true flies it elsewhere)"
            require(not differing, "scenario", f"{rule}: it differs in {', '.join(differing)}", scenario.name)


def load_zoo(folder: str | Path, model: str = "last", transfer: bool = False) -> ZooAgent:
    """Load an agent from a folder that RL Baselines3 Zoo wrote, ``logs/ppo/SpacecraftFTC-v0_1`` for example.

    Observation tier, wrappers, hold (``ActionHold`` among the wrappers) and normaliser are those of the training. If
    its ``env_kwargs`` change the task, the agent flies on that task alone.

    .. warning::
        The model and the normaliser are pickles: loading them runs code of their author. Load only folders that you
        trust.

    Parameters
    ----------
    folder
        The folder of the training.
    model
        ``"last"`` as ``rl_zoo3.enjoy`` does, or ``"best"`` for ``best_model.zip``. The normaliser is the last one for
        both.
    transfer
        Whether the agent flies on any task that its spaces fit.

    Raises
    ------
    ValueError
        If a file is missing or damaged, or the environment is none of this package. If the training had a wrapper or
        a hyperparameter that is not repeated here, such as ``frame_stack``: the message names it.
    MissingExtra
        If a library of the model is not installed; the message has the command that installs it.
    """
    require(model in MODELS, "model", f"must be one of {list(MODELS)}", model)
    folder = Path(folder)
    found = sorted(folder.glob("*/args.yml"))
    require(len(found) == 1, "zoo", "must be a folder of rl_zoo3.train, with ENV_ID/args.yml", str(folder))
    settings = found[0].parent
    arguments, hyperparameters = (_read_yaml(settings / name) for name in ("args.yml", "config.yml"))
    for name in _UNSUPPORTED:
        require(hyperparameters.get(name) is None, f"zoo: {name}", "must be absent", hyperparameters.get(name))
    given = arguments.get("env_kwargs") or hyperparameters.get("env_kwargs") or {}
    require(isinstance(given, Mapping), "zoo: env_kwargs", "must be a table", given)
    changes = {name: value for name, value in given.items() if name not in _OF_DISPLAY}
    tier = changes.pop("observation", "attitude")
    wrappers, hold = wrappers_from_yaml(hyperparameters.get("env_wrapper") or [])
    command = settings / "command.txt"
    file = folder / ("best_model.zip" if model == "best" else f"{settings.name}.zip")
    require(file.is_file(), f"{model} model", "must be in the folder: the training was interrupted", str(file))
    statistics = settings / "vecnormalize.pkl"
    normalized = bool(hyperparameters.get("normalize"))
    complete = statistics.is_file() or not normalized
    require(complete, "zoo", "must have vecnormalize.pkl: its training normalised", str(folder))
    return ZooAgent(
        load_model(file).policy,
        load_normalizer(statistics) if statistics.is_file() else None,
        Interface(tier, wrappers, hold),
        scenario=_task(str(arguments.get("env")), changes),
        on_task_only=bool(changes) and not flag(transfer, "transfer"),
        curve=_curve(folder / "evaluations.npz"),
        command=command.read_text(encoding="utf-8", errors="replace").strip() if command.is_file() else "",
    )


def _task(env_id: str, changes: Mapping[str, Any]) -> Scenario:
    """Return the scenario of an environment id with changes."""
    try:
        env = gym.make(env_id, **changes).unwrapped
    except (gym.error.Error, ImportError, TypeError) as error:
        raise ValueError(f"zoo: {env_id}: {reason_of(error)}") from error
    require(isinstance(env, SpacecraftFTCEnv), "env", "must be of this package", env_id)
    assert isinstance(env, SpacecraftFTCEnv)
    return env.scenario


def _differences(one: Scenario, other: Scenario) -> list[str]:
    """Return the fields in which scenarios differ; policies are judged without an end by tumbling."""
    compared = [item.name for item in fields(Scenario) if item.name not in ("name", "tumble_rate")]
    return [name for name in compared if getattr(one, name) != getattr(other, name)]


def _curve(path: Path) -> tuple[Mapping[str, float], ...]:
    """Return the Zoo's evaluations during the training."""
    if not path.is_file():
        return ()
    with reading(path, "remove it", zipfile.BadZipFile), np.load(path, allow_pickle=False) as stored:
        steps, returns = stored["timesteps"], stored["results"].mean(axis=1)
        return tuple(
            {"steps": float(step), "mean_return": float(value)} for step, value in zip(steps, returns, strict=True)
        )


def _read_yaml(path: Path) -> dict[str, Any]:
    """Return the table in a file of the Zoo: plain data, and Python's ordered dictionaries and tuples."""
    require_extra("yaml")
    import yaml

    class Loader(yaml.SafeLoader):
        """A loader of plain data."""

    def ordered(loader: Any, node: Any) -> Any:
        return dict(loader.construct_sequence(node, deep=True)[0])

    def pair(loader: Any, node: Any) -> Any:
        return tuple(loader.construct_sequence(node, deep=True))

    Loader.add_constructor("tag:yaml.org,2002:python/object/apply:collections.OrderedDict", ordered)
    Loader.add_constructor("tag:yaml.org,2002:python/tuple", pair)
    with reading(path, "repair it", yaml.YAMLError):
        found = Loader(path.read_text(encoding="utf-8")).get_single_data()
        require(isinstance(found, dict), "content", "must be a table", type(found).__name__)
        return dict(found)
