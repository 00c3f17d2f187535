"""The environments."""

from ftac_gym.envs.single import SpacecraftFTCEnv
from ftac_gym.envs.vector import SpacecraftFTCVectorEnv

__all__ = ["SpacecraftFTCEnv", "SpacecraftFTCVectorEnv"]
