"""Models of every algorithm, small enough to train within a test."""

import gymnasium as gym
from stable_baselines3.common.vec_env import VecNormalize

from ftac_gym.agents.interface import Interface
from ftac_gym.training.algorithms import build
from ftac_gym.training.hyperparameters import Hyperparameters
from ftac_gym.wrappers import SB3VecEnv

RESIDUAL = (("ResidualPolicy", {"base": "pd_dob", "authority": 0.5}),)
NUM_ENVS = 4


def model_of(algorithm, interface=Interface(), seed=1, **settings):  # noqa: B008
    """Return a fresh model and the number of entries for its actor."""
    native = gym.make_vec("SpacecraftFTC-v0", num_envs=NUM_ENVS, autoreset_mode="SameStep", duration=3.0)
    single = interface.wrap(gym.make("SpacecraftFTC-v0"))
    size = single.observation_space.shape[0]
    env = VecNormalize(SB3VecEnv(interface.wrap_for_training(native), interface.hold))
    policy = "MlpLstmPolicy" if algorithm == "recurrent_ppo" else "MlpPolicy"
    layers = {"net_arch": {"pi": [16], "vf" if "ppo" in algorithm else "qf": [16]}}
    own = {"n_steps": 8, "batch_size": 32} if "ppo" in algorithm else {"buffer_size": 500, "learning_starts": 40}
    hyperparameters = Hyperparameters(interface, 1000, NUM_ENVS, {}, policy, layers, True, {**own, **settings})
    return build(algorithm, hyperparameters, env, size, seed=seed), size
