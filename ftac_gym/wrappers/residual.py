"""An agent that corrects a controller: action = clip(base + authority * residual)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ftac_gym import baselines
from ftac_gym.attitude import angle_between
from ftac_gym.baselines import Baseline, as_action
from ftac_gym.baselines.components.gyroscopic import GyroscopicModel
from ftac_gym.baselines.memory import Memory
from ftac_gym.baselines.observers.disturbance_observer import DisturbanceObserver
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, finite, non_negative, positive, require
from ftac_gym.wrappers.stage import BoolArray, Observation, Stage, StageWrapper, VectorStageWrapper

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
    num_spacecraft
        Number of craft N.
    """

    def __init__(self, scenario: Scenario, num_spacecraft: int) -> None:
        self._memory = Memory(num_spacecraft)
        gyroscopic = GyroscopicModel(scenario, telemetry=False)
        self._observer = DisturbanceObserver(scenario, self._memory, SURPRISE_BANDWIDTH, gyroscopic)
        self._share = 1.0 - math.exp(-SURPRISE_BANDWIDTH * scenario.control_period)
        self.torque = np.zeros(num_spacecraft)
        """(N,) magnitude of the difference at the last measurement [N m]."""

    def update(self, measurement: Measurement, mask: BoolArray) -> None:
        """Take in a measurement for the craft in the mask (N,); those at time zero start anew."""
        self._memory.reset(mask & (measurement.time == 0.0))
        before, expected = self._memory.copy(), self._observer.disturbance
        change = (self._observer.update(measurement) - expected) / self._share
        self._memory.restore(before, ~mask)
        self.torque = np.where(mask, np.sqrt(np.einsum("ni,ni->n", change, change)), self.torque)


class _ResidualStage(Stage):
    """The base controller of N craft, its present action, and how a residual changes it."""

    acts = True

    def __init__(
        self,
        env: Any,
        base: baselines.BaselineLike = "pd_dob",
        authority: float = 0.5,
        fade_angle: float = 0.0,
        fade_floor: float = 0.0,
        surprise: float | None = None,
        **gains: Any,
    ) -> None:
        super().__init__(env)
        require(0.0 < finite(authority, "authority") <= 2.0, "authority", "must be above 0 and at most 2", authority)
        self._full_authority = authority
        self._fade = _fade(fade_angle, fade_floor, surprise)
        self._authority = np.full((self.num_spacecraft, 1), authority)
        scenario = self.inner.scenario
        self._surprise = Surprise(scenario, self.num_spacecraft) if surprise is not None else None
        self._limits = scenario.spacecraft.wheels.torque_limits
        self.baseline = blind_base(base, scenario, self.num_spacecraft, gains)
        self.action = np.zeros((self.num_spacecraft, len(self._limits)))
        """(N, wheels) action of the base at the present measurement."""
        one = np.ones(len(self._limits))
        self.extend(-one, one)

    @property
    def information(self) -> str:
        """The tier of information that the base uses."""
        return self.baseline.information

    def command(self, actions: npt.NDArray[Any]) -> FloatArray:
        """Return the base actions corrected by the residuals (N, wheels)."""
        residual = np.asarray(actions, dtype=np.float64)
        total: FloatArray = np.clip(self.action + self._authority * residual, -1.0, 1.0)
        return total

    def observe(self, observation: Observation, mask: BoolArray) -> Observation:
        """Let the base act on the present measurement, for the craft in the mask (N,), and show what it does."""
        measurement = self.inner.measurement()
        started = self.started(measurement, mask)
        if started.any():
            self.baseline.reset(started)
        command = self.baseline.act(measurement) if mask.all() else self.baseline.act_only(measurement, mask)
        self.action = np.where(mask[:, None], as_action(command, self._limits), self.action)
        self._authority = self._authority_at(measurement, mask)
        return np.concatenate([observation, self.action], axis=1, dtype=np.float32)

    def preview(self, observation: Observation, measurement: Measurement) -> Observation:
        """Show what the base would do at another measurement."""
        nobody = np.zeros(self.num_spacecraft, dtype=np.bool_)
        action = as_action(self.baseline.act_only(measurement, nobody), self._limits)
        return np.concatenate([observation, action], axis=1, dtype=np.float32)

    def _authority_at(self, measurement: Measurement, mask: BoolArray) -> FloatArray:
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


def blind_base(
    name: baselines.BaselineLike, scenario: Scenario, num_spacecraft: int, gains: dict[str, Any]
) -> Baseline:
    """Build a baseline that knows no more than a craft can.

    Raises
    ------
    ValueError
        If the baseline is an oracle, or its name or a gain is refused.
    """
    baseline = baselines.make(name, scenario, num_spacecraft, **gains)
    blind = baseline.information != "oracle"
    require(blind, "base", "must not be an oracle: an agent would act on what no craft can know", name)
    return baseline


def _fade(angle: float, floor: float, surprise: float | None) -> Fade | None:
    non_negative(angle, "fade_angle")
    require(0.0 <= floor <= 1.0, "fade_floor", "must be within [0, 1]", floor)
    if surprise is not None:
        require(angle > 0.0, "fade_angle", "must be positive where a surprise opens the authority", angle)
        positive(surprise, "surprise")
    return Fade(angle, floor, surprise) if angle > 0.0 else None


class VectorResidualPolicy(VectorStageWrapper):
    """:class:`ResidualPolicy` for N craft; every craft's base is reset with its episode."""

    stage_type = _ResidualStage
    stage: _ResidualStage

    @property
    def base(self) -> _ResidualStage:
        """The base and what it does."""
        return self.stage


class ResidualPolicy(StageWrapper):
    """Let the agent correct a baseline.

    The action sent on is ``clip(base + authority * residual, -1, 1)``, per wheel and over its limit; the base action of
    the present measurement is appended to the observation. A residual of zero is the base, bit for bit. Given a vector
    environment, the constructor returns a :class:`VectorResidualPolicy`.

    Parameters
    ----------
    env
        An environment of this package, single or vector.
    base
        Name of the baseline; for a law of your own its class, or where that is, as ``"module:Class"``.
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

    vector_type = VectorResidualPolicy
    stage: _ResidualStage

    def __init__(
        self,
        env: Any,
        base: baselines.BaselineLike = "pd_dob",
        authority: float = 0.5,
        fade_angle: float = 0.0,
        fade_floor: float = 0.0,
        surprise: float | None = None,
        **gains: Any,
    ) -> None:
        super().__init__(
            env,
            base=base,
            authority=authority,
            fade_angle=fade_angle,
            fade_floor=fade_floor,
            surprise=surprise,
            **gains,
        )

    @property
    def base(self) -> _ResidualStage:
        """The base and what it does."""
        return self.stage
