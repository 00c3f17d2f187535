"""Gymnasium environments: one spacecraft, and N of them side by side."""

from ftac_gym.envs.making import make, make_vec
from ftac_gym.envs.single import SpacecraftFTCEnv
from ftac_gym.envs.vector import SpacecraftFTCVectorEnv

__all__ = ["SpacecraftFTCEnv", "SpacecraftFTCVectorEnv", "make", "make_vec"]
