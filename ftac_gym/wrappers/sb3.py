"""Adapter from vector environments of this package to Stable-Baselines3's ``VecEnv``."""

from collections.abc import Mapping, Sequence
from typing import Any

import gymnasium as gym
import numpy as np
import numpy.typing as npt
from gymnasium.vector import AutoresetMode, VectorEnv
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env import VecEnv
from stable_baselines3.common.vec_env.base_vec_env import VecEnvIndices, VecEnvStepReturn

from ftac_gym.task.episodes import Episodes
from ftac_gym.task.measurement import Measurement
from ftac_gym.utils.parameters import require, whole
from ftac_gym.wrappers.action_hold import frame_rate_divided, held_steps


class SB3VecEnv(VecEnv):
    """Adapter from a Gymnasium vector environment in same-step mode to Stable-Baselines3.

    At the end of an episode, the info of a spacecraft holds the entries of SB3: ``terminal_observation``,
    ``TimeLimit.truncated`` (truncated and not terminated), ``episode`` (return ``r`` and length ``l``, as of a Monitor)
    and the environment's final info with ``is_success``. At other steps the infos are empty, for speed. The frame rate
    ``metadata["render_fps"]`` is that of the actions.

    Parameters
    ----------
    env
        The vector environment, wrapped or not, made with ``autoreset_mode="SameStep"``.
    hold
        Control periods for which every action is held; the rewards of the periods are added up. A spacecraft whose
        episode ends while an action is held gets a zero action for the rest of the hold, whose rewards do not count.

    Raises
    ------
    ValueError
        If the environment resets in another mode or ``hold`` is not a positive integer.
    """

    def __init__(self, env: VectorEnv[Any, Any, Any], hold: int = 1) -> None:
        self.hold = whole(hold, 1, "hold")
        mode = env.metadata.get("autoreset_mode")
        require(mode is AutoresetMode.SAME_STEP, "autoreset_mode", "must be SameStep for Stable-Baselines3", mode)
        self.env = env
        super().__init__(env.num_envs, env.single_observation_space, env.single_action_space)
        self.metadata = {**frame_rate_divided(env.metadata, self.hold), **self.metadata}
        self._actions: npt.NDArray[Any] = np.zeros(())
        self._returns = np.zeros(self.num_envs)
        self._lengths = np.zeros(self.num_envs, dtype=np.int64)

    def measurement(self, truth: bool = False) -> Measurement:
        """Return the present measurement of the spacecraft, with the truth about the faults for an oracle."""
        return self.env.unwrapped.measurement(truth)  # type: ignore[attr-defined]

    def set_options(self, options: list[dict[str, Any]] | dict[str, Any] | None = None) -> None:
        """Set the options of the next reset.

        Parameters
        ----------
        options
            ``{"episodes": Episodes}`` for all spacecraft, with an episode for each; or one such dict per spacecraft,
            each with a single episode. None, or nothing but empty dicts, draws the episodes.

        Raises
        ------
        ValueError
            If an option is another one, or there is not one dict or one episode for each spacecraft.
        """
        together = options is None or isinstance(options, Mapping)
        listed = together or isinstance(options, (list, tuple))
        require(listed, "options", "must be a dict, or a list with one for each spacecraft", options)
        parts: list[Any] = [options or {}] if together else list(options or [])
        require(together or len(parts) == self.num_envs, "options", f"must be {self.num_envs} dicts", len(parts))
        for part in parts:
            require(isinstance(part, Mapping), "options", "must be a dict, or one for each spacecraft", part)
            for name in part:
                require(name == "episodes", "reset option", "must be 'episodes': VecEnv.reset resets all", name)
        given = [part["episodes"] for part in parts if part.get("episodes") is not None]
        for episodes in given:
            require(isinstance(episodes, Episodes), 'options["episodes"]', "must be an Episodes object", episodes)
            count = self.num_envs if together else 1
            require(len(episodes) == count, 'options["episodes"]', f"must be {count} here", len(episodes))
        require(len(given) in (0, len(parts)), 'options["episodes"]', "must be in all dicts or in none", len(given))
        self._options = [{"episodes": _joined(given)} if given else {}] * self.num_envs

    def reset(self) -> npt.NDArray[Any]:
        """Reset all spacecraft with the seeds and the options that were set."""
        seeds: Any = list(self._seeds) if any(seed is not None for seed in self._seeds) else None
        observation, infos = self.env.reset(seed=seeds, options=self._options[0])
        self._reset_seeds()
        self._reset_options()
        self.reset_infos = [_row(infos, spacecraft) for spacecraft in range(self.num_envs)]
        self._returns[:] = 0.0
        self._lengths[:] = 0
        return np.asarray(observation)

    def step_async(self, actions: npt.NDArray[Any]) -> None:
        """Store the actions."""
        self._actions = actions

    def step_wait(self) -> VecEnvStepReturn:
        """Step all spacecraft."""
        listed: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        done = np.zeros(self.num_envs, dtype=np.bool_)
        total = np.zeros(self.num_envs)
        for running, result in held_steps(self.env.step, self._actions, self.hold):
            observation, reward, terminated, truncated, infos = result
            total += np.where(running, reward, 0.0)
            self._lengths += running
            ended = (terminated | truncated) & running
            if ended.any():
                returns = self._returns + total
                for spacecraft in np.flatnonzero(ended).tolist():
                    listed[spacecraft] = {
                        **_row(infos["final_info"], spacecraft),
                        "terminal_observation": infos["final_obs"][spacecraft],
                        "TimeLimit.truncated": bool(truncated[spacecraft] and not terminated[spacecraft]),
                        "episode": {"r": float(returns[spacecraft]), "l": int(self._lengths[spacecraft])},
                    }
                done = done | ended
        self._returns = np.where(done, 0.0, self._returns + total)
        self._lengths[done] = 0
        return observation, total.astype(np.float32), done, listed

    def close(self) -> None:
        """Close the environment."""
        self.env.close()

    def get_attr(self, attr_name: str, indices: VecEnvIndices = None) -> list[Any]:
        """Return an attribute of the vector environment, once for each index: the spacecraft share it."""
        value = getattr(self.env.unwrapped, attr_name)
        return [value for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: VecEnvIndices = None) -> None:
        """Set an attribute of the vector environment, for all spacecraft."""
        self._require_all(indices)
        setattr(self.env.unwrapped, attr_name, value)

    def env_method(
        self, method_name: str, *method_args: Any, indices: VecEnvIndices = None, **method_kwargs: Any
    ) -> list[Any]:
        """Call a method of the vector environment once, for all spacecraft, and return its result for each of them."""
        self._require_all(indices)
        result = getattr(self.env.unwrapped, method_name)(*method_args, **method_kwargs)
        return [result for _ in self._get_indices(indices)]

    def env_is_wrapped(
        self, wrapper_class: type[gym.Wrapper[Any, Any, Any, Any]], indices: VecEnvIndices = None
    ) -> list[bool]:
        """Return whether the spacecraft are wrapped; the adapter records episodes as a Monitor does."""
        return [wrapper_class is Monitor for _ in self._get_indices(indices)]

    def get_images(self) -> Sequence[npt.NDArray[Any] | None]:
        """Return the rendered frames."""
        frames: Any = self.env.render()
        return list(frames) if frames is not None else [None] * self.num_envs

    def _require_all(self, indices: VecEnvIndices) -> None:
        """Refuse some spacecraft where only all of them can be meant."""
        complete = set(self._get_indices(indices)) == set(range(self.num_envs))
        require(complete, "indices", "must be None: the spacecraft share their attributes and methods", indices)


def _joined(parts: Sequence[Episodes]) -> Episodes:
    """Return the episodes of several objects of one scenario in one."""
    texts = {part.scenario_json for part in parts}
    require(len(texts) == 1, 'options["episodes"]', "must be drawn from one scenario", f"{len(texts)} scenarios")
    arrays = [part.arrays() for part in parts]
    joined: dict[str, Any] = {name: np.concatenate([part[name] for part in arrays]) for name in arrays[0]}
    return Episodes(parts[0].scenario_json, **joined)


def _row(infos: dict[str, Any], spacecraft: int) -> dict[str, Any]:
    """Return the info of one spacecraft from a vector environment's infos."""
    row = {}
    for name, values in infos.items():
        if not name.startswith("_") and infos.get(f"_{name}", np.ones(spacecraft + 1, dtype=np.bool_))[spacecraft]:
            value = _row(values, spacecraft) if isinstance(values, dict) else values[spacecraft]
            row[name] = value.item() if isinstance(value, np.generic) else value
    return row
