"""What the laws of Ma et al. 2023 share: the error on the double cover, and the torque that the reference needs."""

from __future__ import annotations

import numpy as np

from ftac_gym.attitude import cross, rotate_to_body
from ftac_gym.baselines.components.double_cover import HybridError
from ftac_gym.baselines.components.relative_motion import RelativeMotion
from ftac_gym.baselines.controllers.direct import DirectController
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, non_negative


class HybridController(DirectController):
    """A law on e_v and h.

    Parameters
    ----------
    scenario, num_spacecraft
        As for every baseline.
    hysteresis
        eta, see :class:`~ftac_gym.baselines.components.double_cover.HybridError`; None never jumps.
    attitude_filter_time
        Time constant of the attitude filter [s]; zero uses the star tracker as it comes.

    Raises
    ------
    ValueError
        If a gain breaks a rule.
    """

    def __init__(
        self, scenario: Scenario, num_spacecraft: int, hysteresis: float | None, attitude_filter_time: float
    ) -> None:
        super().__init__(scenario, num_spacecraft, attitude_filter_time)
        self._hybrid = HybridError(self.memory, hysteresis)
        self._largest_inertia = float(np.linalg.norm(self._inertia, 2))

    def _feed_forward(self, motion: RelativeMotion, measurement: Measurement) -> FloatArray:
        """Return (C w_d) x J C w_d + J C w_d' (N, 3) [N m] of a reference that moves."""
        assert motion.reference_rate is not None
        acceleration = rotate_to_body(motion.error, measurement.reference_acceleration)
        momentum = motion.reference_rate @ self._inertia
        torque: FloatArray = cross(motion.reference_rate, momentum) + acceleration @ self._inertia
        return torque

    def _feed_forward_bound(self, rate: float, acceleration: float) -> float:
        """Return what no component of the feed-forward exceeds [N m]: J_M (c1^2 + c2).

        Parameters
        ----------
        rate, acceleration
            c1 [rad/s] and c2 [rad/s^2], the largest magnitudes of w_d and w_d'.
        """
        turning = non_negative(rate, "rate") ** 2
        return self._largest_inertia * (turning + non_negative(acceleration, "acceleration"))
