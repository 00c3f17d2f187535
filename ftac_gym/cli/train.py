"""Train an agent: PPO, RecurrentPPO, SAC or TQC; a residual on a baseline, a scheduler of its gains, or direct.

Hyperparameters come from training/configs/ALGO.yml, by environment id, in the format of RL Baselines3 Zoo. All files
of a run lie in its folder: ``config.json``, checkpoints, ``evaluations.csv``, TensorBoard logs, and in ``agent`` the
best agent so far. The best agent has the largest mean return on validation episodes. ``--resume`` continues a
killed run from its last checkpoint and keeps the best agent.

For example:

    ftac-train --run-folder runs/residual
    ftac-train --run-folder runs/five --seeds 5
    ftac-train --run-folder runs/direct --wrappers --hold 1
    ftac-train --run-folder runs/scheduler --wrappers "GainScheduling base=pd_dob"
    ftac-train --run-folder runs/memory --wrappers "ResidualPolicy base=pd_dob authority=2.0" \
"ObservationHistory steps=4 stride=5" --critic-sees-faults
    ftac-train --run-folder runs/sac --algo sac --hyperparameters learning_rate=3e-4 buffer_size=200000
    ftac-train --run-folder runs/residual --resume
    ftac-train --run-folder runs/mine --scenario my_satellite.json \
--wrappers "ResidualPolicy base=pd_dob gains=runs/tuning/my_satellite/pd_dob/gains.json authority=2.0"
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Literal

from ftac_gym.utils.console import exit_on
from ftac_gym.utils.parameters import require


@dataclass(frozen=True)
class Config:
    """A training run; values of None come from the file of hyperparameters."""

    run_folder: Path = Path("runs/flagship_residual")
    """Folder of the run; with several seeds, it has a folder seed_K for each."""
    env_id: str = "SpacecraftFTC-v0"
    """Environment id, which names the hyperparameters; another one than the default also the task."""
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
    """Task: NAME, FILE.json or module:function. Training, evaluations and the base are on it; by default the task of
    the environment id. A scenario of one's own has the entry "default" of the hyperparameters."""
    training_scenario: str | None = None
    """Scenario of the training alone, in the same forms; evaluations stay on the task, whose spaces it needs."""
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
    """Steps between evaluations on validation episodes."""
    evaluation_episodes: int = 500
    """Feasible episodes of an evaluation. They are validation episodes: the frozen list of a split of the flagship, and
    drawn ones of other tasks. Neither the training nor the test uses them."""
    checkpoint_every: int = 500_000
    """Steps between checkpoints."""
    resume: bool = False
    """Continue from the last checkpoint in the run folder."""


BOUNDS = {
    "total_steps": (1, 10**12), "num_envs": (1, 10**6), "critic_warmup": (0, 10**12), "severity_steps": (0, 10**12),
    "seed": (0, 2**31 - 1), "seeds": (1, 10**6), "torch_threads": (1, 1024), "evaluate_every": (1, 10**12),
    "evaluation_episodes": (1, 10**9), "checkpoint_every": (1, 10**12),
}  # fmt: skip
"""Least and largest value of whole numbers."""


def check(config: Config) -> None:
    """Raise a ValueError that names a number out of its bounds."""
    for name, (least, most) in BOUNDS.items():
        if (value := getattr(config, name)) is not None:
            require(least <= value <= most, name, f"must be a whole number within {least} and {most}", value)


def main(config: Config) -> None:
    """Train all seeds, one after the other."""
    with exit_on(ValueError):
        check(config)
    # PyTorch takes seconds to import, which neither help nor a wrong option need.
    import_module("ftac_gym.cli.training_run").train_all(config)
