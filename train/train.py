"""Train an agent with PPO: a residual on a baseline, or direct.

Everything a run needs or makes lies in its folder: ``config.json``, checkpoints with normaliser, ``evaluations.csv``,
TensorBoard logs, and in ``agent`` the best agent so far, judged by its mean return on fixed feasible episodes. A killed
run goes on from its last checkpoint with ``--resume``.

Examples
--------
    python train/train.py --run-folder runs/residual
    python train/train.py --run-folder runs/direct --base none --hold 1
    python train/train.py --run-folder runs/residual --resume
"""

from __future__ import annotations

import csv
import dataclasses
import json
import math
import re
import shutil
import subprocess
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import gymnasium as gym
import torch
import tyro
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback, CallbackList, ProgressBarCallback
from stable_baselines3.common.utils import LinearSchedule
from stable_baselines3.common.vec_env import VecNormalize

import ftac_gym
from ftac_gym import baselines
from ftac_gym.evaluation.agent import CARD_FILE, MODEL_FILE, NORMALIZER_FILE, Agent, Interface
from ftac_gym.evaluation.metrics import summarize
from ftac_gym.evaluation.rollout import rollout
from ftac_gym.wrappers import SB3VecEnv


@dataclass(frozen=True)
class PPOSettings:
    """Hyperparameters of PPO, in Stable-Baselines3's words."""

    learning_rate: float = 5e-4
    n_steps: int = 120
    batch_size: int = 15360
    n_epochs: int = 10
    gamma: float = 0.99
    gae_lambda: float = 0.95
    clip_range: float = 0.2
    ent_coef: float = 0.0
    vf_coef: float = 0.5
    max_grad_norm: float = 0.5
    use_sde: bool = False
    sde_sample_freq: int = 16


@dataclass(frozen=True)
class Config:
    """A training run."""

    run_folder: Path = Path("runs/flagship_residual")
    """Where everything goes."""
    env_id: str = "SpacecraftFTC-v0"
    """Environment id."""
    observation: Literal["attitude", "telemetry", "oracle"] = "attitude"
    """Information tier."""
    base: str = "pd_dob"
    """Baseline that the agent corrects; "none" trains a direct policy."""
    authority: float = 2.0
    """Authority of the residual."""
    fade_angle: float = 0.17
    """Pointing error [rad] below which the authority shrinks; zero never shrinks it."""
    fade_floor: float = 0.0
    """Share of the authority that is always kept."""
    hold: int = 5
    """Control periods for which the agent holds each action."""
    total_steps: int = 3_000_000
    """Decisions of the agent, over all craft; each takes \"hold\" steps of the environment."""
    num_envs: int = 512
    """Craft in parallel."""
    layers: tuple[int, ...] = (64, 64)
    """Hidden layers of the policy and of the value network."""
    log_std_init: float = -0.5
    """Logarithm of the initial standard deviation of the action."""
    critic_warmup: int = 5
    """Rollouts at the start in which only the value network learns: a base is easily unlearned by a blind critic."""
    anneal: bool = True
    """Let the learning rate fall to zero over the run."""
    seed: int = 0
    """Seed of everything."""
    torch_threads: int = 2
    """Threads of PyTorch."""
    evaluate_every: int = 250_000
    """Steps between evaluations on fixed episodes."""
    evaluation_episodes: int = 600
    """Episodes of an evaluation, of which the feasible ones count."""
    evaluation_seed: int = 900_000
    """Seed of those episodes: neither training nor the reported test uses it."""
    checkpoint_every: int = 500_000
    """Steps between checkpoints."""
    resume: bool = False
    """Go on from the last checkpoint in the run folder."""
    ppo: PPOSettings = field(default_factory=PPOSettings)
    """Hyperparameters of PPO."""

    @property
    def interface(self) -> Interface:
        """What surrounds the policy network."""
        base = None if self.base == "none" else self.base
        # The gains are written down: an agent must not change when the defaults of its base do.
        gains = {} if base is None else baselines.defaults(base)
        return Interface(self.observation, base, self.authority, self.fade_angle, self.fade_floor, self.hold, gains)


def make_env(config: Config) -> SB3VecEnv:
    """Build the training environment."""
    env = gym.make_vec(
        config.env_id, num_envs=config.num_envs, observation=config.observation, autoreset_mode="SameStep"
    )
    return SB3VecEnv(config.interface.wrap(env), config.hold)


def save_agent(folder: Path, model: PPO, config: Config) -> None:
    """Write model, normaliser and card; a folder appears whole or not at all."""
    partial = folder.with_name(folder.name + ".partial")
    shutil.rmtree(partial, ignore_errors=True)
    partial.mkdir(parents=True)
    model.save(partial / MODEL_FILE)
    normalizer = model.get_vec_normalize_env()
    if normalizer is not None:
        normalizer.save(str(partial / NORMALIZER_FILE))
    (partial / CARD_FILE).write_text(json.dumps(card(model, config), indent=2) + "\n")
    shutil.rmtree(folder, ignore_errors=True)
    partial.rename(folder)


def card(model: PPO, config: Config) -> dict[str, Any]:
    """Return what a reader needs to know of an agent."""
    return {
        "interface": dataclasses.asdict(config.interface),
        "environment": config.env_id,
        "command": command(config),
        "seed": config.seed,
        "commit": COMMIT,
        "steps": model.num_timesteps,
        "ftac_gym": ftac_gym.__version__,
    }


def command(config: Config) -> str:
    """Return the command line that makes a configuration."""
    default = Config()
    words = ["python train/train.py"]
    for prefix, values, usual in (("", config, default), ("ppo.", config.ppo, default.ppo)):
        for item in dataclasses.fields(values):
            value = getattr(values, item.name)
            if item.name in ("resume", "ppo") or value == getattr(usual, item.name):
                continue
            name = item.name.replace("_", "-")
            if isinstance(value, bool):
                words.append(f"--{prefix}{name}" if value else f"--{prefix}no-{name}")
            else:
                words.append(f"--{prefix}{name} {' '.join(map(str, value)) if isinstance(value, tuple) else value}")
    return " ".join(words)


def commit() -> str:
    """Return the git commit of the code, marked if the tree has changes; "unknown" outside a checkout."""
    try:
        command = ["git", "describe", "--always", "--dirty", "--abbrev=12", "--exclude=*"]
        return subprocess.run(
            command, capture_output=True, text=True, check=True, cwd=Path(__file__).parent
        ).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return "unknown"


COMMIT = commit()
"""Read when the run starts: the tree may move on while it trains."""


class Keeper(BaseCallback):
    """Checkpoints and evaluates at fixed numbers of steps, and keeps the best agent so far."""

    def __init__(self, config: Config) -> None:
        super().__init__()
        self._config = config
        self._next_checkpoint = config.checkpoint_every
        self._next_evaluation = config.evaluate_every
        self._best = -float("inf")

    def _on_training_start(self) -> None:
        config, steps = self._config, self.model.num_timesteps
        self._next_checkpoint = (steps // config.checkpoint_every + 1) * config.checkpoint_every
        self._next_evaluation = (steps // config.evaluate_every + 1) * config.evaluate_every
        known = (row["mean_return"] for row in evaluations(config.run_folder))
        self._best = max((value for value in known if not math.isnan(value)), default=-float("inf"))

    def _on_rollout_start(self) -> None:
        config, steps = self._config, self.model.num_timesteps
        warming = steps < config.critic_warmup * config.num_envs * config.ppo.n_steps
        policy = self._ppo.policy
        for part in (policy.mlp_extractor.policy_net, policy.action_net):
            part.requires_grad_(not warming)
        policy.log_std.requires_grad_(not warming)
        # Between rollouts the model is consistent: a resumed run starts where a rollout would.
        if steps >= self._next_evaluation:
            self._next_evaluation += config.evaluate_every
            self._evaluate(steps)
        if steps >= self._next_checkpoint:
            self._next_checkpoint += config.checkpoint_every
            self._checkpoint(steps)

    def _on_training_end(self) -> None:
        self._evaluate(self.model.num_timesteps)
        self._checkpoint(self.model.num_timesteps)

    @property
    def _ppo(self) -> PPO:
        assert isinstance(self.model, PPO)
        return self.model

    def _checkpoint(self, steps: int) -> None:
        save_agent(self._config.run_folder / "checkpoints" / f"{steps:010d}", self._ppo, self._config)

    def _evaluate(self, steps: int) -> None:
        config = self._config
        scenario = gym.spec(config.env_id).kwargs["default_scenario"]
        agent = Agent(self.model, self.model.get_vec_normalize_env(), config.interface)
        history = rollout(scenario, agent, seed=config.evaluation_seed, count=config.evaluation_episodes)
        feasible = history.episodes.feasible
        metrics = {name: values[feasible] for name, values in history.metrics().items()}
        row = {"steps": steps, "mean_return": float(metrics["return"].mean()), **summarize(metrics)}
        for name, value in row.items():
            if name != "steps":
                self.logger.record(f"evaluation/{name}", value)
        # The first agent is kept whatever it is worth, even if no evaluation episode was feasible.
        if row["mean_return"] > self._best or not (config.run_folder / "agent").exists():
            self._best = max(self._best, row["mean_return"])
            save_agent(config.run_folder / "agent", self._ppo, config)
        path = config.run_folder / "evaluations.csv"
        new = not path.exists()
        with path.open("a", newline="") as file:
            writer = csv.DictWriter(file, fieldnames=list(row))
            if new:
                writer.writeheader()
            writer.writerow(row)

    def _on_step(self) -> bool:
        return True


def evaluations(folder: Path) -> list[dict[str, float]]:
    """Return the evaluations of a run, oldest first."""
    path = folder / "evaluations.csv"
    if not path.exists():
        return []
    with path.open() as file:
        return [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]


def checkpoints(folder: Path) -> list[Path]:
    """Return the complete checkpoints of a run, oldest first."""
    return sorted(path for path in (folder / "checkpoints").glob("*") if re.fullmatch(r"\d{10}", path.name))


def resumed(config: Config) -> Config:
    """Return the configuration that a run was started with; only its length may be changed."""
    path = config.run_folder / "config.json"
    if not path.exists() or not checkpoints(config.run_folder):
        raise SystemExit(f"--resume: no checkpoint under {config.run_folder}; start the run without --resume")
    data = json.loads(path.read_text())
    saved = Config(**{
        **data,
        "run_folder": config.run_folder,
        "layers": tuple(data["layers"]),
        "ppo": PPOSettings(**data["ppo"]),
        "resume": True,
    })  # fmt: skip
    default = Config()
    for item in dataclasses.fields(config):
        given = getattr(config, item.name)
        if item.name in ("run_folder", "resume", "total_steps") or given == getattr(default, item.name):
            continue
        if given != getattr(saved, item.name):
            flag = item.name.replace("_", "-")
            raise SystemExit(f"--resume: the run was started with --{flag} {getattr(saved, item.name)}, got {given}")
    if config.total_steps != default.total_steps:
        saved = dataclasses.replace(saved, total_steps=config.total_steps)
    return saved


def main(config: Config) -> None:
    """Train."""
    if config.resume:
        config = resumed(config)
    torch.set_num_threads(config.torch_threads)
    folder = config.run_folder
    rate = config.ppo.learning_rate
    schedule: Any = LinearSchedule(rate, 0.0, 1.0) if config.anneal else rate
    settings = {**dataclasses.asdict(config.ppo), "learning_rate": schedule}
    if config.resume:
        checkpoint = checkpoints(folder)[-1]
        env: Any = VecNormalize.load(str(checkpoint / NORMALIZER_FILE), make_env(config))
        model = PPO.load(checkpoint / MODEL_FILE, env=env, device="cpu", custom_objects={"learning_rate": schedule})
        model.set_random_seed(config.seed + model.num_timesteps)
    else:
        if checkpoints(folder):
            raise SystemExit(f"{folder} holds a run already; choose another --run-folder, or --resume it")
        # What a run leaves that was killed before its first checkpoint is worth nothing.
        (folder / "evaluations.csv").unlink(missing_ok=True)
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "config.json").write_text(json.dumps(dataclasses.asdict(config), indent=2, default=str) + "\n")
        env = VecNormalize(make_env(config), gamma=config.ppo.gamma)
        layers = list(config.layers)
        policy = {"net_arch": {"pi": layers, "vf": layers}, "log_std_init": config.log_std_init}
        model = PPO(
            "MlpPolicy", env, policy_kwargs=policy, seed=config.seed, device="cpu",
            tensorboard_log=str(folder / "tensorboard"), **settings,
        )  # fmt: skip
    # Far apart for every run: Stable-Baselines3's own seeds would give neighbouring runs the same episodes.
    env.seed(1_000_000_000 * (config.seed + 1) + model.num_timesteps)
    remaining = config.total_steps - model.num_timesteps
    if remaining > 0:
        callbacks = CallbackList([Keeper(config), ProgressBarCallback()])
        model.learn(remaining, callback=callbacks, reset_num_timesteps=False, tb_log_name="ppo")
    best = json.loads((folder / "agent" / CARD_FILE).read_text())
    print(f"the best agent on the evaluation episodes, after {best['steps']} steps, is in {folder / 'agent'}")


if __name__ == "__main__":
    main(tyro.cli(Config, description=__doc__))
