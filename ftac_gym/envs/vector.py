"""N faulty spacecraft as a native Gymnasium vector environment."""

from collections.abc import Mapping, Sequence
from typing import Any

import gymnasium as gym
import numpy as np
import numpy.typing as npt
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from ftac_gym.envs.base import BatchEnvironment, requested_episodes, resolve_scenario
from ftac_gym.envs.batch import BoolArray, SpacecraftBatch
from ftac_gym.envs.rendering.display import RENDER_MODES
from ftac_gym.envs.reward import REWARD_KEYS, total
from ftac_gym.scenarios import ScenarioLike
from ftac_gym.task.measurement import Measurement
from ftac_gym.utils.parameters import FloatArray, is_whole, require, whole

Observation = npt.NDArray[np.float32]


class SpacecraftFTCVectorEnv(BatchEnvironment, VectorEnv[Observation, npt.NDArray[Any], npt.NDArray[Any]]):
    """N spacecraft that step together, each the same to the bit as a :class:`~ftac_gym.envs.SpacecraftFTCEnv`.

    Spacecraft ``i`` of ``reset(seed=s)`` is the single environment after ``reset(seed=s + i)``. Spaces, rewards and
    info keys are those of the single environment, with Gymnasium's conventions for vectors: ``info`` holds arrays with
    masks ``_name``, and in same-step mode ``final_obs`` and ``final_info``.

    Parameters
    ----------
    num_envs
        Number of spacecraft N.
    scenario, observation, render_mode, width, height, default_scenario, **scenario_changes
        As for the single environment. A window shows the first 16 spacecraft side by side.
    autoreset_mode
        Reset at the end of an episode: ``"NextStep"``, ``"SameStep"`` or ``"Disabled"``, or the enum.
    max_episode_steps
        Truncate after this many steps, if that comes before the scenario's duration; None or -1 for no such limit.
    threads
        Threads that share the spacecraft; the result does not depend on it.

    Raises
    ------
    TypeError
        If a keyword is no argument and no field of a scenario.
    ValueError
        If a name is unknown or a value breaks a rule.
    gymnasium.error.DependencyNotInstalled
        If a window is asked for and pygame is missing.
    """

    metadata: dict[str, Any] = {  # noqa: RUF012  as in Gymnasium
        "render_modes": list(RENDER_MODES),
        "render_fps": 10,
        "autoreset_mode": AutoresetMode.NEXT_STEP,
    }

    def __init__(
        self,
        num_envs: int = 1,
        scenario: ScenarioLike | None = None,
        observation: str = "attitude",
        render_mode: str | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        max_episode_steps: int | None = None,
        threads: int = 1,
        width: int = 640,
        height: int = 480,
        default_scenario: str = "flagship",
        **scenario_changes: Any,
    ) -> None:
        require(is_whole(num_envs) and num_envs > 0, "num_envs", "must be a positive integer", num_envs)
        known = [mode.value for mode in AutoresetMode]
        valid = isinstance(autoreset_mode, AutoresetMode) or autoreset_mode in known
        require(valid, "autoreset_mode", f"must be an AutoresetMode or one of {known}", autoreset_mode)
        self.num_envs = int(num_envs)
        self.autoreset_mode = AutoresetMode(autoreset_mode)
        self.metadata = {**self.metadata, "autoreset_mode": self.autoreset_mode}
        chosen = resolve_scenario(scenario, default_scenario, scenario_changes, type(self).__name__)
        self._prepare(SpacecraftBatch(chosen, observation, self.num_envs, threads), render_mode, width, height)
        if max_episode_steps is not None and max_episode_steps != -1:
            self.batch.horizon = min(self.batch.horizon, whole(max_episode_steps, 1, "max_episode_steps"))
        self.single_observation_space = self.batch.observation_space
        self.single_action_space = self.batch.action_space
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self._seeded = np.zeros(self.num_envs, dtype=np.bool_)
        self._observation = np.zeros((self.num_envs, self.batch.observer.layout.size), dtype=np.float32)
        self._ended = np.zeros(self.num_envs, dtype=np.bool_)
        self.final_measurement: Measurement | None = None
        """Same-step mode: the measurement just before the latest automatic reset."""
        self.keep_final_truth = False
        """True to have the effect of the faults in the final measurement, for an oracle."""

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Start the next episodes.

        Parameters
        ----------
        seed
            An integer s seeds spacecraft i with s + i. A sequence has a seed, or None to go on, for each spacecraft;
            None goes on with all.
        options
            ``{"reset_mask": mask}`` (N,) resets only some spacecraft; ``{"episodes": Episodes}`` replays the given
            episodes, one per spacecraft that is reset. :func:`~ftac_gym.task.fitting.fitted` checks them and labels
            them for this scenario.

        Returns
        -------
        Observations (N, size) and infos.

        Raises
        ------
        ValueError
            If the mask is not a boolean array (N,) with at least one True, or the seeds are not N.
        """
        episodes = requested_episodes(options, ("reset_mask", "episodes"))
        mask = self._reset_mask(options)
        chosen = np.flatnonzero(mask)
        self._seed(seed, chosen)
        self.batch.reset(chosen, self._observation, episodes)
        self._ended[chosen] = False
        self._show()
        return self._observation.copy(), _masked(self.batch.facts(), mask)

    def step(self, actions: npt.ArrayLike) -> tuple[Observation, FloatArray, BoolArray, BoolArray, dict[str, Any]]:
        """Hold an action for one control period on every spacecraft.

        Parameters
        ----------
        actions
            (N, wheels) fractions of the torque limits.

        Returns
        -------
        Observations, rewards, terminations, truncations and infos, in fresh arrays.

        Raises
        ------
        ValueError
            If the actions have the wrong shape or are not finite.
        DivergenceError
            If a spacecraft has diverged; the error names it, the time and the quantity.
        gymnasium.error.ResetNeeded
            In disabled mode, if a spacecraft whose episode has ended was not reset.
        """
        if not self._seeded.all():
            raise gym.error.ResetNeeded("call reset() before step()")
        if self.autoreset_mode is AutoresetMode.DISABLED and self._ended.any():
            ended = np.flatnonzero(self._ended).tolist()
            raise gym.error.ResetNeeded(
                f"spacecraft {ended} have ended; reset them with options={{'reset_mask': mask}}"
            )
        observation, terms, terminated, truncated = self.batch.step(actions)
        stepped = np.ones(self.num_envs, dtype=np.bool_)
        if self.autoreset_mode is AutoresetMode.NEXT_STEP and self._ended.any():
            restarted = np.flatnonzero(self._ended)
            self.batch.reset(restarted, observation, None)
            for array in (stepped, terminated, truncated):
                array[restarted] = False
            terms[:, restarted] = 0.0
        self._ended = terminated | truncated
        reward_terms = dict(zip(REWARD_KEYS, terms, strict=True))
        infos: dict[str, Any] = {}
        if self.autoreset_mode is AutoresetMode.SAME_STEP and self._ended.any():
            infos.update(self._final_infos(observation, reward_terms))
            self.batch.reset(np.flatnonzero(self._ended), observation, None)
            stepped = ~self._ended
        infos.update(_masked(self.batch.facts(), np.ones(self.num_envs, dtype=np.bool_)))
        if stepped.any():
            infos.update(_masked(reward_terms, stepped))
        self._observation = observation
        self._show()
        return observation.copy(), total(terms), terminated, truncated, infos

    def render(self) -> tuple[npt.NDArray[np.uint8], ...] | None:
        """Return a frame (height, width, 3) of each spacecraft; None in a window or without a render mode."""
        return self._display.render(self.policy_name)

    def close_extras(self, **kwargs: Any) -> None:
        """Close the window, if there is one."""
        self._close_display()

    def _final_infos(self, observation: Observation, reward_terms: Mapping[str, FloatArray]) -> dict[str, Any]:
        """Return the infos of the episodes that have just ended, and keep their last measurement."""
        mask = self._ended
        self.final_measurement = self.measurement(truth=self.keep_final_truth)
        final_observation = np.full(self.num_envs, None, dtype=object)
        for index in np.flatnonzero(mask):
            final_observation[index] = observation[index].copy()
        final_info = _masked({**self.batch.facts(), **reward_terms}, mask)
        finals = {"final_obs": final_observation, "final_info": final_info}
        return {**finals, **{f"_{name}": mask.copy() for name in finals}}

    def _reset_mask(self, options: dict[str, Any] | None) -> BoolArray:
        mask = (options or {}).get("reset_mask")
        if mask is None:
            return np.ones(self.num_envs, dtype=np.bool_)
        valid = isinstance(mask, np.ndarray) and mask.dtype == np.bool_ and mask.shape == (self.num_envs,)
        rule = f"must be a boolean array of shape ({self.num_envs},) with at least one True"
        require(valid and bool(mask.any()), 'options["reset_mask"]', rule, mask)
        chosen: BoolArray = mask
        return chosen

    def _seed(self, seed: int | Sequence[int | None] | None, chosen: npt.NDArray[np.int64]) -> None:
        seeds: Sequence[int | None] = [None] * self.num_envs
        require(not isinstance(seed, bool), "seed", "must be an integer or a list of seeds", seed)
        if isinstance(seed, (int, np.integer)):
            super().reset(seed=int(seed))
            seeds = [int(seed) + index for index in range(self.num_envs)]
        elif seed is not None:
            require(isinstance(seed, (list, tuple, np.ndarray)), "seed", "must be an integer or a list of seeds", seed)
            seeds = seed
        require(len(seeds) == self.num_envs, "seed", f"must be an integer or {self.num_envs} seeds", seed)
        for index in chosen.tolist():
            value = seeds[index]
            valid = value is None or (is_whole(value) and value >= 0)
            require(valid, f"seed[{index}]", "must be a non-negative integer or None", value)
        for index in chosen.tolist():
            value = seeds[index]
            if value is None and not self._seeded[index]:
                value = int(self.np_random.integers(2**62))
            if value is not None:
                self.batch.seed(index, value)
        self._seeded[chosen] = True


def _masked(values: Mapping[str, Any], mask: BoolArray) -> dict[str, Any]:
    """Return the arrays by name, zero where the mask is False, each followed by its mask ``_name``."""
    infos: dict[str, Any] = {}
    whole = bool(mask.all())
    for name, array in values.items():
        rows = mask if array.ndim == 1 else mask[:, None]
        infos[name] = array if whole else np.where(rows, array, np.zeros((), array.dtype))
        infos[f"_{name}"] = mask.copy()
    return infos
