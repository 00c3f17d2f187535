"""Train an agent: PPO, RecurrentPPO, SAC or TQC; a residual on a baseline, a scheduler of its gains, or direct.

Hyperparameters come from training/configs/ALGO.yml, by environment id, in the format of RL Baselines3 Zoo. All files
of a run lie in its folder: ``config.json``, checkpoints, ``evaluations.csv``, TensorBoard logs, and in ``agent`` the
best agent so far. The best agent has the largest mean return on fixed feasible episodes. ``--resume`` continues a
killed run from its last checkpoint and keeps the best agent.

For example:

    python train/train.py --run-folder runs/residual
    python train/train.py --run-folder runs/five --seeds 5
    python train/train.py --run-folder runs/direct --wrappers --hold 1
    python train/train.py --run-folder runs/scheduler --wrappers "GainScheduling base=pd_dob"
    python train/train.py --run-folder runs/memory --wrappers "ResidualPolicy base=pd_dob authority=2.0" \
"ObservationHistory steps=4 stride=5" --critic-sees-faults
    python train/train.py --run-folder runs/sac --algo sac --hyperparameters learning_rate=3e-4 buffer_size=200000
    python train/train.py --run-folder runs/residual --resume
"""

from __future__ import annotations

import dataclasses
import json
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import gymnasium as gym
import torch
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.callbacks import CallbackList, ProgressBarCallback
from stable_baselines3.common.vec_env import VecEnv, VecNormalize

import ftac_gym
from ftac_gym import scenarios
from ftac_gym.agents.interface import Interface
from ftac_gym.agents.storage import read_card
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
NOTHING = "--resume: no checkpoint under {}; start the run without --resume"
COMMIT = commit(CONFIGS) or "unknown"
"""Read at the start: the working tree may change while a run trains."""


@dataclass(frozen=True)
class Config:
    """A training run; values of None come from the file of hyperparameters."""

    run_folder: Path = Path("runs/flagship_residual")
    """Folder of the run; with several seeds, it has a folder seed_K for each."""
    env_id: str = "SpacecraftFTC-v0"
    """Environment id."""
    algo: Literal["ppo", "recurrent_ppo", "sac", "tqc"] = "ppo"
    """Algorithm."""
    observation: Literal["attitude", "telemetry", "oracle"] | None = None
    """Information tier."""
    wrappers: tuple[str, ...] | None = None
    """Wrappers, innermost first, each as "NAME ARGUMENT=VALUE ..." (see ftac_gym.wrappers); none given: direct."""
    hold: int | None = None
    """Control periods for which the agent holds each action."""
    critic_sees_faults: bool = False
    """Add the true effect of the faults to the observation of the critic alone (ppo only)."""
    hyperparameters: tuple[str, ...] = ()
    """Changes to the hyperparameters, as NAME=VALUE; policy_kwargs.NAME=VALUE reaches the policy's."""
    scenario: str | None = None
    """Scenario to train on, by default the environment's, on which evaluations always are."""
    reward: tuple[str, ...] = ()
    """Changes to the weights of the reward, as NAME=VALUE, in training and in the evaluations that pick the best."""
    total_steps: int | None = None
    """Decisions of the agent, over all spacecraft; each takes \"hold\" steps of the environment."""
    num_envs: int | None = None
    """Spacecraft in parallel."""
    critic_warmup: int = 300_000
    """Decisions at the start in which an on-policy agent's critic alone learns: an untrained critic degrades the base.
    Off-policy algorithms have learning_starts, during which they fly the base with a little noise."""
    severity_start: float = 1.0
    """Severity of the faults at the start, in [0, 1]; it rises evenly to one."""
    severity_steps: int = 1_000_000
    """Decisions after which the severity is one."""
    seed: int = 0
    """Seed of the run."""
    seeds: int = 1
    """Number of agents, with this seed and the following ones."""
    torch_threads: int = 2
    """Threads of PyTorch."""
    evaluate_every: int = 250_000
    """Steps between evaluations on fixed episodes."""
    evaluation_episodes: int = 600
    """Episodes of an evaluation, of which the feasible ones count."""
    evaluation_seed: int = 900_000
    """Seed of those episodes, which neither training nor the reported test uses."""
    checkpoint_every: int = 500_000
    """Steps between checkpoints."""
    resume: bool = False
    """Continue from the last checkpoint in the run folder."""


BOUNDS = {
    "total_steps": (1, 10**12), "num_envs": (1, 10**6), "critic_warmup": (0, 10**12), "severity_steps": (0, 10**12),
    "seed": (0, 2**31 - 1), "seeds": (1, 10**6), "torch_threads": (1, 1024), "evaluate_every": (1, 10**12),
    "evaluation_episodes": (1, 10**9), "evaluation_seed": (0, 2**31 - 1), "checkpoint_every": (1, 10**12),
}  # fmt: skip
"""Least and largest value of whole numbers."""


def check(config: Config) -> None:
    """Raise a ValueError that names a number out of its bounds."""
    for name, (least, most) in BOUNDS.items():
        if (value := getattr(config, name)) is not None:
            require(least <= value <= most, name, f"must be a whole number within {least} and {most}", value)


def hyperparameters_of(config: Config) -> Hyperparameters:
    """Return the hyperparameters of the file with the changes of the command line."""
    changes = parse_assignments(config.hyperparameters, "hyperparameters")
    for name, value in (("n_timesteps", config.total_steps), ("n_envs", config.num_envs)):
        changes |= {} if value is None else {name: value}
    parameters = read_hyperparameters(CONFIGS / f"{config.algo}.yml", config.env_id, changes)
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
        config.evaluate_every, config.checkpoint_every, config.evaluation_episodes, config.evaluation_seed,
        config.critic_warmup if has_base(parameters.interface) else 0, config.severity_start, config.severity_steps,
    )  # fmt: skip


def training_scenario(config: Config, parameters: Hyperparameters) -> Scenario:
    """Return the scenario of the training, with the weights of the reward that the run asks for."""
    changes = dict(parameters.env_kwargs)
    if config.scenario is not None:
        changes["scenario"] = config.scenario
    scenario: Scenario = gym.make(config.env_id, **changes).unwrapped.scenario  # type: ignore[attr-defined]
    return scenario.replace(reward=parse_assignments(config.reward, "reward"))


def provenance(config: Config, steps: int, seconds: float) -> dict[str, Any]:
    """Return the origin of an agent, for its card."""
    return {
        "environment": config.env_id,
        "algorithm": config.algo,
        "command": command_line("train/train.py", config, never=("resume", "seeds")),
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
        known = gym.spec(config.env_id).entry_point == "ftac_gym.envs:SpacecraftFTCEnv"
        require(known, "env_id", "must be an environment of ftac_gym", config.env_id)
        parameters = hyperparameters_of(config)
        schedule = schedule_of(config, parameters)
        scenario = training_scenario(config, parameters)
        env, actor_size = training_environment(config.env_id, scenario, parameters.interface, parameters.n_envs)
        # Evaluations are on the task itself, with the reward of the training.
        task = scenarios.get(gym.spec(config.env_id).kwargs["default_scenario"]).replace(reward=scenario.reward)
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
                folder, evaluations, evaluator(task, schedule.evaluation_seed, schedule.evaluation_episodes),
                parameters.interface, schedule,
                lambda steps: provenance(config, steps, seconds + time.monotonic() - begun),
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


def start(config: Config) -> None:
    """Write the configuration of a new run to its folder, if that holds none."""
    folder = config.run_folder
    if checkpoints(folder) or (folder / AGENT).exists():
        raise SystemExit(f"{folder} holds a run already; choose another --run-folder, or --resume it")
    written = dataclasses.asdict(dataclasses.replace(config, seeds=1))
    write_text(folder / CONFIG_FILE, json.dumps(written, indent=2, default=str) + "\n")


def restored(config: Config, model: BaseAlgorithm) -> float:
    """Give a model the state of the last whole checkpoint, and return the seconds of training until then."""
    with exit_on(ValueError, prefix="--resume: "):
        card = restore_newest(config.run_folder, model)
    model.set_random_seed(config.seed + model.num_timesteps)
    return float(card.get("training_seconds", 0.0))


def main(config: Config) -> None:
    """Train all seeds, one after the other."""
    with exit_on(ValueError):
        check(config)
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
