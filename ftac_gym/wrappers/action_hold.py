"""An agent that decides less often than the controller runs."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
import numpy.typing as npt
from gymnasium.utils import RecordConstructorArgs
from gymnasium.vector import VectorEnv

from ftac_gym.utils.parameters import require, whole

Observation = npt.NDArray[np.float32]


class ActionHold(gym.Wrapper[Observation, npt.NDArray[Any], Observation, npt.NDArray[Any]], RecordConstructorArgs):
    """Hold every action for several control periods, or to the end of the episode, and add up their rewards.

    Observation and info are those of the last of these periods. It goes outside of all other wrappers of this package,
    which run once per control period. For vector environments see ``hold`` of
    :class:`~ftac_gym.wrappers.sb3.SB3VecEnv`.

    Parameters
    ----------
    env
        A single environment.
    steps
        Control periods per action.

    Raises
    ------
    ValueError
        If the environment is a vector or ``steps`` is not a positive integer.
    """

    def __init__(self, env: gym.Env[Any, Any], steps: int) -> None:
        rule = "must be a single environment: for a vector, SB3VecEnv(env, hold=...) holds actions"
        require(not isinstance(env, VectorEnv), "env", rule, env)
        self.steps = whole(steps, 1, "steps")
        RecordConstructorArgs.__init__(self, steps=self.steps)
        super().__init__(env)

    def step(self, action: npt.NDArray[Any]) -> tuple[Observation, Any, bool, bool, dict[str, Any]]:
        """Hold the action."""
        total = 0.0
        for _ in range(self.steps):
            observation, reward, terminated, truncated, info = self.env.step(action)
            total += float(reward)
            if terminated or truncated:
                break
        return observation, total, terminated, truncated, info
