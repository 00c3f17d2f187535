"""Corrections of a baseline by an agent: action = clip(base + authority * residual)."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ftac_gym import baselines
from ftac_gym.attitude import angle_between
from ftac_gym.baselines import as_action
from ftac_gym.baselines.components.gyroscopic import GyroscopicModel
from ftac_gym.baselines.memory import Memory
from ftac_gym.baselines.observers.disturbance_observer import DisturbanceObserver
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, finite, non_negative, positive, require
from ftac_gym.wrappers.transform import BoolArray, Observation, Transform, wrapper

TORQUE_BANDWIDTH = 4.5
"""Bandwidth of the torque on the body that the model is expected to leave [rad/s]."""

TORQUE_ANGLE = 0.01
"""Pointing error [rad] above which unmodelled torque has no effect: an uncertain inertia causes it in every slew."""


@dataclass(frozen=True)
class AuthorityProfile:
    """Authority of a residual over the pointing error.

    Parameters
    ----------
    authority
        Share of the torque limit for a residual of one, in (0, 2].
    authority_angle
        Pointing error [rad] below which the authority is proportional to the error; zero for a constant authority.
    authority_floor
        Least share of the authority, in [0, 1].
    torque_threshold
        Unmodelled torque [N m] that restores the whole authority near the target; None for no such effect.

    Raises
    ------
    ValueError
        If a value is out of its range.
    """

    authority: float
    authority_angle: float = 0.0
    authority_floor: float = 0.0
    torque_threshold: float | None = None

    def __post_init__(self) -> None:
        """Check the values."""
        bounded = 0.0 < finite(self.authority, "authority") <= 2.0
        require(bounded, "authority", "must be above 0 and at most 2", self.authority)
        non_negative(self.authority_angle, "authority_angle")
        bounded = 0.0 <= self.authority_floor <= 1.0
        require(bounded, "authority_floor", "must be within [0, 1]", self.authority_floor)
        if self.torque_threshold is not None:
            rule = "must be positive where an unmodelled torque opens the authority"
            require(self.authority_angle > 0.0, "authority_angle", rule, self.authority_angle)
            positive(self.torque_threshold, "torque_threshold")

    def at(self, angle: FloatArray, torque: FloatArray) -> FloatArray:
        """Return the authority (N,) at pointing errors (N,) [rad] and unmodelled torques (N,) [N m]."""
        if self.authority_angle == 0.0:
            return np.full(len(angle), self.authority)
        share = np.clip(angle / self.authority_angle, self.authority_floor, 1.0)
        if self.torque_threshold is not None:
            opened = np.minimum(torque / self.torque_threshold, 1.0)
            share = np.where(angle < TORQUE_ANGLE, np.maximum(share, opened), share)
        return self.authority * share


class UnmodelledTorque:
    """Change of the torque on the body that neither the model nor the commands explain.

    Parameters
    ----------
    scenario
        The task; its nominal parameters are the model.
    num_spacecraft
        Number of spacecraft N.
    """

    def __init__(self, scenario: Scenario, num_spacecraft: int) -> None:
        self._memory = Memory(num_spacecraft)
        gyroscopic = GyroscopicModel(scenario, telemetry=False)
        self._observer = DisturbanceObserver(scenario, self._memory, TORQUE_BANDWIDTH, gyroscopic)
        self._share = 1.0 - math.exp(-TORQUE_BANDWIDTH * scenario.control_period)
        self.torque = np.zeros(num_spacecraft)
        """(N,) magnitude of the change at the last measurement [N m]."""

    def update(self, measurement: Measurement, mask: BoolArray) -> None:
        """Process a measurement for the spacecraft in the mask (N,); those at time zero start anew."""
        self._memory.reset(mask & (measurement.time == 0.0))
        before, expected = self._memory.copy(), self._observer.disturbance
        change = (self._observer.update(measurement) - expected) / self._share
        self._memory.restore(before, ~mask)
        self.torque = np.where(mask, np.sqrt(np.einsum("ni,ni->n", change, change)), self.torque)


class BaseTransform(Transform):
    """Transform through which the agent acts on a baseline.

    Parameters
    ----------
    env
        An environment of this package, single or vector.
    base
        Name of the baseline, a custom class, or its path as ``"module:Class"``.
    gains
        Gains of the baseline.

    Raises
    ------
    TypeError
        If a gain is unknown.
    ValueError
        If the environment is not of this package, the baseline is an oracle, or its name or a gain is refused.
    """

    acts = True
    checks_time = False

    def __init__(self, env: Any, base: baselines.BaselineLike, gains: Mapping[str, Any]) -> None:
        super().__init__(env)
        scenario = self.inner.scenario
        self.baseline = baselines.make(base, scenario, self.num_spacecraft, **gains)
        self.information = self.baseline.information
        rule = "must not be an oracle: no spacecraft can measure the inputs of the agent's actions"
        require(self.information != "oracle", "base", rule, base)
        self._limits = scenario.spacecraft.wheels.torque_limits

    @property
    def estimator(self) -> baselines.Baseline:
        """The source of fault estimates: the baseline."""
        return self.baseline


class Residual(BaseTransform):
    """Let the agent correct a baseline.

    The action sent on is ``clip(base + authority * residual, -1, 1)``, per wheel and over its limit; the base action of
    the present measurement is appended to the observation. A residual of zero is the base, bit for bit.

    Parameters
    ----------
    env
        An environment of this package, single or vector.
    base
        Name of the baseline, a custom class, or its path as ``"module:Class"``.
    authority
        Share of the torque limit for a residual of one, in (0, 2].
    authority_angle
        Below this measured pointing error [rad] the authority is proportional to the error, so that fine pointing is
        left to the base; zero for a constant authority.
    authority_floor
        Least share of the authority, in [0, 1].
    torque_threshold
        Unmodelled torque [N m] that restores the whole authority near the target for a moment; smaller ones restore
        less, in proportion. The agent can answer the onset of a fault, and noise in between costs nothing. None for no
        such effect.
    **gains
        Gains of the baseline.

    Raises
    ------
    TypeError
        If a gain is unknown.
    ValueError
        If the environment is not of this package, or a name, a gain or the authority is refused.
    """

    def __init__(
        self,
        env: Any,
        base: baselines.BaselineLike = "pd_dob",
        authority: float = 0.5,
        authority_angle: float = 0.0,
        authority_floor: float = 0.0,
        torque_threshold: float | None = None,
        **gains: Any,
    ) -> None:
        super().__init__(env, base, gains)
        self._profile = AuthorityProfile(authority, authority_angle, authority_floor, torque_threshold)
        self._authority = np.full((self.num_spacecraft, 1), authority)
        self._unmodelled = UnmodelledTorque(self.inner.scenario, self.num_spacecraft)
        self.base_action = np.zeros((self.num_spacecraft, len(self._limits)))
        """(N, wheels) action of the base at the present measurement."""
        one = np.ones(len(self._limits))
        self.extend(-one, one)

    def command(self, actions: npt.NDArray[Any]) -> FloatArray:
        """Return the base actions corrected by the residuals (N, wheels)."""
        residual = np.asarray(actions, dtype=np.float64)
        return np.clip(self.base_action + self._authority * residual, -1.0, 1.0)

    def observe(self, observation: Observation, mask: BoolArray) -> Observation:
        """Let the base act on the present measurement, for the spacecraft in the mask (N,), and show its action."""
        measurement = self.measure(mask, self.baseline.reset)
        command = self.baseline.act(measurement) if mask.all() else self.baseline.act_only(measurement, mask)
        self.base_action = np.where(mask[:, None], as_action(command, self._limits), self.base_action)
        if self._profile.torque_threshold is not None:
            self._unmodelled.update(measurement, mask)
        if self._profile.authority_angle > 0.0:
            angle = np.atleast_1d(angle_between(measurement.attitude, measurement.reference_attitude))
            self._authority = self._profile.at(angle, self._unmodelled.torque)[:, None]
        return np.concatenate([observation, self.base_action], axis=1, dtype=np.float32)

    def preview(self, observation: Observation, measurement: Measurement) -> Observation:
        """Show the action of the base at another measurement."""
        none = np.zeros(self.num_spacecraft, dtype=np.bool_)
        action = as_action(self.baseline.act_only(measurement, none), self._limits)
        return np.concatenate([observation, action], axis=1, dtype=np.float32)


ResidualPolicy = wrapper("ResidualPolicy", Residual)
