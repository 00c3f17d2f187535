"""Checkpoints and evaluations at fixed numbers of steps, warm-up of the critic, and the curriculum of faults."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.on_policy_algorithm import OnPolicyAlgorithm

from ftac_gym.agents.agent import Agent
from ftac_gym.agents.interface import Interface
from ftac_gym.agents.storage import amend_card
from ftac_gym.training.algorithms import let_actor_learn
from ftac_gym.training.checkpoints import checkpoints, save_checkpoint
from ftac_gym.training.evaluations import AGENT, Evaluations
from ftac_gym.utils.files import remove_partials
from ftac_gym.utils.parameters import require


@dataclass(frozen=True)
class Schedule:
    """Schedule of a run; all numbers of steps are decisions of the agent over all spacecraft.

    Parameters
    ----------
    evaluate_every, checkpoint_every
        Steps between evaluations and between checkpoints.
    evaluation_episodes
        Feasible validation episodes of each evaluation.
    critic_warmup
        Steps at the start in which the critic alone learns.
    severity_start
        Severity of the faults at the start; it rises evenly to one.
    severity_steps
        Steps after which it is one.
    """

    evaluate_every: int
    checkpoint_every: int
    evaluation_episodes: int
    critic_warmup: int
    severity_start: float = 1.0
    severity_steps: int = 0

    def __post_init__(self) -> None:
        """Check the numbers."""
        for name in ("evaluate_every", "checkpoint_every", "evaluation_episodes"):
            value = getattr(self, name)
            require(isinstance(value, int) and value > 0, name, "must be a positive integer", value)
        inside = 0.0 <= self.severity_start <= 1.0
        require(inside, "severity_start", "must be within [0, 1]", self.severity_start)

    def severity(self, steps: int) -> float:
        """Return the severity of the faults after a number of steps."""
        share = min(steps / self.severity_steps, 1.0) if self.severity_steps else 1.0
        return self.severity_start + (1.0 - self.severity_start) * share


class TrainingCallback(BaseCallback):
    """Checkpoints and evaluations between rollouts; the best agent so far is kept in the folder ``agent``.

    The best agent has the largest mean availability in the evaluations, and in a tie the largest return. They are on
    validation episodes: neither the training nor the test uses them. The first checkpoint is of the start, so that
    every killed run can be resumed.

    Parameters
    ----------
    folder
        Folder of the run.
    evaluations
        Evaluations of the run so far.
    evaluate
        Function that flies an agent through the episodes of the evaluations and returns its metrics, ``mean_return``
        among them.
    interface
        Interface of the agent.
    schedule
        Schedule of the run.
    provenance
        Function that returns the origin of an agent for a number of steps, with these as ``steps`` and the time so far
        as ``training_seconds``.
    report
        Function that is given the steps and the metrics of every evaluation, such as one that prints a line.
    """

    def __init__(
        self,
        folder: Path,
        evaluations: Evaluations,
        evaluate: Callable[[Agent], Mapping[str, float]],
        interface: Interface,
        schedule: Schedule,
        provenance: Callable[[int], dict[str, Any]],
        report: Callable[[int, Mapping[str, float]], None] = lambda steps, metrics: None,
    ) -> None:
        super().__init__()
        self._folder, self._evaluations, self._evaluate = folder, evaluations, evaluate
        self._interface, self._schedule, self._provenance = interface, schedule, provenance
        self._report = report
        self._last_steps = 0
        self._severity = 1.0

    def _on_training_start(self) -> None:
        self._last_steps = self.model.num_timesteps
        remove_partials(self._folder)
        if not checkpoints(self._folder):
            self._save_checkpoint()

    def _on_rollout_start(self) -> None:
        schedule, steps = self._schedule, self.model.num_timesteps
        if isinstance(self.model, OnPolicyAlgorithm):
            let_actor_learn(self.model, learn=steps >= schedule.critic_warmup)
        severity = round(schedule.severity(steps), 2)
        if severity != self._severity:
            self.training_env.env_method("set_severity", severity)
            self._severity = severity
        # Between rollouts the model is consistent: a resumed run starts where a rollout would.
        if steps // schedule.evaluate_every > self._last_steps // schedule.evaluate_every:
            self._log_evaluation()
        if steps // schedule.checkpoint_every > self._last_steps // schedule.checkpoint_every:
            self._save_checkpoint()
        self._last_steps = steps

    def _on_training_end(self) -> None:
        self._log_evaluation()
        # The cost of the best agent is the whole run, not the part before it was the best.
        whole = self._provenance(self.model.num_timesteps)
        amend_card(self._folder / AGENT, {"run_steps": whole["steps"], "run_seconds": whole["training_seconds"]})
        # The last checkpoint is the sign that all of the run is there.
        self._save_checkpoint()

    def _on_step(self) -> bool:
        return True

    def _save_checkpoint(self) -> None:
        save_checkpoint(self._folder, self.model, self._interface, self._provenance(self.model.num_timesteps))

    def _log_evaluation(self) -> None:
        """Evaluate the agent, add the metrics to the run's table, and save the agent if it is the best so far."""
        agent, steps = Agent.of(self.model, self._interface), self.model.num_timesteps
        metrics = self._evaluate(agent)
        for name, value in metrics.items():
            self.logger.record(f"evaluation/{name}", value)

        def save(evaluation: dict[str, Any]) -> None:
            agent.save(self._folder / AGENT, **self._provenance(steps), evaluation=evaluation)

        self._evaluations.add(steps, metrics, save)
        self._report(steps, metrics)
