"""Base of the controllers behind the estimators of attitude, rate and plant."""

from __future__ import annotations

from ftac_gym.baselines.baseline import Baseline
from ftac_gym.baselines.components.allocation import UsableAllocation
from ftac_gym.baselines.components.relative_motion import RelativeMotion, relative_motion
from ftac_gym.baselines.components.slew_profile import PlantEstimate
from ftac_gym.baselines.observers.attitude_filter import AttitudeFilter, AttitudeFilterGains
from ftac_gym.task.measurement import Measurement
from ftac_gym.utils.parameters import FloatArray


class FilteredController(Baseline):
    """A controller of the errors of filtered attitude and rate, on the estimated plant.

    The attitude is that of the Kalman filter, or without it that of a filter with a fixed gain.
    """

    gains = AttitudeFilterGains()
    plant: PlantEstimate | None = None
    """Estimate of the plant for the present call, which the estimators set; None for the nominal one."""

    def _build(self) -> None:
        super()._build()
        kalman = self._navigator is not None and self._navigator.filter is not None
        self._filter = AttitudeFilter(self.scenario, self.memory, 0.0 if kalman else self.gains.attitude_filter_time)
        isolates = self._navigator is not None and self._navigator.estimator is not None
        self._usable = UsableAllocation(self.scenario.spacecraft.wheels) if isolates else None

    def _navigated(self, measurement: Measurement) -> Measurement:
        if self._navigator is None:
            return measurement
        navigated, self.plant = self._navigator.update(measurement)
        return navigated

    def _motion(self, measurement: Measurement, move_on: bool, short_way: bool = True) -> RelativeMotion:
        """Return the errors for the filtered attitude, or for the measured one without a change of the memory.

        Parameters
        ----------
        measurement
            The measurement.
        move_on
            Whether the attitude filter takes in the measurement.
        short_way
            Whether the error is the quaternion with q_e0 >= 0; else its sign is that of the two attitudes.
        """
        attitude = self._filter.update(measurement) if move_on else measurement.attitude
        return relative_motion(attitude, measurement, self._moving, short_way)

    def _to_usable_wheels(self, torque: FloatArray, plant: PlantEstimate) -> FloatArray:
        """Return wheel torques (N, m) [N m], not limited, for a torque (N, 3) [N m] on the body of an estimated plant.

        Faulty wheels whose torque does not follow the command are left out, and the torque that they give is taken off.
        """
        assert self._usable is not None  # There is an estimate of the plant.
        if plant.missing_torque is not None:
            torque = torque - plant.missing_torque
        return self._usable(torque, plant.usable)
