"""What a wrapper of this package is made of: one stage between agent and environment, for one craft as for many."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, ClassVar

import gymnasium as gym
import numpy as np
import numpy.typing as npt
from gymnasium import spaces
from gymnasium.utils import RecordConstructorArgs
from gymnasium.vector import VectorEnv, VectorWrapper
from gymnasium.vector.utils import batch_space

from ftac_gym.task.measurement import Measurement
from ftac_gym.utils.parameters import FloatArray, require
from ftac_gym.wrappers.action_hold import ActionHold

BoolArray = npt.NDArray[np.bool_]
Observation = npt.NDArray[np.float32]


class Stage:
    """What a wrapper does to the actions and observations of N craft; this one does nothing.

    A subclass says what it does in :meth:`command`, :meth:`observe` and :meth:`preview`, and sets its spaces. It starts
    anew for craft whose clock stands at zero, whatever the autoreset mode: see :meth:`started`.

    Parameters
    ----------
    env
        An environment of this package, single or vector, wrapped or not.

    Raises
    ------
    ValueError
        If the environment is not of this package, its observations are no flat Box, it holds its actions already, or
        two stages would act on the wheels.
    """

    acts: ClassVar[bool] = False
    """Whether it turns the agent's actions into commands to the wheels."""

    def __init__(self, env: Any) -> None:
        self.inner = env.unwrapped
        """The environment that measures."""
        known = callable(getattr(self.inner, "measurement", None))
        require(known, "env", "must be an environment of ftac_gym", env)
        several = isinstance(env, VectorEnv)
        space = env.single_observation_space if several else env.observation_space
        flat = isinstance(space, spaces.Box) and len(space.shape) == 1
        require(flat, "env", "must have a Box observation space with one axis", space)
        for layer in _layers(env):
            rule = "must not hold its actions yet: ActionHold goes outside of all that runs once per control period"
            require(not isinstance(layer, ActionHold), "env", rule, env)
            taken = self.acts and getattr(layer, "acts", False)
            require(not taken, "env", "must take commands to the wheels: one wrapper can act on them", env)
        self.num_spacecraft: int = env.num_envs if several else 1
        self.observation_space: Any = space
        """Of one craft, as the agent sees it."""
        self.action_space: spaces.Space[Any] = env.single_action_space if several else env.action_space
        """Of one craft, for the agent."""

    @property
    def information(self) -> str:
        """The tier of information that it tells or uses."""
        return "attitude"

    def command(self, actions: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """Return what to send on for the agent's actions (N, k)."""
        return actions

    def observe(self, observation: Observation, mask: BoolArray) -> Observation:
        """Take in an observation (N, size), new for the craft in the mask (N,), and return what the agent sees."""
        return observation

    def preview(self, observation: Observation, measurement: Measurement) -> Observation:
        """Return what the agent would see of another observation (N, size) and measurement, without moving on."""
        return observation

    def started(self, measurement: Measurement, mask: BoolArray) -> BoolArray:
        """Return which craft (N,) of the mask are at the start of an episode."""
        started: BoolArray = mask & (measurement.time == 0.0)
        return started

    def extend(self, low: FloatArray, high: FloatArray) -> None:
        """Let the observation have further entries with these bounds (k,)."""
        space = self.observation_space
        lowest = np.concatenate([space.low, low], dtype=np.float32)
        highest = np.concatenate([space.high, high], dtype=np.float32)
        self.observation_space = spaces.Box(lowest, highest, dtype=np.float32)


class _Staged:
    """What single and vector wrappers show of their stage."""

    stage: Stage

    @property
    def acts(self) -> bool:
        """Whether it turns the agent's actions into commands to the wheels."""
        return self.stage.acts

    @property
    def information(self) -> str:
        """The tier of information that it tells or uses."""
        return self.stage.information


class StageWrapper(
    _Staged, gym.Wrapper[Observation, npt.NDArray[Any], Observation, npt.NDArray[Any]], RecordConstructorArgs
):
    """A single environment behind a stage. Given a vector environment, the constructor returns a ``vector_type``.

    Parameters
    ----------
    env
        An environment of this package.
    **arguments
        Those of the stage.

    Raises
    ------
    ValueError
        If the stage refuses the environment or an argument.
    """

    vector_type: ClassVar[type[VectorStageWrapper]]

    def __new__(cls, *args: Any, **kwargs: Any) -> Any:
        """Return the wrapper that fits the environment."""
        env = args[0] if args else kwargs.get("env")
        if isinstance(env, VectorEnv):
            return cls.vector_type(*args, **kwargs)
        return super().__new__(cls)

    def __init__(self, env: Any, **arguments: Any) -> None:
        RecordConstructorArgs.__init__(self, **arguments)
        super().__init__(env)
        self.stage = self.vector_type.stage_type(env, **arguments)
        self.observation_space = self.stage.observation_space
        self.action_space = self.stage.action_space
        self._everyone = np.ones(1, dtype=np.bool_)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Reset the environment and the stage."""
        observation, info = self.env.reset(seed=seed, options=options)
        return self.stage.observe(observation[None], self._everyone)[0], info

    def step(self, action: npt.NDArray[Any]) -> tuple[Observation, Any, bool, bool, dict[str, Any]]:
        """Step the environment through the stage.

        Raises
        ------
        ValueError
            If the action has the wrong shape or is not finite.
        """
        action = np.asarray(action)
        if action.shape != self.action_space.shape:
            raise ValueError(f"action must have shape {self.action_space.shape}, got {action.shape}")
        observation, *others = self.env.step(self.stage.command(action[None])[0])
        return (self.stage.observe(observation[None], self._everyone)[0], *others)


class VectorStageWrapper(
    _Staged, VectorWrapper[Observation, npt.NDArray[Any], Observation, npt.NDArray[Any], npt.NDArray[Any]]
):
    """A vector environment behind a stage, in every autoreset mode.

    Parameters
    ----------
    env
        A vector environment of this package.
    *args, **kwargs
        Those of the stage.

    Raises
    ------
    ValueError
        If the stage refuses the environment or an argument.
    """

    stage_type: ClassVar[type[Stage]]

    def __init__(self, env: VectorEnv[Any, Any, Any], *args: Any, **kwargs: Any) -> None:
        super().__init__(env)
        self.stage = self.stage_type(env, *args, **kwargs)
        self.single_observation_space = self.stage.observation_space
        self.single_action_space = self.stage.action_space
        self.observation_space = batch_space(self.single_observation_space, env.num_envs)
        self.action_space = batch_space(self.single_action_space, env.num_envs)
        self._everyone = np.ones(env.num_envs, dtype=np.bool_)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Reset the craft, or those of a mask, and what the stage remembers of them."""
        observation, infos = self.env.reset(seed=seed, options=options)
        mask = (options or {}).get("reset_mask")
        return self.stage.observe(observation, self._everyone if mask is None else mask), infos

    def step(
        self, actions: npt.NDArray[Any]
    ) -> tuple[Observation, npt.NDArray[Any], npt.NDArray[Any], npt.NDArray[Any], dict[str, Any]]:
        """Step the craft through the stage.

        Raises
        ------
        ValueError
            If the actions have the wrong shape or are not finite.
        """
        actions = np.asarray(actions)
        if actions.shape != self.action_space.shape:
            raise ValueError(f"actions must have shape {self.action_space.shape}, got {actions.shape}")
        observation, reward, terminated, truncated, infos = self.env.step(self.stage.command(actions))
        if "final_obs" in infos:
            self._complete(infos["final_obs"], np.flatnonzero(infos["_final_obs"]), observation)
        return self.stage.observe(observation, self._everyone), reward, terminated, truncated, infos

    def _complete(self, final: npt.NDArray[Any], ended: npt.NDArray[np.intp], observation: Observation) -> None:
        """Show the last observations of the craft that ended as the agent shall see them (same-step mode)."""
        # Those craft have been reset already, but the stage has not seen it yet: it still remembers their episodes.
        last = observation.copy()
        for craft in ended:
            last[craft] = final[craft]
        seen = self.stage.preview(last, self.env.unwrapped.final_measurement)  # type: ignore[attr-defined]
        for craft in ended:
            final[craft] = seen[craft].copy()


def _layers(env: Any) -> Iterator[Any]:
    """Yield the wrappers around an environment, the outermost first."""
    while isinstance(env, (gym.Wrapper, VectorWrapper)):
        yield env
        env = env.env
