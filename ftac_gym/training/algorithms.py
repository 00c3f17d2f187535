"""Models of the four algorithms, set up so that an agent on a base starts as its base."""

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

from ftac_gym.agents.agent import ON_BASE, Interface
from ftac_gym.training.hyperparameters import ALGORITHMS, Recipe
from ftac_gym.training.networks import PrivilegedCriticPolicy
from ftac_gym.utils.parameters import require

BASE_NOISE = 0.1
"""Standard deviation of the actions with which an off-policy agent collects data about its base."""


def build(
    algorithm: str, recipe: Recipe, env: VecEnv, actor_size: int, seed: int, log_folder: Path | None = None
) -> BaseAlgorithm:
    """Return a model that has not learned yet; one that corrects or schedules a base starts as its base.

    Parameters
    ----------
    algorithm
        One of :data:`ALGORITHMS`.
    recipe
        How to train.
    env
        The environment, as the interface's ``wrap_for_training`` has it.
    actor_size
        How many entries of its observation the actor may see.
    seed
        Seed of network and exploration.
    log_folder
        Where TensorBoard logs go.

    Raises
    ------
    ValueError
        If the algorithm is unknown, or its critic shall see the faults and it is not PPO.
    ImportError
        If it is of sb3-contrib, which is not installed.
    """
    require(algorithm in ALGORITHMS, "algo", f"must be one of {list(ALGORITHMS)}", algorithm)
    told = recipe.interface.critic_sees_faults
    require(not told or algorithm == "ppo", "critic_sees_faults", "must go with ppo", algorithm)
    policy_kwargs = dict(recipe.policy_kwargs)
    policy: Any = recipe.policy
    if told:
        policy = PrivilegedCriticPolicy
        policy_kwargs["actor_size"] = actor_size
    kind = kind_of(algorithm, on_base=has_base(recipe.interface))
    model = kind(
        policy, env, policy_kwargs=policy_kwargs, seed=seed, device="cpu",
        tensorboard_log=None if log_folder is None else str(log_folder), **recipe.arguments(),
    )  # fmt: skip
    if has_base(recipe.interface):
        start_as_base(model)
    return model


def has_base(interface: Interface) -> bool:
    """Tell whether an agent acts through a base, whose own action is an action of zero."""
    return any(name in ON_BASE for name, _ in interface.wrappers)


def kind_of(algorithm: str, on_base: bool) -> type[BaseAlgorithm]:
    """Return the class of an algorithm; off-policy ones on a base begin with data about it."""
    kinds: dict[str, type[BaseAlgorithm]] = {"ppo": PPO, "sac": SAC}
    if algorithm not in kinds:
        from sb3_contrib import TQC, RecurrentPPO

        kinds |= {"recurrent_ppo": RecurrentPPO, "tqc": TQC}
    return _sampling(_BaseData, kinds[algorithm]) if on_base else kinds[algorithm]


def resumed_kind(kind: type[BaseAlgorithm]) -> type[BaseAlgorithm]:
    """Return an algorithm as it goes on: an off-policy one fills its first buffer with what its own policy does."""
    return _sampling(_OwnData, kind)


def _sampling(way: type, kind: type[BaseAlgorithm]) -> type[BaseAlgorithm]:
    """Return an off-policy algorithm that samples its first actions in some way, under its name; others as they are."""
    return type(kind.__name__, (way, kind), {}) if issubclass(kind, OffPolicyAlgorithm) else kind


class _BaseData:
    """Until learning starts, fly the base with a little noise: uniform actions would teach the critic of tumbling."""

    action_space: Any
    num_timesteps: int

    def _sample_action(
        self, learning_starts: int, action_noise: Any = None, n_envs: int = 1
    ) -> tuple[np.ndarray, np.ndarray]:
        if self.num_timesteps >= learning_starts:
            return super()._sample_action(learning_starts, action_noise, n_envs)  # type: ignore[misc,no-any-return]
        noise = self.action_space.np_random.normal(0.0, BASE_NOISE, (n_envs, *self.action_space.shape))
        action = np.clip(noise, -1.0, 1.0).astype(np.float32)
        return action, action


class _OwnData:
    """Act by the policy from the first step on."""

    def _sample_action(
        self, learning_starts: int, action_noise: Any = None, n_envs: int = 1
    ) -> tuple[np.ndarray, np.ndarray]:
        return super()._sample_action(0, action_noise, n_envs)  # type: ignore[misc,no-any-return]


def start_as_base(model: BaseAlgorithm) -> None:
    """Set the last layer of the actor to zero: its mean action is the base's, whatever it sees.

    Off-policy actors learn how far they explore from what they see; they start at ``log_std_init`` everywhere.
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
    """Let a linear layer give a value whatever goes in."""
    layer.weight.zero_()
    layer.bias.fill_(value)


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
