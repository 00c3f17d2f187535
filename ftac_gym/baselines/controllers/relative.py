"""Base of the controllers on the rotation between body and reference instead of a difference of attitude parameters."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import ClassVar

from ftac_gym.baselines.components.allocation import scale_to_limits
from ftac_gym.baselines.components.relative_motion import RelativeMotion
from ftac_gym.baselines.controllers.fault_tolerant import FaultTolerantController, FaultTolerantGains
from ftac_gym.baselines.controllers.filtered import FilteredController
from ftac_gym.baselines.controllers.scaled import ScaledController
from ftac_gym.baselines.estimate import FaultEstimate
from ftac_gym.baselines.gains import changed, fixed
from ftac_gym.baselines.observers.attitude_filter import AttitudeFilterGains
from ftac_gym.task.measurement import Measurement
from ftac_gym.utils.parameters import FloatArray, require


def _mrp(motion: RelativeMotion) -> FloatArray:
    """Return sigma_e (N, 3)."""
    return motion.error[:, 1:] / (1.0 + motion.error[:, :1])


@dataclass(frozen=True)
class RelativeGains(AttitudeFilterGains, FaultTolerantGains):
    """Gains of :class:`RelativeController`."""

    smallest_effectiveness: float = fixed(0.05)
    attitude_filter_time: float = changed(AttitudeFilterGains, "attitude_filter_time", 1.0)


class RelativeController(ScaledController, FaultTolerantController, FilteredController):
    """A fault-tolerant controller for sampled, saturating, noisy spacecraft; a subclass defines the acceleration.

    With the error MRP sigma_e of q_e = conj(q_d) (x) q, always on the short branch, and w_e = w - C(q_e) w_d::

        torque = J (w_e' + C w_d' - w_e x C w_d) + w x J w - D b^    (or - d^ from an observer without b^)

    where w_e' is the subclass's. Neither branch switching nor the rate of the reference enters the law then. The wheels
    get the command with the smallest largest share. The torque that weak wheels fail to give by their estimated
    effectiveness is added by the others. All are scaled together at the limits, which keeps the direction of the
    torque.
    """

    gains = RelativeGains()
    takes_torques: ClassVar[bool] = True

    def _build(self) -> None:
        estimator = None if self._navigator is None else self._navigator.estimator
        alone = estimator is None or self.gains.faults == "none"
        require(alone, "faults", "must be 'none' with an isolation of faulty wheels", self.gains.faults)
        super()._build()

    @abstractmethod
    def _variable(self, measurement: Measurement, error: FloatArray, rate_error: FloatArray) -> FloatArray:
        """Return s (N, 3) for sigma_e and w_e, each (N, 3); the memory is unchanged."""

    @abstractmethod
    def _acceleration(self, measurement: Measurement, error: FloatArray, rate_error: FloatArray) -> FloatArray:
        """Return the demanded w_e' (N, 3) [rad/s^2] for sigma_e and w_e, each (N, 3)."""

    def sliding_variable(self, measurement: Measurement) -> FloatArray:
        """Return s (N, 3) at a measurement, for its unfiltered attitude."""
        motion = self._motion(measurement, move_on=False)
        return self._variable(measurement, _mrp(motion), motion.rate_error)

    def act(self, measurement: Measurement) -> FloatArray:
        """Return the wheel torques to command, (N, wheels) [N m]."""
        motion = self._motion(measurement, move_on=True)
        acceleration = self._acceleration(measurement, _mrp(motion), motion.rate_error)
        if self._moving:
            acceleration = acceleration + motion.feed_forward(measurement)
        torque = acceleration @ self._inertia
        torque += self._gyroscopic.torque(measurement.rate, measurement.wheel_momentum)
        if self.plant is None:
            command = self._to_wheels_evenly(torque, self._faults.update(measurement))
        else:
            command = self._to_usable_wheels(torque, self.plant)
        return scale_to_limits(command, self._torque_limits)

    @property
    def estimate(self) -> FaultEstimate | None:
        """The latest estimate of the isolation or of the observer, or the truth of an oracle; None without any."""
        own = None if self._navigator is None else self._navigator.estimate
        return super().estimate if own is None else own
