"""A training run: one agent, or the rest of it, in its folder."""

from __future__ import annotations

import dataclasses
import json
import time
from collections.abc import Mapping
from typing import Any

import gymnasium as gym
import torch
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.callbacks import CallbackList, ProgressBarCallback
from stable_baselines3.common.vec_env import VecEnv, VecNormalize

import ftac_gym
from ftac_gym import scenarios
from ftac_gym.agents.interface import Interface
from ftac_gym.agents.storage import read_card
from ftac_gym.cli.tasks import is_own, scenario_of
from ftac_gym.cli.train import Config, check
from ftac_gym.task.scenario import Scenario
from ftac_gym.training.algorithms import build, has_base
from ftac_gym.training.callbacks import Schedule, TrainingCallback
from ftac_gym.training.checkpoints import checkpoints, naming_divergence, restore_newest
from ftac_gym.training.environments import evaluator, training_environment
from ftac_gym.training.evaluations import AGENT, Evaluations
from ftac_gym.training.hyperparameters import (
    CONFIGS,
    Hyperparameters,
    parse_assignments,
    read_hyperparameters,
    with_base_gains,
    wrappers_from_text,
)
from ftac_gym.utils.console import alone_in, command_line, commit, exit_on
from ftac_gym.utils.files import reading, write_text
from ftac_gym.utils.options import options_of
from ftac_gym.utils.parameters import require
from ftac_gym.utils.serialization import parse_json

CONFIG_FILE = "config.json"
SCENARIO_FILES = {"scenario": "scenario.json", "training_scenario": "training_scenario.json"}
"""Copies of a user's own scenarios in the folder of a run, which goes on with them even if the originals change."""
NOTHING = "--resume: no checkpoint under {}; start the run without --resume"
COMMIT = commit() or "unknown"
"""Read at the start: the working tree may change while a run trains."""


def hyperparameters_of(config: Config) -> Hyperparameters:
    """Return the hyperparameters of the file with the changes of the command line."""
    changes = parse_assignments(config.hyperparameters, "hyperparameters")
    for name, value in (("n_timesteps", config.total_steps), ("n_envs", config.num_envs)):
        changes |= {} if value is None else {name: value}
    own = is_own(config.scenario) and config.env_id == Config.env_id
    parameters = read_hyperparameters(CONFIGS / f"{config.algo}.yml", "default" if own else env_id_of(config), changes)
    usual = parameters.interface
    interface = Interface(
        usual.observation if config.observation is None else config.observation,
        usual.wrappers if config.wrappers is None else wrappers_from_text(config.wrappers),
        usual.hold if config.hold is None else config.hold,
        config.critic_sees_faults,
    )
    return dataclasses.replace(parameters, interface=with_base_gains(interface))


def schedule_of(config: Config, parameters: Hyperparameters) -> Schedule:
    """Return the schedule of the run; without a base, the critic needs no warm-up."""
    return Schedule(
        config.evaluate_every, config.checkpoint_every, config.evaluation_episodes,
        config.critic_warmup if has_base(parameters.interface) else 0, config.severity_start, config.severity_steps,
    )  # fmt: skip


def env_id_of(config: Config) -> str:
    """Return the environment id: the one that is given, or the one of which the scenario is the task."""
    if config.env_id != Config.env_id:
        return config.env_id
    ids = {spec.kwargs.get("default_scenario"): name for name, spec in gym.registry.items() if is_ours(name)}
    return ids.get(config.scenario, config.env_id)


def is_ours(env_id: str) -> bool:
    """Tell whether an environment id is of this package."""
    return gym.spec(env_id).entry_point == "ftac_gym.envs:SpacecraftFTCEnv"


def task_of(config: Config) -> Scenario:
    """Return the task, without the weights of the reward that the run asks for."""
    if config.scenario is None:
        return scenarios.get(gym.spec(config.env_id).kwargs["default_scenario"])
    return given(config, "scenario")


def given(config: Config, option: str) -> Scenario:
    """Return the scenario of an option; of a resumed run, a user's own as it was at the start."""
    text = getattr(config, option)
    path = config.run_folder / SCENARIO_FILES[option]
    return scenario_of(str(path) if config.resume and is_own(text) else text, option.replace("_", "-"))


def training_scenario(config: Config, parameters: Hyperparameters, task: Scenario) -> Scenario:
    """Return the scenario of the training, with the weights of the reward that the run asks for."""
    changes = dict(parameters.env_kwargs)
    if config.training_scenario is not None:
        changes["scenario"] = given(config, "training_scenario")
    elif config.scenario is not None:
        changes["scenario"] = task
    scenario: Scenario = gym.make(env_id_of(config), **changes).unwrapped.scenario  # type: ignore[attr-defined]
    return scenario.replace(reward=parse_assignments(config.reward, "reward"))


def provenance(config: Config, steps: int, seconds: float) -> dict[str, Any]:
    """Return the origin of an agent, for its card."""
    return {
        "environment": env_id_of(config),
        "scenario": task_of(config).name,
        "algorithm": config.algo,
        "command": command_line("ftac-train", config, never=("resume", "seeds")),
        "seed": config.seed,
        "commit": COMMIT,
        "steps": steps,
        "training_seconds": round(seconds),
        "ftac_gym": ftac_gym.__version__,
    }


def resumed(config: Config) -> Config:
    """Return the configuration of the run that is resumed; only its length may be changed."""
    path = config.run_folder / CONFIG_FILE
    if not checkpoints(config.run_folder):
        raise SystemExit(NOTHING.format(config.run_folder))
    with exit_on(ValueError, prefix="--resume: "), reading(path, "restore it, or start again in a new --run-folder"):
        saved = options_of(Config, parse_json(path.read_bytes()))
        saved = dataclasses.replace(saved, run_folder=config.run_folder, resume=True)
        check(saved)
    for item in dataclasses.fields(config):
        given, before = getattr(config, item.name), getattr(saved, item.name)
        if item.name not in ("run_folder", "resume", "total_steps", "seeds") and given not in (before, item.default):
            flag = item.name.replace("_", "-")
            raise SystemExit(f"--resume: the run was started with --{flag} {before}, got {given}")
    return saved if config.total_steps is None else dataclasses.replace(saved, total_steps=config.total_steps)


def train(config: Config) -> None:
    """Train one agent, or the rest of it, alone in its folder."""
    if config.resume:
        config = resumed(config)
    torch.set_num_threads(config.torch_threads)
    folder = config.run_folder
    arguments = "--wrappers or --hyperparameters: "
    with exit_on(ValueError, gym.error.Error), exit_on(TypeError, AssertionError, prefix=arguments):
        require(is_ours(config.env_id), "env_id", "must be an environment of ftac_gym", config.env_id)
        parameters = hyperparameters_of(config)
        schedule = schedule_of(config, parameters)
        task = task_of(config)
        scenario = training_scenario(config, parameters, task)
        env, actor_size = training_environment(
            env_id_of(config), scenario, parameters.interface, parameters.n_envs, task
        )
        # Evaluations are on the task itself, with the reward of the training.
        judge = evaluator(task, schedule.evaluation_episodes, scenario.reward)
        around: VecEnv = env
        if parameters.normalize:
            around = VecNormalize(env, gamma=parameters.settings.get("gamma", 0.99))
        model = build(config.algo, parameters, around, actor_size, config.seed, folder / "tensorboard")
        if schedule.severity_start < 1.0:
            # Refused if the faults have none.
            env.env_method("set_severity", schedule.severity_start)
    with alone_in(folder, "run-folder"):
        if config.resume:
            seconds = restored(config, model)
        else:
            start(config)
            seconds = 0.0
        with exit_on(ValueError, prefix="--resume: "):
            evaluations = Evaluations(folder, model.num_timesteps)
        steps, begun = model.num_timesteps, time.monotonic()
        # Before the first episodes are drawn, which is before any callback.
        if schedule.severity_start < 1.0:
            env.env_method("set_severity", schedule.severity(steps))
        # Far apart for every run: Stable-Baselines3's own seeds would give neighbouring runs the same episodes.
        around.seed(1_000_000_000 * (config.seed + 1) + steps)
        if steps < parameters.n_timesteps:
            callback = TrainingCallback(
                folder, evaluations, judge, parameters.interface, schedule,
                lambda steps: provenance(config, steps, seconds + time.monotonic() - begun), report,
            )  # fmt: skip
            bar = ProgressBarCallback()
            try:
                with exit_on(FloatingPointError, prefix=""), naming_divergence(model):
                    model.learn(
                        parameters.n_timesteps - steps, callback=CallbackList([callback, bar]),
                        reset_num_timesteps=False, tb_log_name=config.algo,
                    )  # fmt: skip
            finally:
                if hasattr(bar, "pbar"):
                    bar.pbar.close()  # It complains at the end of the process if an error has left it open.
    with exit_on(ValueError, prefix=""):
        best = read_card(folder / AGENT)
    print(f"the best agent on the evaluation episodes, after {best['steps']} steps, is in {folder / AGENT}")


def report(steps: int, metrics: Mapping[str, float]) -> None:
    """Print a line on an evaluation: its flights are deterministic, on the episodes that pick the best agent."""
    on_target, share, mean = metrics["availability"], metrics["success"], metrics["mean_return"]
    scores = f"availability {on_target:.3f}, success {share:.3f}, mean return {mean:.1f}"
    print(f"after {steps:,} decisions: {scores} (deterministic)", flush=True)


def start(config: Config) -> None:
    """Write the configuration of a new run to its folder, if that holds none."""
    folder = config.run_folder
    if checkpoints(folder) or (folder / AGENT).exists():
        raise SystemExit(f"{folder} holds a run already; choose another --run-folder, or --resume it")
    written = dataclasses.asdict(dataclasses.replace(config, seeds=1))
    for option, name in SCENARIO_FILES.items():
        if is_own(getattr(config, option)):
            write_text(folder / name, given(config, option).to_json() + "\n")
    write_text(folder / CONFIG_FILE, json.dumps(written, indent=2, default=str) + "\n")


def restored(config: Config, model: BaseAlgorithm) -> float:
    """Give a model the state of the last whole checkpoint, and return the seconds of training until then."""
    with exit_on(ValueError, prefix="--resume: "):
        card = restore_newest(config.run_folder, model)
    model.set_random_seed(config.seed + model.num_timesteps)
    return float(card.get("training_seconds", 0.0))


def train_all(config: Config) -> None:
    """Train all seeds, one after the other."""
    if config.seeds == 1:
        train(config)
        return
    folders = {seed: config.run_folder / f"seed_{seed}" for seed in range(config.seed, config.seed + config.seeds)}
    begun = [folder for folder in folders.values() if checkpoints(folder)]
    if config.resume and not begun:
        raise SystemExit(NOTHING.format(config.run_folder))
    for seed, folder in folders.items():
        print(f"seed {seed}, in {folder}")
        if not config.resume or folder in begun:
            train(dataclasses.replace(config, run_folder=folder, seed=seed, seeds=1))
        else:
            # A seed without a checkpoint is trained with the settings of the others.
            sibling = resumed(dataclasses.replace(config, run_folder=begun[0], seed=Config.seed, seeds=1))
            train(dataclasses.replace(sibling, run_folder=folder, seed=seed, resume=False))
