"""Run a policy through episodes and keep the time histories."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from gymnasium.vector import VectorEnv

from ftac_gym import baselines, scenarios
from ftac_gym.attitude import mrp_from_quaternion, quaternion_error
from ftac_gym.envs import SpacecraftFTCVectorEnv
from ftac_gym.evaluation.metrics import Metrics, episode_metrics
from ftac_gym.policies.runner import Pilot
from ftac_gym.task.episodes import Episodes
from ftac_gym.task.scenario import Scenario
from ftac_gym.task.vibration import modal_energy, vibration_torque
from ftac_gym.utils.parameters import FloatArray, require


class Contestant(Protocol):
    """A policy that can be attached to an environment."""

    def attach(self, env: SpacecraftFTCVectorEnv) -> VectorEnv[Any, Any, Any]:
        """Return the environment as the policy sees it."""

    def predict(self, observation: Any, state: Any, episode_start: Any, deterministic: bool) -> tuple[Any, Any]:
        """Return actions and state for observations, as Stable-Baselines3 does."""

    @property
    def tier(self) -> str:
        """The information tier of its observation."""


class BaselineContestant:
    """A baseline with its gains.

    Parameters
    ----------
    law
        Name of a baseline; for a law of your own its class, or where that is, as ``"module:Class"``.
    gains
        ``"default"`` or ``"tuned"``, as for :func:`ftac_gym.baselines.make`; only the default for your own class.
    **changes
        Gains that differ from these.

    Raises
    ------
    ValueError
        If the name is unknown or it has no such gains.
    """

    tier = "attitude"

    def __init__(self, law: baselines.BaselineLike, gains: str = "default", **changes: Any) -> None:
        self.fingerprint: str | None = None
        """Same for the same policy: finished batches are found by it. None for a custom baseline."""
        # Tuned gains are data: their name says nothing of what they are, and they are read once, here.
        self._gains = baselines.chosen(law, gains, changes)
        self._build: Callable[..., baselines.Baseline] = partial(baselines.make, law)
        if law in baselines.names():
            self.fingerprint = json.dumps([law, self._gains], sort_keys=True)
        self._policy: baselines.BaselinePolicy | None = None

    def attach(self, env: SpacecraftFTCVectorEnv) -> VectorEnv[Any, Any, Any]:
        """Build the baseline for the environment's craft."""
        baseline = self._build(env.scenario, env.num_envs, **self._gains)
        self._policy = baseline.as_policy(env)
        return env

    def predict(
        self, observation: Any, state: Any = None, episode_start: Any = None, deterministic: bool = True
    ) -> tuple[FloatArray, None]:
        """Return the actions."""
        assert self._policy is not None, "attach the contestant first"
        return self._policy.predict(observation, state, episode_start, deterministic)


@dataclass(frozen=True, eq=False)
class Rollout:
    """Time histories of N episodes of T control periods; the truth, not the measurement.

    Attributes
    ----------
    scenario, episodes
        What was run.
    time
        (T + 1,) [s].
    attitude_error
        (T + 1, N) pointing error [rad].
    rate_error
        (T + 1, N) magnitude of the rate error [rad/s].
    attitude
        (T + 1, N, 4) quaternions.
    reference_attitude
        (T + 1, N, 4) quaternions of the reference.
    rate
        (T + 1, N, 3) body rates [rad/s].
    wheel_momentum
        (T + 1, N, m) [N m s].
    command
        (T, N, m) commanded wheel torques [N m].
    applied_torque
        (T, N, m) mean torque that each wheel applied in each control period [N m].
    reward
        (T, N) rewards.
    modal_displacement, modal_rate
        (T + 1, N, k) vibration modes [kg^1/2 m, kg^1/2 m/s]; k = 0 for rigid craft.
    """

    scenario: Scenario
    episodes: Episodes
    time: FloatArray
    attitude_error: FloatArray
    rate_error: FloatArray
    attitude: FloatArray
    reference_attitude: FloatArray
    rate: FloatArray
    wheel_momentum: FloatArray
    command: FloatArray
    applied_torque: FloatArray
    reward: FloatArray
    modal_displacement: FloatArray
    modal_rate: FloatArray

    @property
    def modal_energy(self) -> FloatArray:
        """Energy of the vibration modes, (T + 1, N) [J]."""
        return modal_energy(self.episodes.modes["stiffness"], self.modal_displacement, self.modal_rate)

    @property
    def vibration_torque(self) -> FloatArray:
        """Torque of the vibration modes on the body, (T + 1, N, 3) [N m], body axes."""
        return vibration_torque(self.episodes.modes, self.modal_displacement, self.modal_rate, self.rate)

    @property
    def error_mrp(self) -> FloatArray:
        """MRP of the attitude error, (T + 1, N, 3), short branch."""
        return mrp_from_quaternion(quaternion_error(self.attitude, self.reference_attitude))

    def metrics(self) -> Metrics:
        """Evaluate every episode."""
        return episode_metrics(self)


def resolve_policy(policy: Any) -> Contestant:
    """Turn a policy into a contestant.

    Parameters
    ----------
    policy
        A baseline's name, a subclass of :class:`~ftac_gym.baselines.Baseline` or ``"module:Class"``, the path of an
        agent, an :class:`~ftac_gym.agents.agent.Agent`, or any object with ``attach``, ``predict`` and ``tier``.

    Raises
    ------
    ValueError
        If a name is neither a baseline nor an agent on disk, or the policy is of no known kind.
    """
    if isinstance(policy, type) and issubclass(policy, baselines.Baseline):
        return BaselineContestant(policy)
    if not isinstance(policy, str):
        known = all(hasattr(policy, name) for name in ("attach", "predict", "tier"))
        require(known, "policy", "must be a name, a path, an Agent or a Baseline class (not an instance)", policy)
        return policy  # type: ignore[no-any-return]
    if baselines.is_baseline(policy):
        return BaselineContestant(policy)
    from ftac_gym.agents.agent import Agent

    names = [*baselines.names(), "module:Class"]
    require(Path(policy).exists(), "policy", f"must be one of {names} or the path of an agent", policy)
    return Agent.load(policy)


def rollout(
    scenario: Scenario | str,
    policy: Any,
    episodes: Episodes | None = None,
    seed: int = 0,
    count: int = 1,
    threads: int = 1,
) -> Rollout:
    """Run a policy through episodes, all of them side by side, to their full length.

    Parameters
    ----------
    scenario
        Scenario or its name.
    policy
        See :func:`resolve_policy`.
    episodes
        The episodes; None draws ``count`` of them from ``seed``.
    seed, count
        What to draw if no episodes are given.
    threads
        Threads of the simulator.

    Raises
    ------
    ValueError
        If a name is unknown or the policy does not fit the scenario.
    """
    task = scenarios.get(scenario) if isinstance(scenario, str) else scenario
    drawn = task.draw(seed, count) if episodes is None else episodes
    drawn_from = Scenario.from_json(drawn.scenario_json)
    for part in ("spacecraft", "reference"):
        same = getattr(drawn_from, part) == getattr(task, part)
        require(same, "episodes", f"must be drawn for the same {part} as {task.name}'s", drawn_from.name)
    pilot = Pilot(task, resolve_policy(policy), len(drawn), threads)
    simulator, truth, steps = pilot.env.batch.simulator, pilot.env.batch.reward, task.horizon
    craft, wheels = len(drawn), task.spacecraft.wheels.count
    error, rate_error = np.empty((steps + 1, craft)), np.empty((steps + 1, craft))
    attitude, rate = np.empty((steps + 1, craft, 4)), np.empty((steps + 1, craft, 3))
    reference_attitude = np.empty((steps + 1, craft, 4))
    momentum, command = np.empty((steps + 1, craft, wheels)), np.empty((steps, craft, wheels))
    rewards = np.empty((steps, craft))
    displacement, swing = (np.empty((steps + 1, craft, task.spacecraft.modes)) for _ in range(2))

    def record(step: int) -> None:
        error[step], rate_error[step] = truth.attitude_error, truth.rate_error
        attitude[step], rate[step] = simulator.state.attitude, simulator.state.rate
        reference_attitude[step] = simulator.reference_attitude
        momentum[step] = simulator.state.wheel_momentum
        displacement[step], swing[step] = simulator.state.modal_displacement, simulator.state.modal_rate

    pilot.reset(drawn)
    record(0)
    for step in range(steps):
        rewards[step] = pilot.step()
        command[step] = simulator.last_command
        record(step + 1)
    return Rollout(
        scenario=task,
        episodes=drawn,
        time=np.arange(steps + 1, dtype=np.float64) * task.control_period,
        attitude_error=error,
        rate_error=rate_error,
        attitude=attitude,
        reference_attitude=reference_attitude,
        rate=rate,
        wheel_momentum=momentum,
        command=command,
        applied_torque=-np.diff(momentum, axis=0) / task.control_period,
        reward=rewards,
        modal_displacement=displacement,
        modal_rate=swing,
    )
