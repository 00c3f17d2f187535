"""Base of the controllers that turn to the target along the slew profile."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from ftac_gym.attitude import cross
from ftac_gym.baselines.components.allocation import pseudo_inverse, scale_to_limits
from ftac_gym.baselines.components.gyroscopic import GyroscopicModel
from ftac_gym.baselines.components.slew_profile import SlewDemand, SlewProfile
from ftac_gym.baselines.controllers.direct import DirectController
from ftac_gym.baselines.controllers.scaled import ScaledController
from ftac_gym.baselines.estimate import FaultEstimate
from ftac_gym.baselines.gains import Range, changed, parameter
from ftac_gym.baselines.observers.attitude_filter import AttitudeFilterGains
from ftac_gym.baselines.rules import at_most, choice, interval
from ftac_gym.baselines.units import SPEED
from ftac_gym.task.measurement import Measurement
from ftac_gym.utils.parameters import FloatArray, flag, non_negative, positive


@dataclass(frozen=True)
class ProfileGains(AttitudeFilterGains):
    """Gains of :class:`ProfileController`."""

    attitude_filter_time: float = changed(AttitudeFilterGains, "attitude_filter_time", 3.0)
    braking_share: float = parameter(
        0.7, "Share of the available deceleration", "", at_most(1.0), Range(0.2, 1.0), (0.4, 1.0)
    )
    rate_limit: float = parameter(
        1.449, "Largest commanded slew rate", SPEED, positive, Range(0.4, 2.6), schedule=(0.5, 2.6)
    )
    momentum_share: float = parameter(
        0.92,
        "Share of the torque that the gyroscopic torque of the stored momentum may take, where that is estimated",
        rule=interval(0.0, 1.0),
    )
    plant_braking: bool = parameter(
        True, "Whether braking and rate limit follow the estimated plant, not the nominal one", rule=flag
    )
    calm_share: float = parameter(
        0.5,
        "Share of the success cone within which the demanded rate is at most half of the largest rate of success",
        "",
        non_negative,
        Range(0.0, 0.9),
    )
    torque_share: float = parameter(
        1.0, "Share of the torque limits that healthy wheels use", "", at_most(1.0), Range(0.4, 1.0)
    )
    isolation: str = changed(AttitudeFilterGains, "isolation", "auto")
    allocation: str = parameter("minimax", "Allocation to the wheels", rule=choice("minimax", "pseudo_inverse"))
    telemetry: bool = parameter(False, "Whether the gyroscopic torque uses the measured wheel momentum", rule=flag)


class ProfileController(ScaledController, DirectController):
    """A controller along the slew profile; the torque is defined by the subclass.

    Raises
    ------
    ValueError
        If a gain breaks a rule or a wheel has no torque limit.
    """

    gains = ProfileGains()
    needs_torque_limits: ClassVar[bool] = True

    def _build(self) -> None:
        super()._build()
        wheels, pseudo = self.scenario.spacecraft.wheels, self.gains.allocation == "pseudo_inverse"
        self._inverse = pseudo_inverse(wheels.axis_matrix).T if pseudo else None
        self._gyroscopic = GyroscopicModel(self.scenario, self.gains.telemetry)
        self._profile = SlewProfile(wheels, self._inertia, self._minimax)

    def _slew(
        self, error: FloatArray, position_gain: float | FloatArray, stiffness: float | FloatArray | None = None
    ) -> SlewDemand:
        """Return the demanded motion for errors (N, 4), a slope near the target [1/s] and a stiffness [1/s^2]."""
        gains: ProfileGains = self.scheduled
        # A law that lags behind the profile asks at a shifted angle, and is calm by itself.
        calm = gains.calm_share * self.scenario.success.angle if stiffness is None else 0.0
        limits = gains.rate_limit, gains.braking_share, gains.momentum_share
        plant = self.plant if gains.plant_braking else None
        return self._profile(error, position_gain, *limits, plant, calm, 0.5 * self.scenario.success.rate, stiffness)

    def _torque(self, acceleration: FloatArray) -> FloatArray:
        """Return the inertia times accelerations (N, 3) [rad/s^2], (N, 3) [N m]."""
        return acceleration @ self._inertia if self.plant is None else self.plant.torque_of(acceleration, self._inertia)

    def _gyroscopic_torque(self, measurement: Measurement) -> FloatArray:
        """Return w x (J w + D h) (N, 3) [N m] as far as the momentum is estimated or measured."""
        if self.plant is None or self.plant.momentum is None:
            return self._gyroscopic.torque(measurement.rate, measurement.wheel_momentum)
        return cross(measurement.rate, self.plant.momentum)

    def _to_wheels(self, torque: FloatArray) -> FloatArray:
        if self.plant is None:
            command = self._minimax(torque) if self._inverse is None else torque @ self._inverse
        else:
            command = self._to_usable_wheels(torque, self.plant)
        return scale_to_limits(command, self._limits_in_use())

    def _limits_in_use(self) -> FloatArray:
        """Return the share of the torque limits that commands may take, (m,) or (N, m) [N m]."""
        share: float | FloatArray = self.gains.torque_share
        plant = self.plant
        if plant is not None and plant.usable is not None and plant.missing_torque is not None:
            # What a faulty wheel takes from the others is not to be saved.
            faulty = (plant.usable < 1.0).any(axis=1) | (plant.missing_torque != 0.0).any(axis=1)
            share = np.where(faulty[:, None], 1.0, share)
        limits: FloatArray = share * self._torque_limits
        return limits

    def _estimate_with(self, disturbance: FloatArray) -> FaultEstimate:
        """Return the estimate of the isolation, if there is one, with an unexplained torque (N, 3) [N m]."""
        isolated = None if self._navigator is None else self._navigator.estimate
        return FaultEstimate(disturbance) if isolated is None else replace(isolated, disturbance=disturbance)
