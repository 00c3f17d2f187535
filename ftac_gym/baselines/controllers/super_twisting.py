"""Adaptive super-twisting sliding mode control about the slew profile."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ftac_gym.baselines.controllers.profile import ProfileController, ProfileGains
from ftac_gym.baselines.estimate import FaultEstimate
from ftac_gym.baselines.gains import Range, changed, parameter
from ftac_gym.baselines.units import LOOPS, PER_LOOP, Unit
from ftac_gym.task.measurement import Measurement
from ftac_gym.utils.parameters import FloatArray, non_negative, positive, require

RATE = Unit("A L", "rad/s", acceleration=1, loop_time=1)
"""The rate that the wheels reach in the time of the loop."""


@dataclass(frozen=True)
class SuperTwistingGains(ProfileGains):
    """Gains of :class:`SuperTwisting`."""

    braking_share: float = changed(ProfileGains, "braking_share", 0.84)
    position_gain: float = parameter(0.65, "c", PER_LOOP, positive, Range(0.1, 1.2), (0.1, 1.2))
    step: float = parameter(
        0.55, "Step h of the implicit law", LOOPS, positive, Range(0.42, 4.0, log=True), (0.42, 4.0)
    )
    integral_step: float = parameter(
        10.0, "Step h_v of its integral", LOOPS, positive, Range(4.0, 60.0, log=True), (4.0, 60.0)
    )
    least_gain: float = parameter(4.0, "Lower bound of alpha", "sqrt(A/L)", positive, Range(0.2, 8.0, log=True))
    largest_gain: float = parameter(10.0, "Upper bound of alpha", "sqrt(A/L)", positive)
    adaptation: float = parameter(
        0.01, "Growth and decrease of alpha, of sqrt(A/L)", PER_LOOP, non_negative, Range(0.001, 0.2, log=True)
    )
    accuracy: float = parameter(0.02, "mu, above which alpha grows", RATE, positive, Range(0.01, 1.0, log=True))
    integral_ratio: float = parameter(
        0.003, "Slope of the integral over alpha, with alpha of sqrt(A/L) and slope of A/L", "", positive,
        Range(0.001, 0.5, log=True),
    )  # fmt: skip

    def __post_init__(self) -> None:
        """Check the bounds of alpha too."""
        super().__post_init__()
        rule = f"must be above least_gain = {self.least_gain!r}"
        require(self.largest_gain > self.least_gain, "largest_gain", rule, self.largest_gain)


class SuperTwisting(ProfileController):
    """Adaptive-gain super-twisting control of the rate error about the slew profile.

    With the rate s_p(theta) that the profile demands along n, its deceleration s_p', and for each body axis::

        s = w_e + s_p n,
        J^-1 torque = s_p' n - alpha |s|^(1/2) sign(s) + v + feed-forward of the reference,
        v' = -beta / 2 sign(s),    beta = 2 epsilon alpha,
        alpha' = +- rate: up where |s| > mu, down to its lower bound elsewhere

    (Shtessel, Taleb and Plestan 2012). Sampled as it stands, the square root has an infinite slope at s = 0 and
    chatters. Both terms are therefore taken at the end of a step instead of at its start (implicit Euler method;
    Brogliato, Polyakov and Efimov 2020), each by itself::

        s+ + h alpha |s+|^(1/2) sign(s+) = s,    alpha |s+|^(1/2) = 2 alpha |s| / (h alpha + sqrt((h alpha)^2 + 4 |s|)),
        sign(s) of v' becomes the saturation of s / (h h_v beta / 2)

    Near s = 0 the law is linear: -s / h + v with v' = -s / (h h_v), so that the time of the loop sets h. With h_v
    above 4 h its poles are real. One step for both, as in the reference, has a damping ratio of one half and needs
    more bandwidth than a loop with delay has.

    In saturation alpha and v keep their values: an error that the wheels are about to remove needs no larger gain.

    Raises
    ------
    ValueError
        If a gain breaks a rule or a wheel has no torque limit.
    """

    gains = SuperTwistingGains()

    def _build(self) -> None:
        super()._build()
        # The integral slope of one unit; alpha of one unit is sqrt(A / L).
        self._slope = self.scales.acceleration / self.scales.loop_time
        self.memory.add("alpha", (3,), initial=self.gains.least_gain * np.sqrt(self._slope))
        self.memory.add("integral", (3,))

    def act(self, measurement: Measurement) -> FloatArray:
        """Return the wheel torques to command, (N, wheels) [N m]."""
        own: SuperTwistingGains = self.scheduled
        motion = self._motion(measurement, move_on=True)
        slew = self._slew(motion.error, own.position_gain)
        variable = motion.rate_error + slew.speed * slew.axis
        alpha, integral = self.memory["alpha"], self.memory["integral"]
        damped, size = own.step * alpha, np.abs(variable)
        reaching = 2.0 * alpha * variable / (damped + np.sqrt(damped * damped + 4.0 * size))
        acceleration = slew.deceleration * slew.axis - reaching + integral
        if self._moving:
            acceleration += motion.feed_forward(measurement)
        command = self._to_wheels(self._torque(acceleration) + self._gyroscopic_torque(measurement))
        self._adapt(variable, size, command)
        return command

    def _adapt(self, variable: FloatArray, size: FloatArray, command: FloatArray) -> None:
        """Move alpha and the integral on by one control period."""
        own: SuperTwistingGains = self.scheduled
        memory, unit = self.memory, np.sqrt(self._slope)
        alpha, integral = memory["alpha"], memory["integral"]
        slope = own.integral_ratio * unit * alpha
        inside = np.clip(variable / (own.step * own.integral_step * slope), -1.0, 1.0)
        change = np.where(size > own.accuracy, own.adaptation, -own.adaptation) * (unit * self._period)
        saturated = (np.abs(command) >= (1.0 - 1e-9) * self._limits_in_use()).any(axis=1, keepdims=True)
        adapted = np.clip(alpha + change, own.least_gain * unit, own.largest_gain * unit)
        memory["alpha"] = np.where(saturated, alpha, adapted)
        memory["integral"] = np.where(saturated, integral, integral - self._period * slope * inside)

    @property
    def estimate(self) -> FaultEstimate:
        """The torque that the integral cancels, and the estimate of the isolation."""
        return self._estimate_with(-self._torque(self.memory["integral"]))
