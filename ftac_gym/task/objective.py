"""Objective of a policy: the weights of the reward, and the criterion of success."""

import dataclasses
from dataclasses import dataclass

import numpy as np

from ftac_gym.utils.parameters import non_negative, normalise, positive
from ftac_gym.utils.serialization import LATER_PART, serializable


@serializable
@dataclass(frozen=True)
class RewardWeights:
    """Weights of the reward terms; each term is documented in :mod:`ftac_gym.envs.reward`.

    Parameters
    ----------
    progress
        Of the decrease of the pointing error, per radian.
    precision
        Of the logarithmic pointing term.
    rate
        Of the rate error, per (rad/s)^2.
    effort
        Of the mean squared wheel command over the limit.
    smoothness
        Of the mean squared change of the wheel command over the limit.
    on_target
        Per step inside the success cone.
    tumble
        Penalty when the episode ends by tumbling; it must outweigh the cost of bad pointing until its regular end.
    vibration
        Of the energy of the vibration modes, per joule.
    """

    progress: float = 10.0
    precision: float = 0.1
    rate: float = 0.0
    effort: float = 0.01
    smoothness: float = 0.02
    on_target: float = 0.1
    tumble: float = 200.0
    vibration: float = dataclasses.field(default=0.0, metadata=LATER_PART)

    def __post_init__(self) -> None:
        """Check the weights."""
        normalise(self, non_negative, *(item.name for item in dataclasses.fields(self)))


@serializable
@dataclass(frozen=True)
class SuccessCriterion:
    """Criterion of success: inside the cone and slow for the last seconds.

    Parameters
    ----------
    angle
        Half-angle of the cone [rad].
    rate
        Largest rate error [rad/s].
    hold
        Time before the end for which both must hold [s].
    """

    angle: float = float(np.radians(0.1))
    rate: float = float(np.radians(0.02))
    hold: float = 20.0

    def __post_init__(self) -> None:
        """Check the limits."""
        normalise(self, positive, "angle", "rate", "hold")
