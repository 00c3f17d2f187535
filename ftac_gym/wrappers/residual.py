"""An agent that corrects a controller: action = clip(base + authority * residual)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import gymnasium as gym
import numpy as np
import numpy.typing as npt
from gymnasium import spaces
from gymnasium.utils import RecordConstructorArgs
from gymnasium.vector import VectorEnv, VectorWrapper
from gymnasium.vector.utils import batch_space

from ftac_gym import baselines
from ftac_gym.attitude import angle_between
from ftac_gym.baselines import Baseline, as_action
from ftac_gym.baselines.gyroscopic import GyroscopicModel
from ftac_gym.baselines.memory import Memory
from ftac_gym.baselines.observers.disturbance_observer import DisturbanceObserver
from ftac_gym.measurement import Measurement
from ftac_gym.parameters import FloatArray, finite, non_negative, positive, require
from ftac_gym.scenario import Scenario

Observation = npt.NDArray[np.float32]


SURPRISE_BANDWIDTH = 4.5
"""Bandwidth of what is expected of the torque on the body [rad/s]."""

SURPRISE_ANGLE = 0.01
"""Pointing error [rad] beyond which nothing is a surprise: a slew with an uncertain inertia is full of them."""


@dataclass(frozen=True)
class Fade:
    """How the authority shrinks near the target: in proportion to the error below ``angle`` [rad], to ``floor``.

    A torque on the body that differs from what it was opens it all the same, fully at ``surprise`` [N m]; None never.
    """

    angle: float
    floor: float
    surprise: float | None = None


class Surprise:
    """How far the torque on the body, beyond model and commands, is from what it was of late.

    Parameters
    ----------
    scenario
        The task; its nominal parameters are the model.
    num_craft
        Number of craft N.
    """

    def __init__(self, scenario: Scenario, num_craft: int) -> None:
        self._memory = Memory(num_craft)
        gyroscopic = GyroscopicModel(scenario, telemetry=False)
        self._observer = DisturbanceObserver(scenario, self._memory, SURPRISE_BANDWIDTH, gyroscopic)
        self._share = 1.0 - math.exp(-SURPRISE_BANDWIDTH * scenario.control_period)
        self.torque = np.zeros(num_craft)
        """(N,) magnitude of the difference at the last measurement [N m]."""

    def update(self, measurement: Measurement, mask: npt.NDArray[np.bool_]) -> None:
        """Take in a measurement for the craft in the mask (N,); those at time zero start anew."""
        self._memory.reset(mask & (measurement.time == 0.0))
        before, expected = self._memory.copy(), self._observer.disturbance
        change = (self._observer.update(measurement) - expected) / self._share
        self._memory.restore(before, ~mask)
        self.torque = np.where(mask, np.sqrt(np.einsum("ni,ni->n", change, change)), self.torque)


class _Base:
    """The base controller of N craft, its present action, and how a residual changes it."""

    def __init__(
        self, env: Any, num_craft: int, base: str, authority: float, fade: Fade | None, gains: dict[str, Any]
    ) -> None:
        inner = env.unwrapped
        known = callable(getattr(inner, "measurement", None))
        require(known, "env", "must be an environment of ftac_gym", env)
        require(0.0 < finite(authority, "authority") <= 2.0, "authority", "must be above 0 and at most 2", authority)
        self._full_authority = authority
        self._fade = fade
        self._authority = np.full((num_craft, 1), authority)
        self._env = inner
        watching = fade is not None and fade.surprise is not None
        self._surprise = Surprise(inner.scenario, num_craft) if watching else None
        self._limits = inner.scenario.spacecraft.wheels.torque_limits
        self.baseline: Baseline = baselines.make(base, inner.scenario, num_craft, **gains)
        blind = self.baseline.information != "oracle"
        require(blind, "base", "must not be an oracle: an agent would act on what no craft can know", base)
        self.action = np.zeros((num_craft, len(self._limits)))

    def update(self) -> None:
        """Act on the present measurement; craft at time zero have just been reset."""
        measurement = self._env.measurement()
        if (measurement.time == 0.0).any():
            self.baseline.reset(measurement.time == 0.0)
        self.action = as_action(self.baseline.act(measurement), self._limits)
        self._authority = self._authority_at(measurement, np.ones(len(measurement), dtype=np.bool_))

    def _authority_at(self, measurement: Measurement, mask: npt.NDArray[np.bool_]) -> FloatArray:
        """Return the authority (N, 1) of the residual at a measurement, which is new for the craft in the mask."""
        share = np.ones(len(measurement))
        if self._fade is not None:
            angle = np.atleast_1d(angle_between(measurement.attitude, measurement.reference_attitude))
            share = np.clip(angle / self._fade.angle, self._fade.floor, 1.0)
            if self._surprise is not None and self._fade.surprise is not None:
                self._surprise.update(measurement, mask)
                opened = np.minimum(self._surprise.torque / self._fade.surprise, 1.0)
                share = np.where(angle < SURPRISE_ANGLE, np.maximum(share, opened), share)
        authority: FloatArray = self._full_authority * share[:, None]
        return authority

    def restart(self, mask: npt.NDArray[np.bool_]) -> None:
        """Reset and act for the craft in the mask (N,) alone; the others have acted on this measurement already."""
        self.baseline.reset(mask)
        measurement = self._env.measurement()
        command = self.baseline.act_only(measurement, mask)
        self.action = np.where(mask[:, None], as_action(command, self._limits), self.action)
        self._authority = self._authority_at(measurement, mask)

    def preview(self, measurement: Measurement) -> FloatArray:
        """Return the action for another measurement without moving on."""
        nobody = np.zeros(len(measurement), dtype=np.bool_)
        return as_action(self.baseline.act_only(measurement, nobody), self._limits)

    def combine(self, residual: npt.ArrayLike) -> FloatArray:
        """Return the action that the environment shall take."""
        total: FloatArray = np.clip(self.action + self._authority * np.asarray(residual, dtype=np.float64), -1.0, 1.0)
        return total


def _fade(angle: float, floor: float, surprise: float | None) -> Fade | None:
    non_negative(angle, "fade_angle")
    require(0.0 <= floor <= 1.0, "fade_floor", "must be within [0, 1]", floor)
    if surprise is not None:
        require(angle > 0.0, "fade_angle", "must be positive where a surprise opens the authority", angle)
        positive(surprise, "surprise")
    return Fade(angle, floor, surprise) if angle > 0.0 else None


def _extended(space: spaces.Space[Any], wheels: int) -> Any:
    if not isinstance(space, spaces.Box):
        raise ValueError(f"env must have a Box observation space, got {space!r}")
    one = np.ones(wheels, dtype=np.float32)
    return spaces.Box(np.concatenate([space.low, -one]), np.concatenate([space.high, one]), dtype=np.float32)


class ResidualPolicy(gym.Wrapper[Observation, npt.NDArray[Any], Observation, npt.NDArray[Any]], RecordConstructorArgs):
    """Let the agent correct a baseline.

    The action sent on is ``clip(base + authority * residual, -1, 1)``, per wheel and over its limit; the base action of
    the present measurement is appended to the observation. A residual of zero is the base, bit for bit. Given a vector
    environment, the constructor returns a :class:`VectorResidualPolicy`.

    Parameters
    ----------
    env
        An environment of this package, single or vector.
    base
        Name of the baseline.
    authority
        Share of the torque limit that a residual of one is worth, in (0, 2].
    fade_angle
        Below this measured pointing error [rad] the authority shrinks in proportion to the error, so that fine pointing
        is left to the base; zero never shrinks it.
    fade_floor
        Share of the authority that is always kept, in [0, 1].
    surprise
        Near the target, where the authority has shrunk, a sudden torque on the body [N m], beyond model and commands,
        opens it again for a moment, in proportion and fully at this value: the agent can answer the onset of a fault,
        and noise in between costs nothing. None never opens it.
    **gains
        Gains of the baseline.

    Raises
    ------
    ValueError
        If the environment is not of this package, or a name, a gain or the authority is refused.
    """

    def __new__(cls, *args: Any, **kwargs: Any) -> Any:
        """Return the wrapper that fits the environment."""
        env = args[0] if args else kwargs.get("env")
        if isinstance(env, VectorEnv):
            return VectorResidualPolicy(*args, **kwargs)
        return super().__new__(cls)

    def __init__(
        self,
        env: Any,
        base: str = "pd_dob",
        authority: float = 0.5,
        fade_angle: float = 0.0,
        fade_floor: float = 0.0,
        surprise: float | None = None,
        **gains: Any,
    ) -> None:
        RecordConstructorArgs.__init__(
            self,
            base=base,
            authority=authority,
            fade_angle=fade_angle,
            fade_floor=fade_floor,
            surprise=surprise,
            **gains,
        )
        super().__init__(env)
        self.base = _Base(env, 1, base, authority, _fade(fade_angle, fade_floor, surprise), gains)
        self.observation_space = _extended(env.observation_space, self.base.action.shape[1])

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Reset the environment and the base."""
        observation, info = self.env.reset(seed=seed, options=options)
        self.base.update()
        return self._extend(observation), info

    def step(self, action: npt.NDArray[Any]) -> tuple[Observation, Any, bool, bool, dict[str, Any]]:
        """Correct the base action by the residual and step."""
        residual = np.asarray(action)
        if residual.shape != self.base.action.shape[1:]:
            raise ValueError(f"action must have shape {self.base.action.shape[1:]}, got {residual.shape}")
        observation, reward, terminated, truncated, info = self.env.step(self.base.combine(residual)[0])
        self.base.update()
        return self._extend(observation), reward, terminated, truncated, info

    def _extend(self, observation: Observation) -> Observation:
        return np.concatenate([observation, self.base.action[0]], dtype=np.float32)


class VectorResidualPolicy(
    VectorWrapper[Observation, npt.NDArray[Any], Observation, npt.NDArray[Any], npt.NDArray[Any]]
):
    """:class:`ResidualPolicy` for N craft; every craft's base is reset with its episode."""

    def __init__(
        self,
        env: VectorEnv[Any, Any, Any],
        base: str = "pd_dob",
        authority: float = 0.5,
        fade_angle: float = 0.0,
        fade_floor: float = 0.0,
        surprise: float | None = None,
        **gains: Any,
    ) -> None:
        super().__init__(env)
        self.base = _Base(env, env.num_envs, base, authority, _fade(fade_angle, fade_floor, surprise), gains)
        self.single_observation_space = _extended(env.single_observation_space, self.base.action.shape[1])
        self.observation_space = batch_space(self.single_observation_space, env.num_envs)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Reset the craft and their bases."""
        observation, infos = self.env.reset(seed=seed, options=options)
        mask = (options or {}).get("reset_mask")
        if mask is None:
            self.base.update()
        else:
            self.base.restart(mask)
        return self._extend(observation, self.base.action), infos

    def step(
        self, actions: npt.NDArray[Any]
    ) -> tuple[Observation, npt.NDArray[Any], npt.NDArray[Any], npt.NDArray[Any], dict[str, Any]]:
        """Correct the base actions by the residuals and step."""
        residual = np.asarray(actions)
        if residual.shape != self.base.action.shape:
            raise ValueError(f"actions must have shape {self.base.action.shape}, got {residual.shape}")
        observation, reward, terminated, truncated, infos = self.env.step(self.base.combine(residual))
        if "final_obs" in infos:
            # In same-step mode the craft that ended have been reset; their last observation needs its base action too.
            final_action = self.base.preview(self.env.unwrapped.final_measurement)  # type: ignore[attr-defined]
            for craft in np.flatnonzero(infos["_final_obs"]):
                last = infos["final_obs"][craft]
                infos["final_obs"][craft] = np.concatenate([last, final_action[craft]], dtype=np.float32)
        self.base.update()
        return self._extend(observation, self.base.action), reward, terminated, truncated, infos

    def _extend(self, observation: Observation, action: FloatArray) -> Observation:
        return np.concatenate([observation, action], axis=1, dtype=np.float32)
