"""Proportional-derivative attitude control with a braking profile, and the same with a disturbance observer."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from ftac_gym.baselines.baseline import Baseline
from ftac_gym.baselines.components.allocation import MinimaxAllocation, pseudo_inverse, scale_to_limits
from ftac_gym.baselines.components.gyroscopic import GyroscopicModel
from ftac_gym.baselines.components.relative_motion import relative_motion
from ftac_gym.baselines.estimate import FaultEstimate
from ftac_gym.baselines.gains import Range, SearchSpace, scheduled_share
from ftac_gym.baselines.observers.attitude_filter import AttitudeFilter
from ftac_gym.baselines.observers.disturbance_observer import DisturbanceObserver
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, positive, require


class PD(Baseline):
    """Quaternion PD control that brakes in time.

    With the error angle theta about the axis n (short way) and the rate error w_e, all in body axes:

        torque = J (n s s' + c_d (-n s - w_e)) + feed-forward of the reference

    where s(theta) is the rate at which the error shall shrink: c_p theta near the target, and sqrt(2 a (theta -
    a / (2 c_p^2))) beyond theta = a / c_p^2, so that the braking it asks for never exceeds a; at most the rate limit.
    Near the target this is the PD law of stiffness c_p (c_d - c_p) J and damping c_d J. The deceleration a is a share
    of what the healthy wheels can give about n. Wheel torques beyond the limits are scaled together, which keeps the
    direction of the torque.

    Parameters
    ----------
    scenario, num_spacecraft
        As for every baseline.
    position_gain
        c_p [1/s], below c_d.
    rate_gain
        c_d [1/s].
    braking_share
        Share of the available deceleration that the profile uses.
    rate_limit
        Largest commanded slew rate [rad/s].
    attitude_filter_time
        Time constant of the attitude filter [s]; zero uses the star tracker as it comes.
    allocation
        ``"minimax"`` or ``"pseudo_inverse"``.
    telemetry
        Whether to use the measured wheel momentum for the gyroscopic torque.

    Raises
    ------
    ValueError
        If a gain breaks a rule or a wheel has no torque limit.
    """

    # The sampled rate loop of a 10 Hz controller is stable below a rate gain of 20 1/s. Searching up to 8 1/s keeps a
    # gain margin of 8 dB, of which the observer takes its part: gains that only work on a perfect wheel are no use.
    search_space: ClassVar[SearchSpace] = {
        "rate_gain": Range(0.5, 8.0),
        "position_share": Range(0.1, 0.8),
        "braking_share": Range(0.2, 1.0),
        "rate_limit": Range(0.05, 0.3),
        "attitude_filter_time": Range(0.1, 5.0),
    }
    shares: ClassVar = {"position_share": ("position_gain", "rate_gain")}
    schedulable: ClassVar[Mapping[str, tuple[float, float]]] = {
        "braking_share": (0.4, 1.0),
        "rate_limit": (0.08, 0.3),
        "rate_gain": (3.0, 9.5),
        "position_share": (0.2, 0.8),
    }

    def __init__(
        self,
        scenario: Scenario,
        num_spacecraft: int = 1,
        position_gain: float = 3.9498,
        rate_gain: float = 7.7145,
        braking_share: float = 0.7234,
        rate_limit: float = 0.1659,
        attitude_filter_time: float = 1.7035,
        allocation: str = "minimax",
        telemetry: bool = False,
    ) -> None:
        super().__init__(scenario, num_spacecraft)
        # The gains in use; scheduled ones are arrays (N, 1).
        self._position_gain: float | FloatArray = positive(position_gain, "position_gain")
        self._rate_gain: float | FloatArray = positive(rate_gain, "rate_gain")
        require(position_gain < rate_gain, "position_gain", f"must be below rate_gain = {rate_gain!r}", position_gain)
        self._braking_share: float | FloatArray = positive(braking_share, "braking_share")
        require(braking_share <= 1.0, "braking_share", "must not exceed 1", braking_share)
        self._rate_limit: float | FloatArray = positive(rate_limit, "rate_limit")
        self._own = {
            "position_gain": float(position_gain),
            "rate_gain": float(rate_gain),
            "braking_share": float(braking_share),
            "rate_limit": float(rate_limit),
        }
        wheels = scenario.spacecraft.wheels
        self._torque_limits = wheels.torque_limits
        limited = bool(np.isfinite(self._torque_limits).all())
        require(limited, "torque_limit", "must be finite for every wheel", self._torque_limits.tolist())
        self._inertia = scenario.spacecraft.inertia_matrix
        self._moving = scenario.reference.moving
        known = ("minimax", "pseudo_inverse")
        require(allocation in known, "allocation", f"must be one of {list(known)}", allocation)
        self._minimax = MinimaxAllocation(wheels)
        self._inverse = pseudo_inverse(wheels.axis_matrix).T if allocation == "pseudo_inverse" else None
        self._filter = AttitudeFilter(scenario, self.memory, attitude_filter_time)
        self._gyroscopic = GyroscopicModel(scenario, telemetry)

    def _schedule(self, gains: Mapping[str, FloatArray]) -> None:
        own = self._own
        self._rate_gain, self._braking_share, self._rate_limit = (
            gains.get(name, own[name]) for name in ("rate_gain", "braking_share", "rate_limit")
        )
        position, rate = own["position_gain"], own["rate_gain"]
        share = gains.get("position_share", position / rate)
        self._position_gain = scheduled_share(position, rate, share, self._rate_gain)

    def act(self, measurement: Measurement) -> FloatArray:
        """Return the wheel torques to command, (N, wheels) [N m]."""
        return self._allocate(self._demand(measurement))

    def _demand(self, measurement: Measurement) -> FloatArray:
        """Return the torque wanted on the body, (N, 3) [N m]."""
        motion = relative_motion(self._filter.update(measurement), measurement, self._moving)
        error, rate_error = motion.error, motion.rate_error
        vector = error[:, 1:]
        sine = np.sqrt(np.einsum("ij,ij->i", vector, vector))[:, None]
        angle = 2.0 * np.arctan2(sine, error[:, :1])
        axis = vector / np.maximum(sine, 1e-12)
        # What the wheels can give about the axis: the share of their limits that one rad/s^2 would take, inverted.
        per_acceleration = np.abs(self._minimax(axis @ self._inertia)) / self._torque_limits
        braking = self._braking_share / np.maximum(per_acceleration.max(axis=1, keepdims=True), 1e-12)
        gain = self._position_gain
        linear = braking / (gain * gain)
        far = angle > linear
        speed = np.where(far, np.sqrt(2.0 * braking * np.maximum(angle - 0.5 * linear, 0.0)), gain * angle)
        deceleration = np.where(far, braking, gain * gain * angle)
        fast = speed > self._rate_limit
        speed = np.where(fast, self._rate_limit, speed)
        deceleration = np.where(fast, 0.0, deceleration)
        acceleration = (deceleration - self._rate_gain * speed) * axis - self._rate_gain * rate_error
        if self._moving:
            acceleration += motion.feed_forward(measurement)
        torque = acceleration @ self._inertia
        demand: FloatArray = torque + self._gyroscopic.torque(measurement.rate, measurement.wheel_momentum)
        return demand

    def _allocate(self, torque: FloatArray) -> FloatArray:
        command = self._minimax(torque) if self._inverse is None else torque @ self._inverse
        return scale_to_limits(command, self._torque_limits)


class PDDisturbanceObserver(PD):
    """PD control that takes away the torque that a disturbance observer sees.

    Parameters
    ----------
    bandwidth
        Bandwidth of the observer [rad/s].
    **gains
        Those of :class:`PD`.
    """

    search_space: ClassVar[SearchSpace] = {**PD.search_space, "bandwidth": Range(0.2, 5.0)}
    schedulable: ClassVar = {**PD.schedulable, "bandwidth": (0.5, 20.0)}

    def __init__(
        self,
        scenario: Scenario,
        num_spacecraft: int = 1,
        bandwidth: float = 4.5602,
        telemetry: bool = False,
        **gains: Any,
    ) -> None:
        super().__init__(scenario, num_spacecraft, telemetry=telemetry, **gains)
        self._observer = DisturbanceObserver(scenario, self.memory, bandwidth, self._gyroscopic)

    def _schedule(self, gains: Mapping[str, FloatArray]) -> None:
        super()._schedule(gains)
        self._observer.set_bandwidth(gains.get("bandwidth"))

    def act(self, measurement: Measurement) -> FloatArray:
        """Return the wheel torques to command, (N, wheels) [N m]."""
        return self._allocate(self._demand(measurement) - self._observer.update(measurement))

    @property
    def estimate(self) -> FaultEstimate:
        """The estimated torque."""
        return FaultEstimate(disturbance=self._observer.disturbance)
