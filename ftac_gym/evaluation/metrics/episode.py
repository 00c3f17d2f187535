"""All metrics of an episode. A new one is a line in the ``METRICS`` of a module, and a value in its ``measure``."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ftac_gym.evaluation.metrics import budgets, on_target, pointing, recovery, vibration, wheels
from ftac_gym.evaluation.metrics.metric import Metric
from ftac_gym.utils.parameters import FloatArray

if TYPE_CHECKING:
    from ftac_gym.evaluation.metrics.history import Rollout

Metrics = dict[str, FloatArray]
"""Arrays (N,) by name."""

_MODULES = (on_target, recovery, budgets, pointing, wheels, vibration)

METRICS = (*(metric for module in _MODULES for metric in module.METRICS), Metric("return", "-", higher_is_better=True))
"""All metrics, in the order of tables and files."""

UNITS = {metric.name: metric.unit for metric in METRICS}
"""Unit of each metric."""

HIGHER_IS_BETTER = frozenset(metric.name for metric in METRICS if metric.higher_is_better)
"""Metrics that are better if they are larger; all others are better if they are smaller."""

SHARES = frozenset(metric.name for metric in METRICS if metric.share)
"""Metrics with a mean that is a share itself, of the time or of the episodes; others have robust statistics."""

PARTIAL = frozenset(metric.name for metric in METRICS if metric.partial)
"""Metrics that are defined for some episodes of a task and not for others: a count belongs beside them."""


def episode_metrics(history: Rollout) -> Metrics:
    """Evaluate every episode of a rollout.

    The modules of :mod:`ftac_gym.evaluation.metrics` define the metrics: :mod:`~ftac_gym.evaluation.metrics.on_target`,
    :mod:`~ftac_gym.evaluation.metrics.recovery`, :mod:`~ftac_gym.evaluation.metrics.budgets`,
    :mod:`~ftac_gym.evaluation.metrics.pointing`, :mod:`~ftac_gym.evaluation.metrics.wheels` and
    :mod:`~ftac_gym.evaluation.metrics.vibration`. ``return`` is the sum of the rewards, the objective of agents.

    Returns
    -------
    Arrays (N,) by name.
    """
    found = {name: values for module in _MODULES for name, values in module.measure(history).items()}
    found["return"] = history.reward.sum(axis=0)
    return {name: found[name] for name in UNITS}
