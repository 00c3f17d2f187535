"""Policies without any skill, to compare returns with."""

from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium.vector import VectorEnv

from ftac_gym.envs import SpacecraftFTCVectorEnv


class ZeroPolicy:
    """Zero action: no wheel torque is ever commanded."""

    tier = "attitude"
    name = "zero"
    fingerprint = "zero"

    def attach(self, env: SpacecraftFTCVectorEnv) -> VectorEnv[Any, Any, Any]:
        """Return the environment unchanged."""
        self._shape = env.num_envs, env.scenario.spacecraft.wheels.count
        return env

    def predict(
        self, observation: Any, state: Any = None, episode_start: Any = None, deterministic: bool = True
    ) -> tuple[npt.NDArray[np.float64], Any]:
        """Return actions (N, wheels) of zero."""
        return np.zeros(self._shape), None


class RandomPolicy:
    """Random action: uniform over the action space, anew in every control period.

    Parameters
    ----------
    seed
        Seed of the actions; each flight begins with it.
    """

    tier = "attitude"
    name = "random"

    def __init__(self, seed: int = 0) -> None:
        self._seed = seed
        self.fingerprint = f"random {seed}"

    def attach(self, env: SpacecraftFTCVectorEnv) -> VectorEnv[Any, Any, Any]:
        """Return the environment unchanged."""
        self._shape = env.num_envs, env.scenario.spacecraft.wheels.count
        self._random = np.random.default_rng(self._seed)
        return env

    def predict(
        self, observation: Any, state: Any = None, episode_start: Any = None, deterministic: bool = True
    ) -> tuple[npt.NDArray[np.float64], Any]:
        """Return actions (N, wheels) within [-1, 1]; they are random whatever ``deterministic`` is."""
        if episode_start is not None and np.all(episode_start):
            self._random = np.random.default_rng(self._seed)
        return self._random.uniform(-1.0, 1.0, self._shape), None


REFERENCES = {"zero": ZeroPolicy, "random": RandomPolicy}
"""Policies without any skill, by name."""
