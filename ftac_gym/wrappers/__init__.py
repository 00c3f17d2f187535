"""Wrappers. Those that need Stable-Baselines3 are imported when first asked for."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ftac_gym.wrappers.action_hold import ActionHold
from ftac_gym.wrappers.fault_estimate import FaultEstimateObservation, VectorFaultEstimateObservation
from ftac_gym.wrappers.gain_scheduling import GainScheduling, VectorGainScheduling, schedulable_bases
from ftac_gym.wrappers.history import ObservationHistory, VectorObservationHistory
from ftac_gym.wrappers.residual import ResidualPolicy, VectorResidualPolicy

if TYPE_CHECKING:
    from ftac_gym.wrappers.sb3 import SB3VecEnv

__all__ = [
    "ActionHold",
    "FaultEstimateObservation",
    "GainScheduling",
    "ObservationHistory",
    "ResidualPolicy",
    "SB3VecEnv",
    "VectorFaultEstimateObservation",
    "VectorGainScheduling",
    "VectorObservationHistory",
    "VectorResidualPolicy",
    "schedulable_bases",
]


def __getattr__(name: str) -> Any:
    """Import the adapter for Stable-Baselines3, and with it PyTorch, only when it is used."""
    if name == "SB3VecEnv":
        from ftac_gym.wrappers.sb3 import SB3VecEnv

        return SB3VecEnv
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
