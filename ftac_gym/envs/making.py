"""Typed access to the environments of an id, without Gymnasium's wrappers around them."""

from typing import Any

import gymnasium as gym

from ftac_gym.envs.single import SpacecraftFTCEnv
from ftac_gym.envs.vector import SpacecraftFTCVectorEnv

_OF_WRAPPERS = ("max_episode_steps", "disable_env_checker")
"""Arguments of ``gymnasium.make`` that choose wrappers."""


def make(environment_id: str, **arguments: Any) -> SpacecraftFTCEnv:
    """Make the environment of an id: ``gymnasium.make`` without wrappers, and with the type of the environment.

    Parameters
    ----------
    environment_id
        For example ``"SpacecraftFTC-v0"``.
    **arguments
        As for :class:`~ftac_gym.envs.single.SpacecraftFTCEnv`.

    Raises
    ------
    TypeError
        If an argument is unknown.
    ValueError
        If the id is not one of this package, or a value breaks a rule.
    """
    for name in _OF_WRAPPERS:
        if name in arguments:
            raise TypeError(f"make() got an unexpected keyword argument {name!r}: gymnasium.make has it")
    env = gym.make(environment_id, disable_env_checker=True, **arguments).unwrapped
    if isinstance(env, SpacecraftFTCEnv):
        return env
    env.close()
    raise _foreign(environment_id)


def make_vec(environment_id: str, num_envs: int = 1, **arguments: Any) -> SpacecraftFTCVectorEnv:
    """Make the vector environment of an id: ``gymnasium.make_vec`` with the type of the environment.

    Parameters
    ----------
    environment_id
        For example ``"SpacecraftFTC-v0"``.
    num_envs
        Number of spacecraft N.
    **arguments
        As for :class:`~ftac_gym.envs.vector.SpacecraftFTCVectorEnv`.

    Raises
    ------
    TypeError
        If an argument is unknown.
    ValueError
        If the id is not one of this package, or a value breaks a rule.
    """
    env = gym.make_vec(environment_id, num_envs=num_envs, vectorization_mode="vector_entry_point", **arguments)
    if isinstance(env, SpacecraftFTCVectorEnv):
        return env
    env.close()
    raise _foreign(environment_id)


def _foreign(environment_id: str) -> ValueError:
    return ValueError(f"environment_id must be one of this package, got {environment_id!r}")
