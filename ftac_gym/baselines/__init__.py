"""Analytical policies: batched NumPy, one controller per file, by name or by the class of a custom baseline."""

from __future__ import annotations

from ftac_gym.baselines.baseline import Baseline, BaselinePolicy
from ftac_gym.baselines.custom import BaselineLike, path_of
from ftac_gym.baselines.description import describe, stability
from ftac_gym.baselines.estimate import FaultEstimate
from ftac_gym.baselines.gains import Range, nested
from ftac_gym.baselines.interface import as_action, measurement_of
from ftac_gym.baselines.linear_loop import LoopMargins, NoLinearLoopError, loop_margins
from ftac_gym.baselines.registry import (
    GAINS,
    baseline_class,
    build,
    chosen,
    defaults,
    is_baseline,
    make,
    names,
    search_space,
)
from ftac_gym.baselines.sampling import SampledInstability

__all__ = [
    "GAINS",
    "Baseline",
    "BaselineLike",
    "BaselinePolicy",
    "FaultEstimate",
    "LoopMargins",
    "NoLinearLoopError",
    "Range",
    "SampledInstability",
    "as_action",
    "baseline_class",
    "build",
    "chosen",
    "defaults",
    "describe",
    "is_baseline",
    "loop_margins",
    "make",
    "measurement_of",
    "names",
    "nested",
    "path_of",
    "search_space",
    "stability",
]
