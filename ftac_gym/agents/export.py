"""Export of agents as Stable-Baselines3's own files."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

import gymnasium as gym

from ftac_gym.agents import network
from ftac_gym.utils.extras import require_extra

if TYPE_CHECKING:
    from ftac_gym.agents.agent import Agent

MODEL_FILE, NORMALIZER_FILE = "model.zip", "vecnormalize.pkl"
"""Files of an export, under the names of RL Baselines3 Zoo."""

_ALGORITHMS = {
    "ActorCriticPolicy": "stable_baselines3.PPO",
    "PrivilegedCriticPolicy": "stable_baselines3.PPO",
    "RecurrentActorCriticPolicy": "sb3_contrib.RecurrentPPO",
    "SACPolicy": "stable_baselines3.SAC",
    "TD3Policy": "stable_baselines3.TD3",
    "TQCPolicy": "sb3_contrib.TQC",
}


def export(agent: Agent, folder: str | Path) -> None:
    """Write an agent as a zip and a ``VecNormalize`` that Stable-Baselines3 loads.

    The algorithm has its default hyperparameters and the agent's network. The interface of the agent is not in these
    files: the environment needs its wrappers and its hold.

    Parameters
    ----------
    agent
        The agent.
    folder
        Folder for ``model.zip`` and, of an agent with a normaliser, ``vecnormalize.pkl``.
    """
    require_extra("stable_baselines3")
    import torch
    from stable_baselines3.common.vec_env import DummyVecEnv, VecNormalize

    description, _ = network.describe(agent.policy)
    kind, arguments = network.constructor(description)
    module, _, name = _ALGORITHMS[description["policy"]].rpartition(".")
    # Algorithms set it among the arguments of the policy, or beside them.
    settings: dict[str, Any] = {"use_sde": True} if arguments.pop("use_sde", False) else {}
    if description["policy"] in ("SACPolicy", "TD3Policy", "TQCPolicy"):
        settings["buffer_size"] = 1
    env = DummyVecEnv([lambda: _Spaces(agent.policy)])
    with torch.random.fork_rng(devices=[]):
        algorithm = getattr(import_module(module), name)
        model = algorithm(kind, env, policy_kwargs=arguments, device="cpu", **settings)
    model.policy.load_state_dict(agent.policy.state_dict())
    Path(folder).mkdir(parents=True, exist_ok=True)
    model.save(Path(folder) / MODEL_FILE)
    if agent.normalizer is not None:
        given = agent.normalizer
        wrapped = VecNormalize(env, training=False, norm_reward=False, clip_obs=given.clip, epsilon=given.epsilon)
        statistics: Any = wrapped.obs_rms
        statistics.mean, statistics.var, statistics.count = given.mean, given.variance, given.count
        wrapped.save(str(Path(folder) / NORMALIZER_FILE))


class _Spaces(gym.Env[Any, Any]):
    """The spaces of a network, as the environment that Stable-Baselines3 asks for."""

    def __init__(self, policy: Any) -> None:
        self.observation_space, self.action_space = policy.observation_space, policy.action_space
