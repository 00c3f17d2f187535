"""Time histories of episodes, and their metrics, one value for each episode."""

from ftac_gym.evaluation.metrics.episode import (
    HIGHER_IS_BETTER,
    METRICS,
    PARTIAL,
    SHARES,
    UNITS,
    Metrics,
    episode_metrics,
)
from ftac_gym.evaluation.metrics.history import Rollout
from ftac_gym.evaluation.metrics.metric import Metric
from ftac_gym.evaluation.metrics.recovery import Recoveries
from ftac_gym.evaluation.metrics.summary import counted, described, share_of, summarize

__all__ = [
    "HIGHER_IS_BETTER",
    "METRICS",
    "PARTIAL",
    "SHARES",
    "UNITS",
    "Metric",
    "Metrics",
    "Recoveries",
    "Rollout",
    "counted",
    "described",
    "episode_metrics",
    "share_of",
    "summarize",
]
