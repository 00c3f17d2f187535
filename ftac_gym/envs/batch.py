"""What the single and the vector environment share: N craft, their episodes, observations and rewards."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium import spaces
from gymnasium.envs.registration import EnvSpec

from ftac_gym import scenarios
from ftac_gym.dynamics import Simulator
from ftac_gym.envs.observer import Observer
from ftac_gym.envs.reward import Reward
from ftac_gym.faults import FaultDistribution
from ftac_gym.task.episodes import Episodes
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, require
from ftac_gym.utils.randomness import keys_from_seeds
from ftac_gym.utils.serialization import to_plain

BoolArray = npt.NDArray[np.bool_]


def resolve_scenario(scenario: Scenario | Mapping[str, Any] | str | None, default: str, changes: Any) -> Scenario:
    """Turn what ``gym.make`` was given into a scenario.

    Parameters
    ----------
    scenario
        A scenario, its plain dict, its JSON text, its name, or None for the default.
    default
        Name of the default scenario.
    changes
        Fields to replace, by name.

    Raises
    ------
    ValueError
        If a name is unknown or a value breaks a rule.
    """
    if scenario is None:
        base = scenarios.get(default)
    elif isinstance(scenario, Scenario):
        base = scenario
    elif isinstance(scenario, Mapping):
        base = Scenario.from_dict(scenario)
    else:
        require(isinstance(scenario, str), "scenario", "must be a Scenario, its dict, JSON or name", scenario)
        base = Scenario.from_json(scenario) if scenario.lstrip().startswith("{") else scenarios.get(scenario)
    return base.replace(**changes) if changes else base


class SpacecraftBatch:
    """N craft with their episode counters.

    Parameters
    ----------
    scenario
        What to simulate; every wheel needs a torque limit, which scales the action.
    observation
        Information tier.
    num_spacecraft
        Number of craft.
    threads
        Threads of the simulator.

    Raises
    ------
    ValueError
        If a wheel has no torque limit or the tier is unknown.
    """

    def __init__(self, scenario: Scenario, observation: str, num_spacecraft: int, threads: int = 1) -> None:
        self.scenario = scenario
        self.simulator = Simulator(scenario, num_spacecraft, threads)
        self.observer = Observer(self.simulator, observation)
        self.reward = Reward(self.simulator)
        self.torque_limits = scenario.spacecraft.wheels.torque_limits
        limited = bool(np.isfinite(self.torque_limits).all())
        require(limited, "torque_limit", "must be finite for every wheel: it scales the action", self.torque_limits)
        self.horizon = scenario.horizon
        self.indices = np.arange(num_spacecraft)
        self._keys = np.zeros((num_spacecraft, 2), dtype=np.uint32)
        self._counter = np.zeros(num_spacecraft, dtype=np.int64)
        wheels = len(self.torque_limits)
        self._action_shape = (num_spacecraft, wheels)
        self._limits = np.tile(self.torque_limits, (num_spacecraft, 1))
        layout = self.observer.layout
        self.observation_space = spaces.Box(layout.low, layout.high, dtype=np.float32)
        self.action_space = spaces.Box(-1.0, 1.0, (wheels,), dtype=np.float32)

    def seed(self, craft: int, seed: int) -> None:
        """Let a craft start over with episode 0 of a seed at its next reset."""
        self._keys[craft] = keys_from_seeds([seed])[0]
        self._counter[craft] = 0

    def reset(
        self, craft: npt.NDArray[np.int64], observation: npt.NDArray[np.float32], episodes: Episodes | None
    ) -> None:
        """Start the next episode, or the given one, of the listed craft and write their rows of ``observation``."""
        if episodes is None:
            episodes = self.scenario.draw_from_keys(self._keys[craft], self._counter[craft])
            self._counter[craft] += 1
        mask = np.zeros(len(self.indices), dtype=np.bool_)
        mask[craft] = True
        self.simulator.reset(episodes, None if mask.all() else mask)
        self.observer.observe(craft, observation)
        self.reward.update(craft)

    def step(self, action: npt.ArrayLike) -> tuple[npt.NDArray[np.float32], FloatArray, BoolArray, BoolArray]:
        """Advance all craft by one control period.

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
            If the action has the wrong shape or is not finite.
        """
        fraction = np.asarray(action, dtype=np.float64)
        if fraction.shape != self._action_shape:
            raise ValueError(f"action must have shape {self._action_shape}, got {fraction.shape}")
        if not np.isfinite(fraction).all():
            raise ValueError(f"action must be finite, got {fraction!r}")
        simulator = self.simulator
        command = simulator.last_command
        np.minimum(fraction, 1.0, out=command)
        np.maximum(command, -1.0, out=command)
        np.multiply(command, self._limits, out=command)
        simulator.advance()
        observation = np.empty((len(self.indices), self.observer.layout.size), dtype=np.float32)
        self.observer.observe(self.indices, observation)
        terms, terminated = self.reward.update(self.indices)
        truncated = simulator.ticks >= self.horizon
        return observation, terms, terminated, truncated

    def measurement(self, truth: bool = False) -> Measurement:
        """Return what the craft measure now, and for an oracle what the faults do."""
        return self.simulator.measurement(truth)

    def facts(self) -> dict[str, FloatArray | BoolArray]:
        """Facts about the present moment of all craft, one array (N,) each; angles in degrees."""
        return {
            "time": self.simulator.time,
            "attitude_error": np.degrees(self.reward.attitude_error),
            "rate_error": np.degrees(self.reward.rate_error),
            "is_success": self.reward.success,
            "feasible": self.simulator.feasible.copy(),
        }


class BatchAccess:
    """What the single and the vector environment show of their batch."""

    batch: SpacecraftBatch
    _spec: EnvSpec | None = None

    @property
    def spec(self) -> EnvSpec | None:
        """The specification that makes this environment again; scenarios and their parts are kept as plain data."""
        return self._spec

    @spec.setter
    def spec(self, value: EnvSpec | None) -> None:
        if value is not None:
            value.kwargs = {name: to_plain(item) for name, item in value.kwargs.items()}
        self._spec = value

    @property
    def scenario(self) -> Scenario:
        """The scenario."""
        return self.batch.scenario

    @property
    def observation_slices(self) -> dict[str, slice]:
        """Where each named part of a craft's observation lies."""
        return dict(self.batch.observer.layout.slices)

    def set_severity(self, severity: float) -> None:
        """Set how bad the faults of the coming episodes are, in [0, 1]; running episodes are left as they are.

        A hook for curricula: ``env.unwrapped.set_severity(0.3)``, or ``env_method("set_severity", 0.3)`` of any
        Stable-Baselines3 vector environment. See :class:`~ftac_gym.faults.FaultDistribution`.

        Raises
        ------
        ValueError
            If the severity is not within [0, 1], or the scenario has no fault distribution.
        """
        faults = self.batch.scenario.faults
        if not isinstance(faults, FaultDistribution):
            raise ValueError(f"faults must be a FaultDistribution to have a severity, got {faults!r}")
        self.batch.scenario = self.batch.scenario.replace(faults=dataclasses.replace(faults, severity=severity))
        self.batch.simulator.scenario = self.batch.scenario

    def measurement(self, truth: bool = False) -> Measurement:
        """Return what the craft measure now, always with the craft on the first axis: the input of baselines.

        Parameters
        ----------
        truth
            Whether to add what the faults do; an oracle needs it, and nothing else may have it.
        """
        return self.batch.measurement(truth)


def requested_episodes(options: Mapping[str, Any] | None, known: tuple[str, ...]) -> Episodes | None:
    """Return the episodes that the options of a reset ask for, if any.

    Raises
    ------
    ValueError
        If an option is unknown, or the episodes are none.
    """
    for name in options or {}:
        require(name in known, "reset option", f"must be one of {list(known)}", name)
    episodes = (options or {}).get("episodes")
    valid = episodes is None or isinstance(episodes, Episodes)
    require(valid, 'options["episodes"]', "must be an Episodes object", episodes)
    return episodes
