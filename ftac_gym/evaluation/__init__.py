"""Rollouts, metrics, statistics, comparisons, benchmarks and tuning."""

from ftac_gym.evaluation.batches import Evaluation, evaluate
from ftac_gym.evaluation.comparison import Comparison, compare
from ftac_gym.evaluation.diagnosis import AlarmRule, Diagnosis, diagnose, diagnosis_of
from ftac_gym.evaluation.metrics import Rollout, episode_metrics, summarize
from ftac_gym.evaluation.rollout import rollout
from ftac_gym.evaluation.rows import Row, fault_classes, tabulate
from ftac_gym.evaluation.statistics import Estimate, estimate, interquartile_mean, paired_difference

__all__ = [
    "AlarmRule",
    "Comparison",
    "Diagnosis",
    "Estimate",
    "Evaluation",
    "Rollout",
    "Row",
    "compare",
    "diagnose",
    "diagnosis_of",
    "episode_metrics",
    "estimate",
    "evaluate",
    "fault_classes",
    "interquartile_mean",
    "paired_difference",
    "rollout",
    "summarize",
    "tabulate",
]
