"""Agents without training, for tests of how agents are stored, found and flown."""

import csv

from stable_baselines3 import PPO
from stable_baselines3.common.vec_env import VecNormalize

from ftac_gym.agents.agent import Agent
from ftac_gym.agents.interface import Interface
from ftac_gym.envs import SpacecraftFTCVectorEnv
from ftac_gym.wrappers import SB3VecEnv


def write_agent(folder, interface=Interface(), seed=0, scenario="flagship"):  # noqa: B008
    """Write an agent with its normaliser and card."""
    Agent.of(model_with(interface, seed, scenario), interface).save(folder, seed=seed)
    return folder


def model_with(interface, seed=0, scenario="flagship"):
    """Return an untrained model of PPO."""
    native = SpacecraftFTCVectorEnv(
        num_envs=2, scenario=scenario, observation=interface.observation, autoreset_mode="SameStep"
    )
    env = VecNormalize(SB3VecEnv(interface.wrap(native), interface.hold))
    return PPO("MlpPolicy", env, n_steps=8, batch_size=16, policy_kwargs={"net_arch": [8]}, seed=seed, device="cpu")


def write_curve(folder, steps):
    with (folder / "evaluations.csv").open("w", newline="") as file:
        csv.writer(file).writerows([("steps", "mean_return"), *((step, 0.5 * step) for step in steps)])
