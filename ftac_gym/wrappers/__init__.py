"""Wrappers for single and vector environments; those that need Stable-Baselines3 are imported at their first use."""

from typing import TYPE_CHECKING, Any

from ftac_gym.utils.extras import require_extra
from ftac_gym.wrappers.action_hold import ActionHold
from ftac_gym.wrappers.fault_estimate import FaultEstimateObservation
from ftac_gym.wrappers.gain_scheduling import GainScheduling, schedulable_bases
from ftac_gym.wrappers.history import ObservationHistory
from ftac_gym.wrappers.residual import ResidualPolicy

if TYPE_CHECKING:
    from ftac_gym.wrappers.sb3 import SB3VecEnv

__all__ = [
    "ActionHold",
    "FaultEstimateObservation",
    "GainScheduling",
    "ObservationHistory",
    "ResidualPolicy",
    "SB3VecEnv",
    "schedulable_bases",
]


def __getattr__(name: str) -> Any:
    """Import the adapter for Stable-Baselines3, and with it PyTorch, at its first use."""
    if name == "SB3VecEnv":
        require_extra("stable_baselines3")
        from ftac_gym.wrappers.sb3 import SB3VecEnv

        return SB3VecEnv
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
