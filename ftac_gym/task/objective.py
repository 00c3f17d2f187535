"""Objective of a policy: the weights of the reward, and the criterion of success."""

import dataclasses
import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ftac_gym.utils.parameters import non_negative, normalise, optional, positive, require
from ftac_gym.utils.serialization import LATER_PART, serializable

COSTS = ("effort", "smoothness", "rate", "vibration")
"""Weights of the reward that are shares of the pointing term."""


@serializable
@dataclass(frozen=True)
class RewardWeights:
    """Weights of the reward terms; each term is documented in :mod:`ftac_gym.envs.reward`.

    Parameters
    ----------
    pointing
        Of the pointing term, which falls from 1 to 0 with the error.
    effort
        Of the mean squared wheel command over the limit, as a share of the pointing term.
    smoothness
        Of the mean squared change of the wheel command over its range, as a share of the pointing term.
    rate
        Of the bounded rate error, as a share of the pointing term.
    vibration
        Of the bounded energy of the vibration modes, as a share of the pointing term.
    on_target
        Per step inside the success cone.
    progress
        Of the shaping by a potential, per radian; it can make a step negative.
    rate_scale
        Rate error of half the cost of rate [rad/s].
    vibration_scale
        Energy of half the cost of vibration [J].
    discount
        Discount of the shaping, in (0, 1]; that of the learner.

    Raises
    ------
    ValueError
        If a weight is negative, a scale is not positive, or the weights of the costs add up to more than 1.
    """

    pointing: float = 1.0
    effort: float = 0.1
    smoothness: float = 0.1
    rate: float = 0.6
    vibration: float = dataclasses.field(default=0.0, metadata=LATER_PART)
    on_target: float = 1.0
    progress: float = 0.0
    rate_scale: float = 0.3
    vibration_scale: float = dataclasses.field(default=1e-3, metadata=LATER_PART)
    discount: float = 1.0

    def __post_init__(self) -> None:
        """Check the weights."""
        normalise(self, non_negative, "pointing", *COSTS, "on_target", "progress")
        normalise(self, positive, "rate_scale", "vibration_scale", "discount")
        require(self.discount <= 1.0, "discount", "must lie within (0, 1]", self.discount)
        costs = {name: getattr(self, name) for name in COSTS}
        rule = "must add up to at most 1, so that no step is negative"
        require(math.fsum(costs.values()) <= 1.0, " + ".join(COSTS), rule, costs)


@serializable
@dataclass(frozen=True)
class CostBounds:
    """Bounds of ``info["cost"]``, the time that a spacecraft spends outside of them, for safe reinforcement learning.

    Parameters
    ----------
    angle
        Pointing error from which time counts [rad]; None for the scenario's prescribed bound, or without one the
        success cone.
    torque
        Wheel command from which time counts, as a share of the torque limit; by default a saturated command counts.
    """

    angle: float | None = None
    torque: float = 1.0

    def __post_init__(self) -> None:
        """Check the bounds."""
        normalise(self, optional(positive), "angle")
        normalise(self, positive, "torque")


@serializable
@dataclass(frozen=True)
class SuccessCriterion:
    """Criterion of success: on target for a share of the last seconds, and never far away in them.

    *On target* means inside the cone and slow. The window is that of the last ``hold`` seconds. A spacecraft that
    leaves the cone by tenths of a second of noise still passes; one that is thrown out of it does not.

    Parameters
    ----------
    angle
        Half-angle of the cone [rad].
    rate
        Largest rate error [rad/s].
    hold
        Length of the window before the end [s]; in an episode that is not longer, the window is all of it.
    share
        Least share of the window's control periods on target, in (0, 1]; 1 asks for each of them.
    limit
        Largest pointing error in the window, in half-angles of the cone, 1 or more; None for no limit.

    Raises
    ------
    ValueError
        If a number is not positive, the share is above 1, or the limit is below 1.
    """

    angle: float = float(np.radians(0.1))
    rate: float = float(np.radians(0.02))
    hold: float = 20.0
    share: float = dataclasses.field(default=0.95, metadata=LATER_PART)
    limit: float | None = dataclasses.field(default=10.0, metadata=LATER_PART)

    def __post_init__(self) -> None:
        """Check the limits."""
        normalise(self, positive, "angle", "rate", "hold", "share")
        normalise(self, optional(positive), "limit")
        require(self.share <= 1.0, "share", "must lie within (0, 1]", self.share)
        require(self.limit is None or self.limit >= 1.0, "limit", "must be at least 1, or None", self.limit)

    @property
    def largest_error(self) -> float:
        """Largest pointing error in the window [rad]; infinite without a limit."""
        return math.inf if self.limit is None else self.limit * self.angle

    def reached(self, window: int, flown: Any, on_target: Any, beyond: Any) -> Any:
        """Tell whether episodes are successes so far: the one rule of environments and evaluation.

        Parameters
        ----------
        window
            Control periods in the window, see :func:`~ftac_gym.task.scenario.success_steps`.
        flown
            Control periods so far, a number or (N,). Before the end of a first window there is no success.
        on_target
            Of the last window's control periods, the number that end on target, a number or (N,).
        beyond
            The number that end with a pointing error above :attr:`largest_error`, a number or (N,).
        """
        needed = math.ceil(self.share * window - 1e-9)
        return (flown >= window) & (on_target >= needed) & (beyond == 0)
