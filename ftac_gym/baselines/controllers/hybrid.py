"""Base of the controllers of Ma et al. 2023: the error on the double cover, and the torque along the reference."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ftac_gym.attitude import cross, rotate_to_body
from ftac_gym.baselines.components.double_cover import HybridError
from ftac_gym.baselines.components.relative_motion import RelativeMotion
from ftac_gym.baselines.controllers.direct import DirectController
from ftac_gym.baselines.gains import parameter
from ftac_gym.baselines.observers.attitude_filter import AttitudeFilterGains
from ftac_gym.baselines.rules import interval, optional
from ftac_gym.task.measurement import Measurement
from ftac_gym.utils.parameters import FloatArray, non_negative


@dataclass(frozen=True)
class HybridGains(AttitudeFilterGains):
    """Gains of :class:`HybridController`."""

    hysteresis: float | None = parameter(0.1, "eta. None unwinds", "", optional(interval(0.0, 1.0)))


class Lifted(NamedTuple):
    """Motion, error quaternion (N, 4) on the double cover and logic variable h (N, 1)."""

    motion: RelativeMotion
    error: FloatArray
    logic: FloatArray


class HybridController(DirectController):
    """A controller on e_v and h (:class:`~ftac_gym.baselines.components.double_cover.HybridError`).

    The hysteresis eta is not printed. Without one h stays at 1, and the controller unwinds.
    """

    gains = HybridGains()

    def _build(self) -> None:
        super()._build()
        self._hybrid = HybridError(self.memory, self.gains.hysteresis)
        self._largest_inertia = float(np.linalg.norm(self._inertia, 2))

    def _lifted(self, measurement: Measurement, move_on: bool) -> Lifted:
        """Return the errors at a measurement; the memory changes only if it moves on."""
        motion = self._motion(measurement, move_on, short_way=False)
        lift = self._hybrid.update if move_on else self._hybrid.peek
        return Lifted(motion, *lift(motion.error))

    def _feed_forward(self, motion: RelativeMotion, measurement: Measurement) -> FloatArray:
        """Return (C w_d) x J C w_d + J C w_d' (N, 3) [N m] of a reference that moves."""
        assert motion.reference_rate is not None
        acceleration = rotate_to_body(motion.error, measurement.reference_acceleration)
        momentum = motion.reference_rate @ self._inertia
        return cross(motion.reference_rate, momentum) + acceleration @ self._inertia

    def _feed_forward_bound(self, rate: float, acceleration: float) -> float:
        """Return the largest component of the feed-forward [N m]: J_M (c1^2 + c2).

        Parameters
        ----------
        rate, acceleration
            c1 [rad/s] and c2 [rad/s^2], the largest magnitudes of w_d and w_d'.
        """
        turning = non_negative(rate, "rate") ** 2
        return self._largest_inertia * (turning + non_negative(acceleration, "acceleration"))
