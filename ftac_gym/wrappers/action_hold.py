"""Actions that are held for several control periods: by an environment, and by a policy."""

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import gymnasium as gym
import numpy as np
import numpy.typing as npt
from gymnasium.utils import RecordConstructorArgs
from gymnasium.vector import VectorEnv

from ftac_gym.utils.parameters import require, whole

Observation = npt.NDArray[np.float32]
BoolArray = npt.NDArray[np.bool_]


def held_steps(
    step: Callable[[Any], tuple[Any, ...]], action: npt.NDArray[Any], periods: int
) -> Iterator[tuple[BoolArray, tuple[Any, ...]]]:
    """Step an environment for several control periods with the same action.

    Spacecraft whose episode has ended get an action of zero for the rest of these periods.

    Parameters
    ----------
    step
        ``step`` of the environment, single or vector.
    action
        (k,) or (N, k).
    periods
        Number of control periods.

    Yields
    ------
    Whether the spacecraft (N,) are in the episode that the action was meant for, and the result of the step.
    """
    running = np.ones(np.shape(action)[:-1], dtype=np.bool_)
    for _ in range(periods):
        result = step(action)
        yield running, result
        running = running & ~np.logical_or(result[2], result[3])
        if not running.all():
            action = np.where(running[..., None], action, 0.0)


def held_decision(
    decide: Callable[[Any], tuple[npt.NDArray[Any], Any]], periods: int, state: Any, start: BoolArray
) -> tuple[npt.NDArray[Any], Any]:
    """Return the actions (N, k) of a policy that decides once in several control periods, and its state.

    Parameters
    ----------
    decide
        Function from the memory of the policy to the actions (N, k) and the next memory: None, or arrays
        (layers, N, size).
    periods
        Control periods from one decision to the next.
    state
        State at the previous control period; None at the first. It holds the control periods until the next decision
        and the action of each spacecraft, and the memory.
    start
        (N,) spacecraft at the start of an episode, which decide at once.
    """
    waiting, held, memory = state if state is not None else (np.zeros(len(start), dtype=np.int64), None, None)
    due = (waiting == 0) | start
    if held is None or due.any():
        decided, after = decide(memory)
        held = decided if held is None or due.all() else np.where(due[:, None], decided, held)
        if after is not None and memory is not None and not due.all():
            after = tuple(np.where(due[None, :, None], new, old) for new, old in zip(after, memory, strict=True))
        memory = after
    return held, (np.where(due, periods, waiting) - 1, held, memory)


def frame_rate_divided(metadata: Mapping[str, Any], periods: int) -> dict[str, Any]:
    """Return the metadata of an environment that shows a frame once in several control periods."""
    rate = {"render_fps": metadata["render_fps"] / periods} if "render_fps" in metadata else {}
    return {**metadata, **rate}


class ActionHold(gym.Wrapper[Observation, npt.NDArray[Any], Observation, npt.NDArray[Any]], RecordConstructorArgs):
    """Hold every action for several control periods, or to the end of the episode, and add up their rewards.

    Observation and info are those of the last of these periods. It goes outside of all other wrappers of this package,
    which run once per control period; a baseline that acts through it is refused at its second action. For vector
    environments see ``hold`` of :class:`~ftac_gym.wrappers.sb3.SB3VecEnv`. The frame rate ``metadata["render_fps"]`` is
    that of the actions.

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
        self.metadata = frame_rate_divided(env.metadata, self.steps)

    def step(self, action: npt.NDArray[Any]) -> tuple[Observation, Any, bool, bool, dict[str, Any]]:
        """Step the environment with the same action, several times."""
        total = 0.0
        for _, result in held_steps(self.env.step, action, self.steps):
            observation, reward, terminated, truncated, info = result
            total += float(reward)
            if terminated or truncated:
                break
        return observation, total, terminated, truncated, info
