"""Train an agent: PPO, RecurrentPPO, SAC or TQC; a residual on a baseline, a scheduler of its gains, or direct.

Hyperparameters come from train/configs/ALGO.yml, by environment id, in RL Baselines3 Zoo's format. Everything a run
needs or makes lies in its folder: ``config.json``, checkpoints with normaliser, ``evaluations.csv``, TensorBoard logs,
and in ``agent`` the best agent so far, judged by its mean return on fixed feasible episodes. A killed run goes on from
its last checkpoint with ``--resume``.

Examples
--------
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
import shlex
import subprocess
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import gymnasium as gym
import torch
import tyro
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.callbacks import CallbackList, ProgressBarCallback
from stable_baselines3.common.off_policy_algorithm import OffPolicyAlgorithm
from stable_baselines3.common.vec_env import VecEnv, VecNormalize

import ftac_gym
from ftac_gym import scenarios
from ftac_gym.agents.agent import CARD_FILE, MODEL_FILE, NORMALIZER_FILE, Interface, load_model
from ftac_gym.agents.shipped import EVALUATIONS_FILE
from ftac_gym.task.scenario import Scenario
from ftac_gym.training.algorithms import build, has_base, resumed_kind
from ftac_gym.training.callbacks import Keeper, Schedule, checkpoints
from ftac_gym.training.hyperparameters import Recipe, parse_values, parse_words, read_recipe, written_out
from ftac_gym.utils.parameters import require
from ftac_gym.wrappers import SB3VecEnv

CONFIGS = Path(__file__).parent / "configs"


@dataclass(frozen=True)
class Config:
    """A training run. What is None comes from the file of hyperparameters."""

    run_folder: Path = Path("runs/flagship_residual")
    """Where everything goes; with several seeds, a folder seed_K in it for each."""
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
    """Tell the critic, and it alone, what the faults really do (ppo only)."""
    hyperparameters: tuple[str, ...] = ()
    """Changes to the hyperparameters, as NAME=VALUE; policy_kwargs.NAME=VALUE reaches the policy's."""
    scenario: str | None = None
    """Scenario to train on, by default the environment's, on which evaluations always are."""
    reward: tuple[str, ...] = ()
    """Changes to the weights of the reward, as NAME=VALUE, in training and in the evaluations that pick the best."""
    total_steps: int | None = None
    """Decisions of the agent, over all craft; each takes \"hold\" steps of the environment."""
    num_envs: int | None = None
    """Craft in parallel."""
    critic_warmup: int = 300_000
    """Decisions at the start in which an on-policy agent's critic alone learns: a base is easily unlearned by a blind
    critic. Off-policy algorithms have learning_starts, during which they fly the base with a little noise."""
    severity_start: float = 1.0
    """Severity of the faults at the start, in [0, 1]; it rises evenly to one."""
    severity_steps: int = 1_000_000
    """Decisions after which the severity is one."""
    seed: int = 0
    """Seed of everything."""
    seeds: int = 1
    """Train so many agents, with this seed and those that follow."""
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

    @property
    def recipe(self) -> Recipe:
        """What to train: the file's entry, with what was given."""
        changes = parse_values(self.hyperparameters, "hyperparameters")
        for name, value in (("n_timesteps", self.total_steps), ("n_envs", self.num_envs)):
            changes |= {} if value is None else {name: value}
        recipe = read_recipe(CONFIGS / f"{self.algo}.yml", self.env_id, changes)
        usual = recipe.interface
        interface = Interface(
            usual.observation if self.observation is None else self.observation,
            usual.wrappers if self.wrappers is None else parse_words(self.wrappers),
            usual.hold if self.hold is None else self.hold,
            self.critic_sees_faults,
        )
        return dataclasses.replace(recipe, interface=written_out(interface))

    @property
    def schedule(self) -> Schedule:
        """When to do what."""
        return Schedule(
            self.evaluate_every, self.checkpoint_every, self.evaluation_episodes, self.evaluation_seed,
            # There is nothing to protect without a base.
            self.critic_warmup if has_base(self.recipe.interface) else 0, self.severity_start, self.severity_steps,
        )  # fmt: skip


def make_env(config: Config, recipe: Recipe) -> tuple[SB3VecEnv, int]:
    """Return the training environment, and how many entries of its observation the actor may see."""
    interface = recipe.interface
    arguments: dict[str, Any] = {"observation": interface.observation, "scenario": training_scenario(config, recipe)}
    native = gym.make_vec(config.env_id, num_envs=recipe.n_envs, autoreset_mode="SameStep", **arguments)
    single = interface.wrap(gym.make(config.env_id, **arguments))
    # What it is trained on may differ from what it is for and evaluated on, but not in what the agent sees and does.
    task = interface.wrap(gym.make(config.env_id, observation=interface.observation))
    for part in ("observation_space", "action_space"):
        given, wanted = getattr(single, part).shape, getattr(task, part).shape
        rule = f"must have the {part.replace('_', ' ')} {wanted} of {config.env_id}"
        require(given == wanted, "scenario", rule, given)
    return SB3VecEnv(interface.wrap_for_training(native), interface.hold), single.observation_space.shape[0]


def training_scenario(config: Config, recipe: Recipe) -> Scenario:
    """Return the scenario to train on, with the weights of the reward that the run asks for."""
    changes = dict(recipe.env_kwargs) if config.scenario is None else {**recipe.env_kwargs, "scenario": config.scenario}
    scenario: Scenario = gym.make(config.env_id, **changes).unwrapped.scenario  # type: ignore[attr-defined]
    weights = parse_values(config.reward, "reward")
    known = [item.name for item in dataclasses.fields(scenario.reward)]
    for name in weights:
        require(name in known, "reward", f"must be among {known}", name)
    return scenario.replace(reward=dataclasses.replace(scenario.reward, **weights))


def card(config: Config, recipe: Recipe, steps: int, seconds: float) -> dict[str, Any]:
    """Return what a reader needs to know of an agent."""
    return {
        "interface": dataclasses.asdict(recipe.interface),
        "normalized": recipe.normalize,
        "environment": config.env_id,
        "algorithm": config.algo,
        "command": command(config),
        "seed": config.seed,
        "commit": COMMIT,
        "steps": steps,
        "training_seconds": round(seconds),
        "ftac_gym": ftac_gym.__version__,
    }


def command(config: Config) -> str:
    """Return the command line that makes a configuration."""
    words, default = ["python", "train/train.py"], Config()
    for item in dataclasses.fields(config):
        value = getattr(config, item.name)
        if item.name in ("resume", "seeds") or value == getattr(default, item.name):
            continue
        flag = "--" + item.name.replace("_", "-")
        if isinstance(value, bool):
            words.append(flag)
        else:
            words += [flag, *(map(str, value) if isinstance(value, tuple) else [str(value)])]
    return shlex.join(words)


def commit() -> str:
    """Return the git commit of the code, marked if the tree has changes; "unknown" outside a checkout."""
    try:
        words = ["git", "describe", "--always", "--dirty", "--abbrev=12", "--exclude=*"]
        return subprocess.run(
            words, capture_output=True, text=True, check=True, cwd=Path(__file__).parent
        ).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return "unknown"


COMMIT = commit()
"""Read when the run starts: the tree may move on while it trains."""


def resumed(config: Config) -> Config:
    """Return the configuration that a run was started with; only its length may be changed."""
    path = config.run_folder / "config.json"
    if not path.exists() or not checkpoints(config.run_folder):
        raise SystemExit(f"--resume: no checkpoint under {config.run_folder}; start the run without --resume")
    written = json.loads(path.read_text())
    data: dict[str, Any] = {name: tuple(item) if isinstance(item, list) else item for name, item in written.items()}
    saved = Config(**{**data, "run_folder": config.run_folder, "resume": True})
    default = Config()
    for item in dataclasses.fields(config):
        given = getattr(config, item.name)
        if item.name in ("run_folder", "resume", "total_steps", "seeds") or given == getattr(default, item.name):
            continue
        if given != getattr(saved, item.name):
            flag = item.name.replace("_", "-")
            raise SystemExit(f"--resume: the run was started with --{flag} {getattr(saved, item.name)}, got {given}")
    if config.total_steps is not None:
        saved = dataclasses.replace(saved, total_steps=config.total_steps)
    return saved


def restored(config: Config, recipe: Recipe, env: SB3VecEnv) -> tuple[BaseAlgorithm, float]:
    """Return the model of the last checkpoint, with its normaliser, and its seconds of training."""
    checkpoint = checkpoints(config.run_folder)[-1]
    normalizer = checkpoint / NORMALIZER_FILE
    wrapped: VecEnv = env
    if recipe.normalize:
        if not normalizer.is_file():
            raise SystemExit(f"--resume: {checkpoint} has no {NORMALIZER_FILE}: resume from a whole checkpoint")
        wrapped = VecNormalize.load(str(normalizer), env)
    schedules = {name: value for name, value in recipe.arguments().items() if callable(value)}
    model = load_model(checkpoint / MODEL_FILE, wrapped, resumed_kind, **schedules)
    model.set_random_seed(config.seed + model.num_timesteps)
    if isinstance(model, OffPolicyAlgorithm):
        # The buffer is not kept: it is filled anew, by the policy as it is, before learning goes on.
        model.learning_starts += model.num_timesteps
    # What a killed run found out after its last checkpoint is found out again.
    path = config.run_folder / EVALUATIONS_FILE
    if path.exists():
        heading, *rows = path.read_text().splitlines()
        kept = [row for row in rows if int(row.split(",")[0]) <= model.num_timesteps]
        path.write_text("\n".join([heading, *kept]) + "\n")
    return model, float(json.loads((checkpoint / CARD_FILE).read_text())["training_seconds"])


def train(config: Config) -> None:
    """Train one agent."""
    if config.resume:
        config = resumed(config)
    folder = config.run_folder
    try:
        known = gym.spec(config.env_id).entry_point == "ftac_gym.envs:SpacecraftFTCEnv"
        require(known, "env_id", "must be an environment of ftac_gym", config.env_id)
        recipe, schedule = config.recipe, config.schedule
        env, actor_size = make_env(config, recipe)
        if config.resume:
            model, seconds = restored(config, recipe, env)
        else:
            if checkpoints(folder):
                raise SystemExit(f"{folder} holds a run already; choose another --run-folder, or --resume it")
            wrapped: VecEnv = env
            if recipe.normalize:
                wrapped = VecNormalize(env, gamma=recipe.settings.get("gamma", 0.99))
            model, seconds = build(config.algo, recipe, wrapped, actor_size, config.seed, folder / "tensorboard"), 0.0
        if schedule.severity_start < 1.0:
            # Before the first episodes are drawn, which is before any callback; refused if the faults have none.
            env.env_method("set_severity", schedule.severity(model.num_timesteps))
    except (ValueError, gym.error.Error) as error:
        raise SystemExit(f"--{error}") from None
    except (TypeError, AssertionError) as error:  # an argument that a wrapper or the algorithm does not take
        raise SystemExit(f"--wrappers or --hyperparameters: {error}") from None
    if not config.resume:
        # What a run leaves that was killed before its first checkpoint is worth nothing.
        (folder / EVALUATIONS_FILE).unlink(missing_ok=True)
        folder.mkdir(parents=True, exist_ok=True)
        written = dataclasses.asdict(dataclasses.replace(config, seeds=1))
        (folder / "config.json").write_text(json.dumps(written, indent=2, default=str) + "\n")
    around = model.get_env()
    assert around is not None
    # Far apart for every run: Stable-Baselines3's own seeds would give neighbouring runs the same episodes.
    around.seed(1_000_000_000 * (config.seed + 1) + model.num_timesteps)
    remaining, started = recipe.n_timesteps - model.num_timesteps, time.monotonic()
    if remaining > 0:
        # The task itself, whatever it is trained on, but for what counts as good.
        reward = training_scenario(config, recipe).reward
        task = scenarios.get(gym.spec(config.env_id).kwargs["default_scenario"]).replace(reward=reward)
        keeper = Keeper(
            folder, task, recipe.interface, schedule,
            lambda steps, taken: card(config, recipe, steps, taken), lambda: seconds + time.monotonic() - started,
        )  # fmt: skip
        callbacks = CallbackList([keeper, ProgressBarCallback()])
        model.learn(remaining, callback=callbacks, reset_num_timesteps=False, tb_log_name=config.algo)
    best = json.loads((folder / "agent" / CARD_FILE).read_text())
    print(f"the best agent on the evaluation episodes, after {best['steps']} steps, is in {folder / 'agent'}")


def main(config: Config) -> None:
    """Train all seeds, one after the other."""
    if config.seeds < 1:
        raise SystemExit(f"--seeds must be positive, got {config.seeds}")
    torch.set_num_threads(config.torch_threads)
    if config.seeds == 1:
        train(config)
        return
    folders = {seed: config.run_folder / f"seed_{seed}" for seed in range(config.seed, config.seed + config.seeds)}
    begun = [folder for folder in folders.values() if checkpoints(folder)]
    if config.resume and not begun:
        raise SystemExit(f"--resume: no checkpoint under {config.run_folder}; start the run without --resume")
    for seed, folder in folders.items():
        print(f"seed {seed}, in {folder}")
        if not config.resume or folder in begun:
            train(dataclasses.replace(config, run_folder=folder, seed=seed, seeds=1))
        else:
            # A seed that was not begun is trained as its siblings are.
            sibling = resumed(dataclasses.replace(config, run_folder=begun[0], seed=Config.seed, seeds=1))
            train(dataclasses.replace(sibling, run_folder=folder, seed=seed, resume=False))


if __name__ == "__main__":
    main(tyro.cli(Config, description=__doc__))
