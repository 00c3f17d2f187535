"""Transforms of actions and observations, and the wrappers that put them around single and vector environments."""

import functools
import inspect
from collections.abc import Callable
from typing import Any, ClassVar, ParamSpec

import gymnasium as gym
import numpy as np
import numpy.typing as npt
from gymnasium import spaces
from gymnasium.envs.registration import load_env_creator
from gymnasium.utils import RecordConstructorArgs
from gymnasium.vector import VectorEnv, VectorWrapper
from gymnasium.vector.utils import batch_space

from ftac_gym.baselines.clock import check_elapsed
from ftac_gym.task.measurement import Measurement
from ftac_gym.utils.parameters import FloatArray, real_numbers, require
from ftac_gym.wrappers.action_hold import ActionHold

Actions = npt.NDArray[Any]
BoolArray = npt.NDArray[np.bool_]
Info = dict[str, Any]
Observation = npt.NDArray[np.float32]


class Transform:
    """Change of the actions and observations of N spacecraft; this one changes nothing.

    A subclass overrides :meth:`command`, :meth:`observe` and :meth:`preview`, and sets its spaces. Its state starts
    anew for spacecraft whose clock stands at zero, whatever the autoreset mode: see :meth:`measure`. It runs once per
    control period, and refuses to run less often.

    Parameters
    ----------
    env
        An environment of this package, single or vector, wrapped or not.

    Raises
    ------
    ValueError
        If the environment is not of this package, its observations are no flat Box, or it holds its actions already;
        or if two transforms would act on the wheels.
    """

    acts: ClassVar[bool] = False
    """True for transforms of the agent's actions into commands to the wheels."""
    checks_time: ClassVar[bool] = True
    """False for transforms around a baseline, which checks the time itself."""
    information = "attitude"
    """Information tier of its inputs."""

    @property
    def estimator(self) -> Any:
        """An object with the fault estimates of the transform, as ``estimate``, and their ``information``; or None."""
        return None

    def __init__(self, env: Any) -> None:
        self.inner = env.unwrapped
        """Environment with the measurements."""
        known = callable(getattr(self.inner, "measurement", None))
        require(known, "env", "must be an environment of ftac_gym", env)
        several = isinstance(env, VectorEnv)
        self.num_spacecraft: int = env.num_envs if several else 1
        self._measured_at = np.full(self.num_spacecraft, np.nan)
        self.observation_space: Any = env.single_observation_space if several else env.observation_space
        """Observation space of one spacecraft, for the agent."""
        self.action_space: spaces.Space[Any] = env.single_action_space if several else env.action_space
        """Action space of one spacecraft, for the agent."""
        flat = isinstance(self.observation_space, spaces.Box) and len(self.observation_space.shape) == 1
        require(flat, "env", "must have a Box observation space with one axis", self.observation_space)
        layer = env
        while isinstance(layer, (gym.Wrapper, VectorWrapper)):
            rule = "must not hold its actions yet: ActionHold goes outside of all that runs once per control period"
            require(not isinstance(layer, ActionHold), "env", rule, env)
            taken = self.acts and getattr(getattr(layer, "transform", None), "acts", False)
            require(not taken, "env", "must take commands to the wheels: one wrapper can act on them", env)
            layer = layer.env

    def command(self, actions: Actions) -> Actions:
        """Return the actions to send on for the agent's actions (N, k)."""
        return actions

    def observe(self, observation: Observation, mask: BoolArray) -> Observation:
        """Return the agent's view of an observation (N, size), which is new for the spacecraft in the mask (N,)."""
        return observation

    def preview(self, observation: Observation, measurement: Measurement) -> Observation:
        """Return the agent's view of another observation (N, size) and measurement, without a change of state."""
        return observation

    def measure(self, mask: BoolArray, reset: Callable[[BoolArray], None], truth: bool = False) -> Measurement:
        """Return the present measurement, after a reset of the spacecraft in the mask whose episode starts with it.

        Parameters
        ----------
        mask
            (N,) spacecraft whose measurement is new.
        reset
            Function that resets the state of the spacecraft in a mask (N,).
        truth
            Whether to add the truth about the faults.

        Raises
        ------
        ValueError
            If more than a control period has passed since the last measurement: something inside skips steps.
        """
        measurement = self.inner.measurement(truth=truth)
        time = measurement.time
        started = mask & (time == 0.0)
        if self.checks_time:
            last = np.where(mask & ~started, self._measured_at, time)
            check_elapsed(type(self).__name__, time, last, self.inner.scenario.control_period)
            self._measured_at = np.where(mask, time, self._measured_at)
        if started.any():
            reset(started)
        return measurement

    def extend(self, low: FloatArray, high: FloatArray) -> None:
        """Add entries with these bounds (k,) to the observation space."""
        space = self.observation_space
        lowest = np.concatenate([space.low, low], dtype=np.float32)
        highest = np.concatenate([space.high, high], dtype=np.float32)
        self.observation_space = spaces.Box(lowest, highest, dtype=np.float32)


class TransformWrapper(gym.Wrapper[Observation, Actions, Observation, Actions], RecordConstructorArgs):
    """A single environment with a transform.

    Parameters
    ----------
    env
        An environment of this package.
    transform
        A class of transforms, or its path as ``"module:Class"``, as a specification holds it.
    **arguments
        Arguments of the transform.

    Raises
    ------
    ValueError
        If the transform refuses the environment or an argument.
    """

    def __init__(self, env: Any, transform: Callable[..., Transform] | str, **arguments: Any) -> None:
        kind: Any = load_env_creator(transform) if isinstance(transform, str) else transform
        RecordConstructorArgs.__init__(self, transform=f"{kind.__module__}:{kind.__qualname__}", **arguments)
        super().__init__(env)
        self.transform: Transform = kind(env, **arguments)
        self.information = self.transform.information
        self.observation_space = self.transform.observation_space
        self.action_space = self.transform.action_space
        self._all = np.ones(1, dtype=np.bool_)

    def __str__(self) -> str:
        """Return the names of the transform and of the layers inside."""
        return f"<{type(self.transform).__name__}{self.env}>"

    def reset(self, *, seed: int | None = None, options: Info | None = None) -> tuple[Observation, Info]:
        """Reset the environment and the transform."""
        observation, info = self.env.reset(seed=seed, options=options)
        return self.transform.observe(observation[None], self._all)[0], info

    def step(self, action: Actions) -> tuple[Observation, Any, bool, bool, Info]:
        """Step the environment through the transform.

        Raises
        ------
        ValueError
            If the action has the wrong shape, is not finite, or does not consist of real numbers.
        """
        action = np.asarray(action)
        if action.shape != self.action_space.shape:
            raise ValueError(f"action must have shape {self.action_space.shape}, got {action.shape}")
        action = real_numbers(action, "action")
        observation, *others = self.env.step(self.transform.command(action[None])[0])
        return (self.transform.observe(observation[None], self._all)[0], *others)


class VectorTransformWrapper(VectorWrapper[Observation, Actions, Observation, Actions, npt.NDArray[Any]]):
    """A vector environment with a transform, in every autoreset mode.

    Parameters
    ----------
    env
        A vector environment of this package.
    transform
        A class of transforms.
    **arguments
        Arguments of the transform.

    Raises
    ------
    ValueError
        If the transform refuses the environment or an argument.
    """

    def __init__(self, env: VectorEnv[Any, Any, Any], transform: Callable[..., Transform], **arguments: Any) -> None:
        super().__init__(env)
        self.transform = transform(env, **arguments)
        self.information = self.transform.information
        self.single_observation_space = self.transform.observation_space
        self.single_action_space = self.transform.action_space
        self.observation_space = batch_space(self.single_observation_space, env.num_envs)
        self.action_space = batch_space(self.single_action_space, env.num_envs)
        self._all = np.ones(env.num_envs, dtype=np.bool_)

    def reset(self, *, seed: Any = None, options: Info | None = None) -> tuple[Observation, Info]:
        """Reset the spacecraft, or those of a mask, and the transform's state of them."""
        observation, infos = self.env.reset(seed=seed, options=options)
        mask = (options or {}).get("reset_mask")
        return self.transform.observe(observation, self._all if mask is None else mask), infos

    def step(self, actions: Actions) -> tuple[Observation, Any, npt.NDArray[Any], npt.NDArray[Any], Info]:
        """Step the spacecraft through the transform.

        Raises
        ------
        ValueError
            If the actions have the wrong shape, are not finite, or do not consist of real numbers.
        """
        actions = np.asarray(actions)
        if actions.shape != self.action_space.shape:
            raise ValueError(f"actions must have shape {self.action_space.shape}, got {actions.shape}")
        command = self.transform.command(real_numbers(actions, "actions"))
        observation, reward, terminated, truncated, infos = self.env.step(command)
        if "final_obs" in infos:
            # The environment has reset these spacecraft already; the transform still holds the state of their episodes.
            ended, last = np.flatnonzero(infos["_final_obs"]), observation.copy()
            last[ended] = np.stack(infos["final_obs"][ended])
            seen = self.transform.preview(last, self.env.unwrapped.final_measurement)  # type: ignore[attr-defined]
            for spacecraft in ended:
                infos["final_obs"][spacecraft] = seen[spacecraft].copy()
        return self.transform.observe(observation, self._all), reward, terminated, truncated, infos


Arguments = ParamSpec("Arguments")


def wrapper(name: str, transform: Callable[Arguments, Transform]) -> Callable[Arguments, Any]:
    """Return the function that puts a transform around an environment, single or vector.

    It has the signature and the documentation of the transform.

    Parameters
    ----------
    name
        Name of the function.
    transform
        A class of transforms.
    """
    signature = inspect.signature(transform)

    def wrap(*args: Arguments.args, **kwargs: Arguments.kwargs) -> Any:
        bound = signature.bind(*args, **kwargs)
        arguments = dict(zip(signature.parameters, bound.args, strict=False)) | bound.kwargs
        kind = VectorTransformWrapper if isinstance(arguments["env"], VectorEnv) else TransformWrapper
        return kind(transform=transform, **arguments)

    functools.update_wrapper(wrap, transform, updated=())
    wrap.__name__ = wrap.__qualname__ = name
    return wrap
