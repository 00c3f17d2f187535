"""Proportional-derivative attitude control with a braking profile, and the same with a disturbance observer."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ftac_gym.baselines.components.allocation import pseudo_inverse, scale_to_limits
from ftac_gym.baselines.components.gyroscopic import GyroscopicModel
from ftac_gym.baselines.components.rows import length
from ftac_gym.baselines.controllers.direct import DirectController
from ftac_gym.baselines.estimate import FaultEstimate
from ftac_gym.baselines.gains import Range, Share, changed, parameter
from ftac_gym.baselines.observers.attitude_filter import AttitudeFilterGains
from ftac_gym.baselines.observers.disturbance_observer import DisturbanceObserver
from ftac_gym.baselines.rules import at_most, choice, flag
from ftac_gym.task.measurement import Measurement
from ftac_gym.utils.parameters import FloatArray, positive


@dataclass(frozen=True)
class PDGains(AttitudeFilterGains):
    """Gains of :class:`PD`.

    With one control period of loop delay, the sampled rate loop of a 10 Hz controller is stable below a rate gain of
    10 1/s. Filter and observer use a part of that margin; the search goes up to 8 1/s. The values are those that it
    found on the flagship.
    """

    braking_share: float = parameter(
        0.7066, "Share of the available deceleration", "", at_most(1.0), Range(0.2, 1.0), (0.4, 1.0)
    )
    rate_limit: float = parameter(
        0.1743, "Largest commanded slew rate", "rad/s", positive, Range(0.05, 0.3), schedule=(0.08, 0.3)
    )
    rate_gain: float = parameter(6.162, "c_d", "1/s", positive, Range(0.5, 8.0), schedule=(2.0, 8.0))
    position_gain: float = parameter(
        2.484, "c_p", "1/s", positive, Range(0.1, 0.8), (0.2, 0.8), Share("position_share", of="rate_gain")
    )
    attitude_filter_time: float = changed(AttitudeFilterGains, "attitude_filter_time", 3.008, search=Range(0.1, 5.0))
    allocation: str = parameter("minimax", "Allocation to the wheels", rule=choice("minimax", "pseudo_inverse"))
    telemetry: bool = parameter(False, "Whether the gyroscopic torque uses the measured wheel momentum", rule=flag)


class PD(DirectController):
    """Quaternion PD control that brakes in time.

    With the error angle theta about the axis n (short way) and the rate error w_e, all in body axes::

        torque = J (n s s' + c_d (-n s - w_e)) + feed-forward of the reference

    where s(theta) is the demanded rate of decrease of the error, at most the rate limit. It is c_p theta near the
    target, and sqrt(2 a (theta - a / (2 c_p^2))) beyond theta = a / c_p^2, so that the braking never exceeds a.
    Near the target this is the PD law of stiffness c_p (c_d - c_p) J and damping c_d J. The deceleration a is a share
    of the largest that healthy wheels can give about n. Wheel torques beyond the limits are scaled together, which
    keeps the direction of the torque.

    Raises
    ------
    ValueError
        If a gain breaks a rule or a wheel has no torque limit.
    """

    gains = PDGains()
    needs_torque_limits: ClassVar[bool] = True

    def _build(self) -> None:
        super()._build()
        axes, pseudo = self.scenario.spacecraft.wheels.axis_matrix, self.gains.allocation == "pseudo_inverse"
        self._inverse = pseudo_inverse(axes).T if pseudo else None
        self._gyroscopic = GyroscopicModel(self.scenario, self.gains.telemetry)

    def act(self, measurement: Measurement) -> FloatArray:
        """Return the wheel torques to command, (N, wheels) [N m]."""
        return self._to_wheels(self._demand(measurement))

    def _demand(self, measurement: Measurement) -> FloatArray:
        """Return the torque demanded on the body, (N, 3) [N m]."""
        gains: PDGains = self.scheduled
        motion = self._motion(measurement, move_on=True)
        error, rate_error = motion.error, motion.rate_error
        vector = error[:, 1:]
        sine = length(vector)
        angle = 2.0 * np.arctan2(sine, error[:, :1])
        axis = vector / np.maximum(sine, 1e-12)
        # The acceleration that the wheels can give about the axis: inverse of the share of their limits for 1 rad/s^2.
        per_acceleration = np.abs(self._minimax(axis @ self._inertia)) / self._torque_limits
        braking = gains.braking_share / np.maximum(per_acceleration.max(axis=1, keepdims=True), 1e-12)
        gain = gains.position_gain
        linear = braking / (gain * gain)
        far = angle > linear
        speed = np.where(far, np.sqrt(2.0 * braking * np.maximum(angle - 0.5 * linear, 0.0)), gain * angle)
        deceleration = np.where(far, braking, gain * gain * angle)
        fast = speed > gains.rate_limit
        speed = np.where(fast, gains.rate_limit, speed)
        deceleration = np.where(fast, 0.0, deceleration)
        acceleration = (deceleration - gains.rate_gain * speed) * axis - gains.rate_gain * rate_error
        if self._moving:
            acceleration += motion.feed_forward(measurement)
        torque = acceleration @ self._inertia
        return torque + self._gyroscopic.torque(measurement.rate, measurement.wheel_momentum)

    def _to_wheels(self, torque: FloatArray) -> FloatArray:
        command = self._minimax(torque) if self._inverse is None else torque @ self._inverse
        return scale_to_limits(command, self._torque_limits)


@dataclass(frozen=True)
class PDDisturbanceObserverGains(PDGains):
    """Gains of :class:`PDDisturbanceObserver`."""

    bandwidth: float = parameter(0.3897, "Bandwidth of the observer", "rad/s", positive, Range(0.2, 5.0), (0.2, 5.0))


class PDDisturbanceObserver(PD):
    """PD control that subtracts the torque estimated by a disturbance observer."""

    gains = PDDisturbanceObserverGains()

    def _build(self) -> None:
        super()._build()
        self._observer = DisturbanceObserver(self.scenario, self.memory, self.gains.bandwidth, self._gyroscopic)

    def _schedule(self, gains: Mapping[str, FloatArray]) -> None:
        super()._schedule(gains)
        self._observer.set_bandwidth(self.scheduled.bandwidth)

    def act(self, measurement: Measurement) -> FloatArray:
        """Return the wheel torques to command, (N, wheels) [N m]."""
        return self._to_wheels(self._demand(measurement) - self._observer.update(measurement))

    @property
    def estimate(self) -> FaultEstimate:
        """The estimated torque."""
        return FaultEstimate(disturbance=self._observer.disturbance)
