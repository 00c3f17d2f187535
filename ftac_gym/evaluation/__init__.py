"""Rollouts, metrics, statistics, comparisons, benchmarks and tuning."""

from ftac_gym.evaluation.batches import Evaluation, evaluate
from ftac_gym.evaluation.compare import Row, compare, fault_classes
from ftac_gym.evaluation.metrics import Rollout, episode_metrics, summarize
from ftac_gym.evaluation.rollout import rollout
from ftac_gym.evaluation.statistics import Estimate, estimate, interquartile_mean, paired_difference

__all__ = [
    "Estimate",
    "Evaluation",
    "Rollout",
    "Row",
    "compare",
    "episode_metrics",
    "estimate",
    "evaluate",
    "fault_classes",
    "interquartile_mean",
    "paired_difference",
    "rollout",
    "summarize",
]
