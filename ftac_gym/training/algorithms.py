"""Models of the four algorithms; an agent on a base starts as its base."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import torch
from stable_baselines3 import PPO, SAC
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.off_policy_algorithm import OffPolicyAlgorithm
from stable_baselines3.common.on_policy_algorithm import OnPolicyAlgorithm
from stable_baselines3.common.vec_env import VecEnv

from ftac_gym.agents.interface import ON_BASE, Interface
from ftac_gym.training.hyperparameters import ALGORITHMS, Hyperparameters
from ftac_gym.training.networks import PrivilegedCriticPolicy
from ftac_gym.utils.extras import require_extra
from ftac_gym.utils.parameters import require

BASE_NOISE = 0.1
"""Standard deviation of the actions with which an off-policy agent collects data about its base."""


def build(
    algorithm: str,
    hyperparameters: Hyperparameters,
    env: VecEnv,
    actor_size: int,
    seed: int,
    log_folder: Path | None = None,
) -> BaseAlgorithm:
    """Return an untrained model; one that corrects or schedules a base starts as its base.

    Parameters
    ----------
    algorithm
        One of :data:`~ftac_gym.training.hyperparameters.ALGORITHMS`.
    hyperparameters
        Hyperparameters of the training.
    env
        The environment, wrapped by the interface's ``wrap_for_training``.
    actor_size
        Number of entries of the observation for the actor.
    seed
        Seed of network and exploration.
    log_folder
        Folder of TensorBoard logs.

    Raises
    ------
    ValueError
        If the algorithm is unknown, or its critic is to see the faults and it is not PPO.
    MissingExtra
        If it is of sb3-contrib, which is not installed.
    """
    require(algorithm in ALGORITHMS, "algo", f"must be one of {list(ALGORITHMS)}", algorithm)
    kinds: dict[str, type[BaseAlgorithm]] = {"ppo": PPO, "sac": SAC}
    if algorithm not in kinds:
        require_extra("sb3_contrib")
        from sb3_contrib import TQC, RecurrentPPO

        kinds |= {"recurrent_ppo": RecurrentPPO, "tqc": TQC}
    policy: Any = hyperparameters.policy
    policy_kwargs = dict(hyperparameters.policy_kwargs)
    if hyperparameters.interface.critic_sees_faults:
        require(algorithm == "ppo", "critic_sees_faults", "must go with ppo", algorithm)
        policy, policy_kwargs["actor_size"] = PrivilegedCriticPolicy, actor_size
    on_base = has_base(hyperparameters.interface)
    kind: Any = _sampling(kinds[algorithm], BASE_NOISE) if on_base else kinds[algorithm]
    logs = None if log_folder is None else str(log_folder)
    model: BaseAlgorithm = kind(
        policy, env, policy_kwargs=policy_kwargs, seed=seed, device="cpu", tensorboard_log=logs,
        **hyperparameters.arguments(),
    )  # fmt: skip
    if on_base:
        start_as_base(model)
    return model


def has_base(interface: Interface) -> bool:
    """Return whether an agent acts through a base, for which an action of zero is the base's own command."""
    return any(name in ON_BASE for name, _ in interface.wrappers)


def _sampling(kind: type[BaseAlgorithm], noise: float) -> type[BaseAlgorithm]:
    """Return an off-policy algorithm whose actions before learning are not uniform; others as they are.

    Uniform actions tumble the spacecraft, which teaches the critic nothing about the base.

    Parameters
    ----------
    kind
        The algorithm; the class that is returned has its name.
    noise
        Standard deviation of actions around zero, the base's own.
    """

    def sample(
        model: Any, learning_starts: int, action_noise: Any = None, n_envs: int = 1
    ) -> tuple[np.ndarray, np.ndarray]:
        if model.num_timesteps >= learning_starts:
            sampled: tuple[np.ndarray, np.ndarray] = kind._sample_action(model, 0, action_noise, n_envs)  # type: ignore[attr-defined]
            return sampled
        drawn = model.action_space.np_random.normal(0.0, noise, (n_envs, *model.action_space.shape))
        action = np.clip(drawn, -1.0, 1.0).astype(np.float32)
        return action, action

    return type(kind.__name__, (kind,), {"_sample_action": sample}) if issubclass(kind, OffPolicyAlgorithm) else kind


def start_as_base(model: BaseAlgorithm) -> None:
    """Set the last layer of the actor to zero: its mean action is the base's for every observation.

    The exploration of off-policy actors depends on the observation; it starts at ``log_std_init`` everywhere.
    """
    policy: Any = model.policy
    with torch.no_grad():
        if isinstance(model, OnPolicyAlgorithm):
            _set(policy.action_net, 0.0)
            return
        actor = policy.actor
        # With state-dependent exploration the mean is clipped behind its layer.
        _set(actor.mu[0] if isinstance(actor.mu, torch.nn.Sequential) else actor.mu, 0.0)
        if isinstance(actor.log_std, torch.nn.Linear):
            _set(actor.log_std, actor.log_std_init)


def _set(layer: Any, value: float) -> None:
    """Make the output of a linear layer constant."""
    layer.weight.zero_()
    layer.bias.fill_(value)


def refill(model: BaseAlgorithm) -> int:
    """Delay the learning of an off-policy model that has lost its replay buffer until its own flights have filled it.

    Returns
    -------
    Decisions until then: what the buffer lacks to the ``learning_starts`` of the model; 0 before these have passed.
    """
    trained: Any = model
    buffer = trained.replay_buffer
    lacking: int = min(trained.learning_starts, buffer.buffer_size * buffer.n_envs) - buffer.size() * buffer.n_envs
    if lacking <= 0 or model.num_timesteps < trained.learning_starts:
        return 0
    sample = trained._sample_action
    trained.learning_starts = model.num_timesteps + lacking
    trained._sample_action = lambda _, *others: sample(0, *others)  # The agent's own actions, not those of a start.
    return lacking


def let_actor_learn(model: BaseAlgorithm, learn: bool) -> None:
    """Freeze or free the actor of an on-policy model; the critic always learns.

    Stable-Baselines3 skips parameters without a gradient, which leaves the frozen ones bit for bit as they are.
    """
    policy: Any = model.policy
    parts = [policy.action_net, policy.mlp_extractor.policy_net]
    if hasattr(policy, "lstm_actor") and not policy.shared_lstm:
        parts.append(policy.lstm_actor)
    for part in parts:
        part.requires_grad_(learn)
    policy.log_std.requires_grad_(learn)
