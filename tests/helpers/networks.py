"""Untrained models of every kind of network that an agent can have."""

import gymnasium as gym
import numpy as np
import pytest
from sb3_contrib import TQC, RecurrentPPO
from stable_baselines3 import PPO, SAC, TD3
from stable_baselines3.common.vec_env import DummyVecEnv, VecNormalize
from torch import nn

from ftac_gym.training.networks import PrivilegedCriticPolicy

SIZE, ACTIONS = 6, 4


class Spaces(gym.Env):
    """Spaces without dynamics; one bound is infinite, and one action has another range than [-1, 1]."""

    def __init__(self):
        self.observation_space = gym.spaces.Box(-1.0, np.array([0.1, np.inf, 1.0, 1.0, 1.0, 1.0], dtype=np.float32))
        self.action_space = gym.spaces.Box(-1.0, np.array([1.0, 1.0, 1.0, 0.3], dtype=np.float32))


def environment():
    """Return the spaces with a normaliser, whose statistics are random numbers."""
    env, rng = VecNormalize(DummyVecEnv([Spaces]), clip_obs=5.0, epsilon=1e-7), np.random.default_rng(3)
    env.obs_rms.mean, env.obs_rms.var, env.obs_rms.count = rng.normal(size=SIZE), rng.uniform(0.1, 2.0, SIZE), 12.5
    return env


def model_of(kind=PPO, policy="MlpPolicy", arguments=None, **settings):
    """Return an untrained model, whose weights are far from their start."""
    if kind in (SAC, TD3, TQC):
        settings["buffer_size"] = 10
    model = kind(policy, environment(), policy_kwargs=arguments or {"net_arch": [5]}, seed=1, device="cpu", **settings)
    for values in model.policy.parameters():
        values.data.uniform_(-0.7, 0.7)
    return model


TWO = {"pi": [5, 3], "vf": [4]}
LSTM = {"net_arch": [5], "lstm_hidden_size": 3}
MODELS = {
    "ppo": {},
    "ppo apart": {"arguments": {"net_arch": TWO, "activation_fn": nn.ELU}},
    "ppo sde": {"use_sde": True},
    "ppo sde squashed": {
        "use_sde": True,
        "arguments": {"net_arch": [5], "full_std": False, "use_expln": True, "squash_output": True},
    },
    "ppo privileged": {"policy": PrivilegedCriticPolicy, "arguments": {"net_arch": TWO, "actor_size": 4}},
    "recurrent": {"kind": RecurrentPPO, "policy": "MlpLstmPolicy", "arguments": LSTM},
    "recurrent shared": {
        "kind": RecurrentPPO,
        "policy": "MlpLstmPolicy",
        "arguments": {**LSTM, "n_lstm_layers": 2, "shared_lstm": True, "enable_critic_lstm": False},
    },
    "sac": {"kind": SAC},
    "sac sde": {"kind": SAC, "use_sde": True, "arguments": {"net_arch": {"pi": [5], "qf": [4]}, "n_critics": 3}},
    "td3": {"kind": TD3},
    "tqc": {"kind": TQC, "arguments": {"net_arch": [5], "n_quantiles": 7}},
}

every_model = pytest.mark.parametrize("name", MODELS)


def observations(size=SIZE):
    """Return observations (50, size), some of which the normaliser clips."""
    return np.random.default_rng(0).normal(0.0, 3.0, (50, size)).astype(np.float32)
