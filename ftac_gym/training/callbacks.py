"""Callbacks: checkpoints and evaluations at fixed numbers of steps, warm-up of the critic, and the curriculum."""

from __future__ import annotations

import csv
import json
import math
import re
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.on_policy_algorithm import OnPolicyAlgorithm

from ftac_gym.agents.agent import CARD_FILE, MODEL_FILE, NORMALIZER_FILE, Agent, Interface
from ftac_gym.agents.shipped import EVALUATIONS_FILE, evaluations
from ftac_gym.evaluation.metrics import summarize
from ftac_gym.evaluation.rollout import rollout
from ftac_gym.scenarios import frozen
from ftac_gym.task.scenario import Scenario
from ftac_gym.training.algorithms import let_actor_learn
from ftac_gym.utils.parameters import require


@dataclass(frozen=True)
class Schedule:
    """When a run does what; all numbers are decisions of the agent over all craft.

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
        """Return the severity after a number of steps."""
        share = min(steps / self.severity_steps, 1.0) if self.severity_steps else 1.0
        return self.severity_start + (1.0 - self.severity_start) * share


def save_agent(folder: Path, model: BaseAlgorithm, card: dict[str, Any]) -> None:
    """Write model, normaliser and card; a folder appears whole or not at all."""
    partial = folder.with_name(folder.name + ".partial")
    shutil.rmtree(partial, ignore_errors=True)
    partial.mkdir(parents=True)
    model.save(partial / MODEL_FILE)
    normalizer = model.get_vec_normalize_env()
    if normalizer is not None:
        normalizer.save(str(partial / NORMALIZER_FILE))
    (partial / CARD_FILE).write_text(json.dumps(card, indent=2) + "\n")
    # The old one goes only when the new one stands: a kill in between leaves one of them.
    old = folder.with_name(folder.name + ".old")
    shutil.rmtree(old, ignore_errors=True)
    if folder.exists():
        folder.rename(old)
    partial.rename(folder)
    shutil.rmtree(old, ignore_errors=True)


class Keeper(BaseCallback):
    """Checkpoints and evaluates between rollouts, and keeps the best agent so far in ``agent``.

    The best is judged by its mean return on fixed feasible episodes, which neither training nor the reported test uses.

    Parameters
    ----------
    folder
        Folder of the run.
    scenario
        Scenario of the evaluations.
    interface
        What surrounds the policy.
    schedule
        When to do what.
    card
        What to write beside an agent, from steps and seconds of training.
    clock
        Seconds of training so far, those of earlier sessions among them.
    """

    def __init__(
        self,
        folder: Path,
        scenario: Scenario,
        interface: Interface,
        schedule: Schedule,
        card: Callable[[int, float], dict[str, Any]],
        clock: Callable[[], float],
    ) -> None:
        super().__init__()
        self._folder, self._scenario, self._interface = folder, scenario, interface
        self._schedule, self._card = schedule, card
        self._next_checkpoint = self._next_evaluation = 0
        self._best = -math.inf
        self._clock = clock
        self._warming: bool | None = None
        self._severity = 1.0

    def _on_training_start(self) -> None:
        schedule, steps = self._schedule, self.model.num_timesteps
        self._next_checkpoint = (steps // schedule.checkpoint_every + 1) * schedule.checkpoint_every
        self._next_evaluation = (steps // schedule.evaluate_every + 1) * schedule.evaluate_every
        known = (row["mean_return"] for row in evaluations(self._folder))
        self._best = max((value for value in known if not math.isnan(value)), default=-math.inf)

    def _on_rollout_start(self) -> None:
        schedule, steps = self._schedule, self.model.num_timesteps
        warming = steps < schedule.critic_warmup
        if isinstance(self.model, OnPolicyAlgorithm) and warming != self._warming:
            let_actor_learn(self.model, learn=not warming)
            self._warming = warming
        severity = round(schedule.severity(steps), 2)
        if severity != self._severity:
            self.training_env.env_method("set_severity", severity)
            self._severity = severity
        # Between rollouts the model is consistent: a resumed run starts where a rollout would.
        if steps >= self._next_evaluation:
            self._next_evaluation += schedule.evaluate_every
            self._evaluate(steps)
        if steps >= self._next_checkpoint:
            self._next_checkpoint += schedule.checkpoint_every
            self._checkpoint(steps)

    def _on_training_end(self) -> None:
        self._evaluate(self.model.num_timesteps)
        self._checkpoint(self.model.num_timesteps)
        # The best agent cost the whole run, not the part of it before it was the best.
        path = self._folder / "agent" / CARD_FILE
        whole = {"run_steps": self.model.num_timesteps, "run_seconds": round(self._clock())}
        path.write_text(json.dumps({**json.loads(path.read_text()), **whole}, indent=2) + "\n")

    def _on_step(self) -> bool:
        return True

    def _save(self, folder: Path) -> None:
        save_agent(folder, self.model, self._card(self.model.num_timesteps, self._clock()))

    def _checkpoint(self, steps: int) -> None:
        self._save(self._folder / "checkpoints" / f"{steps:010d}")

    def _evaluate(self, steps: int) -> None:
        schedule = self._schedule
        agent = Agent(self.model, self.model.get_vec_normalize_env(), self._interface)
        history = rollout(self._scenario, agent, seed=schedule.evaluation_seed, count=schedule.evaluation_episodes)
        feasible = history.episodes.feasible
        metrics = {name: values[feasible] for name, values in history.metrics().items()}
        row = {"steps": steps, "mean_return": float(metrics["return"].mean()), **summarize(metrics)}
        for name, value in row.items():
            if name != "steps":
                self.logger.record(f"evaluation/{name}", value)
        # The first agent is kept whatever it is worth, even if no evaluation episode was feasible.
        if row["mean_return"] > self._best or not (self._folder / "agent").exists():
            self._best = max(self._best, row["mean_return"])
            self._save(self._folder / "agent")
        path = self._folder / EVALUATIONS_FILE
        new = not path.exists()
        with path.open("a", newline="") as file:
            writer = csv.DictWriter(file, fieldnames=list(row))
            if new:
                writer.writeheader()
            writer.writerow(row)


def checkpoints(folder: Path) -> list[Path]:
    """Return the complete checkpoints of a run, oldest first."""
    return sorted(path for path in (folder / "checkpoints").glob("*") if re.fullmatch(r"\d{10}", path.name))
