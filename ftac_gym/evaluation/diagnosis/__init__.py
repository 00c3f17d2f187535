"""Diagnosis of faults by policies that estimate them: detection, isolation, false alarms, errors of the estimates.

An estimator declares a wheel faulty by its own flags (``FaultEstimate.alarm``), or by :class:`AlarmRule`. The measures
are those of Patton, Frank and Clark 1989 ("Fault diagnosis in dynamic systems"), with missed faults as censored delays.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ftac_gym import scenarios
from ftac_gym.evaluation.batches import BATCH
from ftac_gym.evaluation.diagnosis.alarms import AlarmRule, alarms_of
from ftac_gym.evaluation.diagnosis.detection import detections, false_alarms
from ftac_gym.evaluation.diagnosis.errors import SquaredErrors, squared_errors
from ftac_gym.evaluation.diagnosis.result import (
    Diagnosis,
    detection_rows,
    diagnosis_rows,
    diagnosis_table,
    kinds_table,
)
from ftac_gym.evaluation.episodes import FEASIBLE, judging_episodes
from ftac_gym.evaluation.metrics import Rollout
from ftac_gym.evaluation.rollout import rollout
from ftac_gym.policies import PolicyRunner, check_task, policy_label, resolve
from ftac_gym.policies.policy import Policy
from ftac_gym.scenarios import ScenarioLike
from ftac_gym.task.episodes import Episodes
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import require

__all__ = [
    "AlarmRule",
    "Diagnosis",
    "check_estimates",
    "detection_rows",
    "diagnose",
    "diagnosis_of",
    "diagnosis_rows",
    "diagnosis_table",
    "kinds_table",
]


def diagnose(
    scenario: ScenarioLike,
    policy: Any,
    episodes: Episodes | int = FEASIBLE,
    rule: AlarmRule | None = None,
    name: str | None = None,
    progress: Callable[[int], None] | None = None,
) -> Diagnosis:
    """Fly a policy through episodes and judge its estimates of the faults.

    Parameters
    ----------
    scenario
        The task; see :func:`ftac_gym.scenarios.resolve`.
    policy
        See :func:`~ftac_gym.policies.resolve`. Its estimates are its own, or those of the base or the wrapper through
        which it acts.
    episodes
        Episodes, or the number of feasible ones (:func:`~ftac_gym.evaluation.episodes.judging_episodes`). All of them
        count, infeasible ones too: a fault can be found where it cannot be compensated.
    rule
        Thresholds of the alarms, for estimators without alarms of their own.
    name
        Name for tables; the default is the policy's own.
    progress
        Called with the number of episodes of each finished batch.

    Raises
    ------
    ValueError
        If the policy does not fit the scenario, does not estimate faults, or is told the truth about them. If the rule
        is no rule.
    """
    task, chosen = scenarios.resolve(scenario), AlarmRule() if rule is None else rule
    require(isinstance(chosen, AlarmRule), "rule", "must be an AlarmRule or None", rule)
    shown = name if name is not None else policy_label(policy)
    resolved = resolve(policy, task.name)
    check_estimates(resolved, task, shown)
    drawn = judging_episodes(task, episodes)
    parts = []
    for first in range(0, len(drawn), BATCH):
        batch = drawn[first : first + BATCH]
        history = rollout(task, resolved, batch, estimates=True)
        parts.append(diagnosis_of(history, chosen, shown))
        parts[-1].detections["episode"] += first
        if progress is not None:
            progress(len(batch))
    return _joined(parts)


def check_estimates(policy: Policy, scenario: Scenario, name: str) -> None:
    """Let a policy act for a control period, and refuse one without estimates of its own.

    Raises
    ------
    ValueError
        If it does not fit the scenario, does not estimate faults, or is told the truth about them.
    """
    check_task(policy, scenario)
    runner = PolicyRunner(scenario, policy)
    runner.reset(scenario.draw(0, 1))
    runner.step()
    require(runner.estimator is not None, "policy", "must estimate faults to be judged by a diagnosis", name)
    told = getattr(runner.estimator, "information", policy.tier) == "oracle"
    require(not told, "policy", "must estimate faults from measurements: a diagnosis of the truth is perfect", name)


def diagnosis_of(history: Rollout, rule: AlarmRule | None = None, name: str = "") -> Diagnosis:
    """Judge the estimates of a rollout.

    Parameters
    ----------
    history
        A rollout with ``estimates``.
    rule
        Thresholds of the alarms.
    name
        Name of the policy.

    Raises
    ------
    ValueError
        If the rollout has no estimates, or none of wheels or torque.
    """
    chosen, scenario, given = AlarmRule() if rule is None else rule, history.scenario, history.estimates
    if given is None:
        raise ValueError("history must have estimates: rollout(..., estimates=True)")
    period = scenario.control_period
    alarms = alarms_of(given, chosen, scenario.spacecraft.wheels, period)
    found = detections(alarms, history.episodes, period, chosen.grace)
    wrong = false_alarms(alarms, history.episodes, period, chosen.grace)
    return Diagnosis(name, chosen, alarms.names_wheels, found, *wrong, squared_errors(history))


def _joined(parts: list[Diagnosis]) -> Diagnosis:
    """Return the diagnosis of all batches."""
    first = parts[0]
    errors = {
        name: SquaredErrors(*map(np.concatenate, zip(*(item.errors[name] for item in parts), strict=True)))
        for name in first.errors
    }
    arrays = ("detections", "false_alarms", "healthy_time", "alarm_time")
    joined: dict[str, Any] = {name: np.concatenate([getattr(item, name) for item in parts]) for name in arrays}
    return Diagnosis(first.policy, first.rule, first.names_wheels, errors=errors, **joined)
