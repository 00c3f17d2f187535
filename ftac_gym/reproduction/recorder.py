"""Flights of plans through a rollout with a recorder."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import replace
from typing import Any

import numpy as np
from gymnasium.vector import VectorEnv, VectorWrapper

from ftac_gym.attitude import angle_between, mrp_from_quaternion
from ftac_gym.envs import SpacecraftFTCVectorEnv
from ftac_gym.evaluation.rollout import rollout
from ftac_gym.evaluation.truth import true_effect
from ftac_gym.policies.policy import DeferredBaseline
from ftac_gym.policies.runner import PolicyRunner
from ftac_gym.reproduction.recordings import Plan, Recording
from ftac_gym.utils.parameters import FloatArray

ESTIMATES = ("effectiveness", "bias", "disturbance", "vibration", "identifiable")
"""Parts of a fault estimate that are recorded."""


class _TorqueCommands(VectorWrapper):
    """Vector environment whose actions are wheel torques [N m].

    An action of the environment itself is a fraction of the torque limits. Scaling there and back rounds the torque,
    and flights that tumble amplify the difference.
    """

    def __init__(self, env: SpacecraftFTCVectorEnv) -> None:
        super().__init__(env)
        self._batch = env.batch

    def step(self, actions: FloatArray) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """Hold wheel torques (N, m) [N m] for one control period; rewards are zero."""
        self._batch.simulator.step(actions)
        _, terminated = self._batch.reward.update(np.arange(self.num_envs))
        return None, np.zeros(self.num_envs), terminated, self._batch.simulator.ticks >= self._batch.horizon, {}


class _TorqueBaseline(DeferredBaseline):
    """Baseline whose actions are its torques [N m]."""

    def attach(self, env: SpacecraftFTCVectorEnv) -> VectorEnv[Any, Any, Any]:
        """Build the baseline for the spacecraft of an environment, which is returned with torques as actions."""
        super().attach(env)
        self._env = env
        return _TorqueCommands(env)

    def predict(
        self, observation: Any, state: Any = None, episode_start: Any = None, deterministic: bool = True
    ) -> tuple[FloatArray, None]:
        """Return the torques (N, wheels) for the present measurement [N m]."""
        return self.baseline.act(self._env.measurement(truth=self.baseline.information == "oracle")), None


def record(plan: Plan) -> Recording:
    """Fly a plan and record it."""
    policy = _TorqueBaseline(plan.baseline, **plan.gains)
    memory: dict[str, list[FloatArray]] = {name: [] for name in plan.recorded}
    estimates: dict[str, list[Any]] = defaultdict(list)

    def collect(step: int, runner: PolicyRunner) -> None:
        flown: Any = runner.policy
        baseline, estimate = flown.baseline, flown.baseline.estimate
        for name, history in memory.items():
            history.append(baseline.memory[name])
        # The estimate is that of the period before.
        if step > 0 and estimate is not None:
            for name in ESTIMATES:
                estimates[name].append(getattr(estimate, name))
            if baseline.memory.has("rate_mismatch"):
                estimates["rate_mismatch"].append(baseline.memory["rate_mismatch"])

    episodes = plan.scenario.draw(plan.seed, plan.num_spacecraft)
    if plan.flipped:
        start = episodes.initial.copy()
        start["attitude"] *= -1.0
        episodes = replace(episodes, initial=start)
    history = rollout(plan.scenario, policy, episodes, recorder=collect)
    effects = [true_effect(history, spacecraft) for spacecraft in range(plan.num_spacecraft)]
    return Recording(
        plan=plan,
        time=history.time,
        error=np.degrees(angle_between(history.attitude, history.reference_attitude)),
        attitude=mrp_from_quaternion(history.attitude),
        reference=mrp_from_quaternion(history.reference_attitude),
        rate=history.rate,
        command=history.command,
        true_effectiveness=np.stack([effect.effectiveness[:-1] for effect in effects], axis=1),
        true_bias=np.stack([effect.bias[:-1] for effect in effects], axis=1),
        true_vibration=history.vibration_torque,
        modal_energy=history.modal_energy,
        memory={name: np.array(rows) for name, rows in memory.items()},
        **{name: np.array(rows) for name, rows in estimates.items() if rows[0] is not None},
    )
