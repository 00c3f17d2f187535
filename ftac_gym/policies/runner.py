"""A policy at the controls of many craft, control period by control period."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ftac_gym.envs import SpacecraftFTCVectorEnv
from ftac_gym.task.episodes import Episodes
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray

if TYPE_CHECKING:
    from ftac_gym.evaluation.rollout import Contestant


class Pilot:
    """A policy that flies N craft. A tumbling craft is not taken out: everyone is judged over the whole episode.

    Parameters
    ----------
    scenario
        The task.
    contestant
        Who flies.
    craft
        How many craft, N.
    threads
        Threads of the simulator.

    Raises
    ------
    ValueError
        If the policy does not fit the scenario.
    """

    def __init__(self, scenario: Scenario, contestant: Contestant, craft: int = 1, threads: int = 1) -> None:
        self.env = SpacecraftFTCVectorEnv(
            num_envs=craft,
            scenario=scenario.replace(tumble_rate=None),
            observation=contestant.tier,
            autoreset_mode="Disabled",
            threads=threads,
        )
        """The environment as it is, whatever the policy wraps it in."""
        self._contestant = contestant
        self._wrapped = contestant.attach(self.env)
        self._observation: Any = None
        self._state: Any = None
        self._start = np.ones(craft, dtype=np.bool_)

    def reset(self, episodes: Episodes) -> None:
        """Start episodes, one for each craft."""
        self._observation, _ = self._wrapped.reset(options={"episodes": episodes})
        self._state, self._start = None, np.ones(len(episodes), dtype=np.bool_)

    def step(self) -> FloatArray:
        """Fly on for one control period; return the rewards (N,)."""
        action, self._state = self._contestant.predict(self._observation, self._state, self._start, True)
        self._start = np.zeros_like(self._start)
        self._observation, rewards, *_ = self._wrapped.step(action)
        return np.asarray(rewards)
