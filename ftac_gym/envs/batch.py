"""N spacecraft with their episodes, observations and rewards."""

from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium import spaces

from ftac_gym.dynamics import Simulator
from ftac_gym.envs.observer import Observer
from ftac_gym.envs.reward import Reward
from ftac_gym.envs.true_faults import TrueFaults
from ftac_gym.task.episodes import Episodes
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, real_numbers, require
from ftac_gym.utils.randomness import keys_from_seeds

BoolArray = npt.NDArray[np.bool_]


class SpacecraftBatch:
    """N spacecraft with their episode counters.

    Parameters
    ----------
    scenario
        The task; every wheel needs a torque limit, which scales the action.
    observation
        Information tier.
    num_spacecraft
        Number of spacecraft N.
    threads
        Threads of the simulator.

    Raises
    ------
    ValueError
        If a wheel has no torque limit, or the tier is unknown.
    """

    def __init__(self, scenario: Scenario, observation: str, num_spacecraft: int, threads: int = 1) -> None:
        self.scenario = scenario
        self.simulator = Simulator(scenario, num_spacecraft, threads)
        self.observer = Observer(self.simulator, observation)
        self.reward = Reward(self.simulator)
        self.true_faults = TrueFaults(self.simulator)
        limits = scenario.spacecraft.wheels.torque_limits
        limited = bool(np.isfinite(limits).all())
        require(limited, "torque_limit", "must be finite for every wheel: it scales the action", limits)
        self.horizon = scenario.horizon
        self.indices = np.arange(num_spacecraft)
        self._keys = np.zeros((num_spacecraft, 2), dtype=np.uint32)
        self._counter = np.zeros(num_spacecraft, dtype=np.int64)
        self._limits = np.tile(limits, (num_spacecraft, 1))
        layout = self.observer.layout
        self.observation_space = spaces.Box(layout.low, layout.high, dtype=np.float32)
        self.action_space = spaces.Box(-1.0, 1.0, limits.shape, dtype=np.float32)

    def seed(self, index: int, seed: int) -> None:
        """Start over with episode 0 of a seed at the next reset of a spacecraft."""
        self._keys[index] = keys_from_seeds([seed])[0]
        self._counter[index] = 0

    def reset(
        self, rows: npt.NDArray[np.int64], observation: npt.NDArray[np.float32], episodes: Episodes | None
    ) -> None:
        """Start the next episodes, or those given, of the listed spacecraft; write their rows of ``observation``."""
        if episodes is None:
            self.simulator.begin(self.scenario.draw_from_keys(self._keys[rows], self._counter[rows]), rows)
            self._counter[rows] += 1
        else:
            mask = np.zeros(len(self.indices), dtype=np.bool_)
            mask[rows] = True
            self.simulator.reset(episodes, mask)
        self.observer.observe(rows, observation)
        self.reward.update(rows)
        self.true_faults.begin(rows)

    def step(self, action: npt.ArrayLike) -> tuple[npt.NDArray[np.float32], FloatArray, BoolArray, BoolArray]:
        """Advance all spacecraft by one control period.

        Parameters
        ----------
        action
            (N, wheels) fractions of the torque limits; clipped to [-1, 1].

        Returns
        -------
        Fresh observation (N, size), reward terms (terms, N), terminated (N,), truncated (N,).

        Raises
        ------
        ValueError
            If the action has the wrong shape, is not finite, or does not consist of real numbers.
        DivergenceError
            If a spacecraft has diverged. The others have completed the step: after a reset of those that the error
            names, all go on.
        """
        given = np.asarray(action)
        if given.shape != self._limits.shape:
            raise ValueError(f"action must have shape {self._limits.shape}, got {given.shape}")
        fraction = real_numbers(given, "action").astype(np.float64, copy=False)
        require(bool(np.isfinite(fraction).all()), "action", "must be finite", fraction)
        simulator = self.simulator
        command = simulator.last_command
        np.minimum(fraction, 1.0, out=command)
        np.maximum(command, -1.0, out=command)
        np.multiply(command, self._limits, out=command)
        observation = np.empty((len(self.indices), self.observer.layout.size), dtype=np.float32)
        try:
            simulator.advance()
        finally:  # The filters of the others take every step, even if one has diverged.
            self.observer.observe(self.indices, observation)
            terms, terminated = self.reward.update(self.indices)
        return observation, terms, terminated, simulator.ticks >= self.horizon

    def facts(self) -> dict[str, npt.NDArray[Any]]:
        """Return the entries of ``info`` for all spacecraft now, fresh arrays (N,) or (N, faults); angles [deg]."""
        return {
            "time": self.simulator.time,
            "attitude_error": np.degrees(self.reward.attitude_error),
            "rate_error": np.degrees(self.reward.rate_error),
            "is_success": self.reward.success,
            "availability": self.reward.periods_on_target / np.maximum(self.simulator.ticks, 1),
            "cost": self.reward.outside * self.scenario.control_period,
            "feasible": self.simulator.feasible.copy(),
            **self.true_faults.facts(),
        }
