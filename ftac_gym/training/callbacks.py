"""Checkpoints and evaluations at fixed numbers of steps, warm-up of the critic, and the curriculum of faults."""

from __future__ import annotations

import csv
import math
import re
import shutil
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.on_policy_algorithm import OnPolicyAlgorithm

from ftac_gym.agents.agent import Agent
from ftac_gym.agents.interface import Interface
from ftac_gym.agents.shipped import EVALUATIONS_FILE, evaluations
from ftac_gym.agents.storage import CARD_FILE, amend_card
from ftac_gym.scenarios import frozen
from ftac_gym.training.algorithms import let_actor_learn
from ftac_gym.utils.parameters import require


@dataclass(frozen=True)
class Schedule:
    """Schedule of a run; all numbers of steps are decisions of the agent over all spacecraft.

    Parameters
    ----------
    evaluate_every, checkpoint_every
        Steps between evaluations and between checkpoints.
    evaluation_episodes, evaluation_seed
        The fixed episodes of evaluations; the feasible ones count.
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
    evaluation_seed: int
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
        taken = list(frozen.seeds().values())
        rule = f"must not be of the frozen test episodes, {taken}"
        require(self.evaluation_seed not in taken, "evaluation_seed", rule, self.evaluation_seed)

    def severity(self, steps: int) -> float:
        """Return the severity of the faults after a number of steps."""
        share = min(steps / self.severity_steps, 1.0) if self.severity_steps else 1.0
        return self.severity_start + (1.0 - self.severity_start) * share


MODEL_FILE, NORMALIZER_FILE = "model.zip", "normalizer.pkl"
"""Files of a checkpoint, beside those of its agent, from which training goes on."""


def save_checkpoint(folder: Path, model: BaseAlgorithm, interface: Interface, card: Mapping[str, Any]) -> None:
    """Write agent, model and normaliser; the folder appears complete or not at all."""
    partial = folder.with_name(folder.name + ".partial")
    shutil.rmtree(partial, ignore_errors=True)
    Agent.of(model, interface).save(partial, **card)
    model.save(partial / MODEL_FILE)
    normalizer = model.get_vec_normalize_env()
    if normalizer is not None:
        normalizer.save(str(partial / NORMALIZER_FILE))
    shutil.rmtree(folder, ignore_errors=True)
    partial.rename(folder)


class TrainingCallback(BaseCallback):
    """Checkpoints and evaluations between rollouts; the best agent so far is kept in the folder ``agent``.

    The best agent has the largest mean return in the evaluations. Their episodes are used neither for training nor for
    the reported test.

    Parameters
    ----------
    folder
        Folder of the run.
    evaluate
        Function that flies an agent through the episodes of the evaluations and returns its metrics, ``mean_return``
        among them.
    interface
        Interface of the agent.
    schedule
        Schedule of the run.
    card
        Function that returns the origin of an agent for a number of steps, with these as ``steps`` and the time so
        far as ``training_seconds``, for its card.
    """

    def __init__(
        self,
        folder: Path,
        evaluate: Callable[[Agent], Mapping[str, float]],
        interface: Interface,
        schedule: Schedule,
        card: Callable[[int], dict[str, Any]],
    ) -> None:
        super().__init__()
        self._folder, self._evaluate, self._interface = folder, evaluate, interface
        self._schedule, self._card = schedule, card
        self._best = -math.inf
        self._last_steps = 0
        self._severity = 1.0

    def _on_training_start(self) -> None:
        self._last_steps = steps = self.model.num_timesteps
        # A killed run repeats its evaluations after the last checkpoint.
        path = self._folder / EVALUATIONS_FILE
        lines = path.read_text().splitlines(keepends=True) if path.exists() else []
        earlier = [line for line in lines[1:] if int(line.split(",")[0]) <= steps]
        path.unlink(missing_ok=True)
        if earlier:
            path.write_text("".join([lines[0], *earlier]))
        returns = (row["mean_return"] for row in evaluations(self._folder))
        self._best = max((value for value in returns if not math.isnan(value)), default=-math.inf)

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
        steps = self.model.num_timesteps
        self._log_evaluation()
        self._save_checkpoint()
        # The cost of the best agent is the whole run, not the part before it was the best.
        whole = self._card(steps)
        amend_card(self._folder / "agent", {"run_steps": steps, "run_seconds": whole["training_seconds"]})

    def _on_step(self) -> bool:
        return True

    def _save_checkpoint(self) -> None:
        steps = self.model.num_timesteps
        folder = self._folder / "checkpoints" / f"{steps:010d}"
        save_checkpoint(folder, self.model, self._interface, self._card(steps))

    def _log_evaluation(self) -> None:
        """Evaluate the agent, append the metrics to the run's table, and save the agent if it is the best so far."""
        agent = Agent.of(self.model, self._interface)
        metrics = self._evaluate(agent)
        for name, value in metrics.items():
            self.logger.record(f"evaluation/{name}", value)
        # The first agent is saved even if no evaluation episode was feasible.
        if metrics["mean_return"] > self._best or not (self._folder / "agent" / CARD_FILE).exists():
            self._best = max(self._best, metrics["mean_return"])
            agent.save(self._folder / "agent", **self._card(self.model.num_timesteps))
        row = {"steps": self.model.num_timesteps, **metrics}
        with (self._folder / EVALUATIONS_FILE).open("a", newline="") as file:
            writer = csv.DictWriter(file, fieldnames=list(row))
            if not file.tell():
                writer.writeheader()
            writer.writerow(row)


def checkpoints(folder: Path) -> list[Path]:
    """Return the complete checkpoints of a run, oldest first."""
    return sorted(path for path in (folder / "checkpoints").glob("*") if re.fullmatch(r"\d{10}", path.name))
