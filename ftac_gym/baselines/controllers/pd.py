"""Proportional-derivative attitude control with a braking profile, and the same with a disturbance observer."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from ftac_gym.baselines.controllers.profile import ProfileController, ProfileGains
from ftac_gym.baselines.estimate import FaultEstimate
from ftac_gym.baselines.gains import Range, Share, changed, parameter
from ftac_gym.baselines.observers.disturbance_observer import DisturbanceObserver
from ftac_gym.baselines.units import PER_LOOP
from ftac_gym.task.measurement import Measurement
from ftac_gym.utils.parameters import FloatArray, positive


@dataclass(frozen=True)
class PDGains(ProfileGains):
    """Gains of :class:`PD`.

    Without a loop delay, or with one control period of it, the sampled rate loop is stable below a rate gain of 2 / L.
    Filter and observer use a part of that margin. Behind the prediction there is no delay, and the search goes up to
    2.4 / L.
    """

    braking_share: float = changed(ProfileGains, "braking_share", 0.7066)
    rate_limit: float = changed(ProfileGains, "rate_limit", 1.485452)
    rate_gain: float = parameter(1.2324, "c_d", PER_LOOP, positive, Range(0.2, 2.4), schedule=(0.4, 2.4))
    position_gain: float = parameter(
        0.4968, "c_p", PER_LOOP, positive, Range(0.1, 0.8), (0.2, 0.8), Share("position_share", of="rate_gain")
    )
    attitude_filter_time: float = changed(ProfileGains, "attitude_filter_time", 3.008)


class PD(ProfileController):
    """Quaternion PD control that brakes in time.

    With the error angle theta about the axis n (short way) and the rate error w_e, all in body axes::

        torque = J (n s s' + c_d (-n s - w_e)) + feed-forward of the reference

    where s(theta) is the demanded rate of decrease of the error, at most the rate limit. It is c_p theta near the
    target, and sqrt(2 a (theta - a / (2 c_p^2))) beyond theta = a / c_p^2, so that the braking never exceeds a.
    Near the target this is the PD law of stiffness c_p (c_d - c_p) J and damping c_d J. The deceleration a is a share
    of the largest that the usable wheels can give about n. Wheel torques beyond the limits are scaled together, which
    keeps the direction of the torque.

    Raises
    ------
    ValueError
        If a gain breaks a rule or a wheel has no torque limit.
    """

    gains = PDGains()

    def act(self, measurement: Measurement) -> FloatArray:
        """Return the wheel torques to command, (N, wheels) [N m]."""
        return self._to_wheels(self._demand(measurement))

    def _demand(self, measurement: Measurement) -> FloatArray:
        """Return the torque demanded on the body, (N, 3) [N m]."""
        return self._torque(self._demanded_acceleration(measurement)) + self._gyroscopic_torque(measurement)

    def _demanded_acceleration(self, measurement: Measurement) -> FloatArray:
        """Return the demanded angular acceleration, (N, 3) [rad/s^2]."""
        gains: PDGains = self.scheduled
        motion = self._motion(measurement, move_on=True)
        slew = self._slew(motion.error, gains.position_gain)
        along = (slew.deceleration - gains.rate_gain * slew.speed) * slew.axis
        acceleration = along - gains.rate_gain * motion.rate_error
        if self._moving:
            acceleration += motion.feed_forward(measurement)
        return acceleration


@dataclass(frozen=True)
class PDDisturbanceObserverGains(PDGains):
    """Gains of :class:`PDDisturbanceObserver`."""

    bandwidth: float = parameter(
        0.07794, "Bandwidth of the observer", PER_LOOP, positive, Range(0.04, 1.0), (0.04, 1.0)
    )


class PDDisturbanceObserver(PD):
    """PD control that subtracts the torque estimated by a disturbance observer."""

    gains = PDDisturbanceObserverGains()

    def _build(self) -> None:
        super()._build()
        self._observer = DisturbanceObserver(self.scenario, self.memory, self.scheduled.bandwidth, self._gyroscopic)

    def _schedule(self, gains: Mapping[str, FloatArray]) -> None:
        super()._schedule(gains)
        self._observer.set_bandwidth(self.scheduled.bandwidth)

    def act(self, measurement: Measurement) -> FloatArray:
        """Return the wheel torques to command, (N, wheels) [N m]."""
        residual = None if self.plant is None else self.plant.residual
        return self._to_wheels(self._demand(measurement) - self._observer.update(measurement, residual))

    @property
    def estimate(self) -> FaultEstimate:
        """The estimated torque, and that of the isolation."""
        return self._estimate_with(self._observer.disturbance)
