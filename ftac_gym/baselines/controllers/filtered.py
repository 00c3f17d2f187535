"""Base of the controllers with an attitude filter."""

from __future__ import annotations

from ftac_gym.baselines.baseline import Baseline
from ftac_gym.baselines.components.relative_motion import RelativeMotion, relative_motion
from ftac_gym.baselines.observers.attitude_filter import AttitudeFilter, AttitudeFilterGains
from ftac_gym.task.measurement import Measurement


class FilteredController(Baseline):
    """A controller of the errors of filtered attitude and measured rate."""

    gains = AttitudeFilterGains()

    def _build(self) -> None:
        super()._build()
        self._filter = AttitudeFilter(self.scenario, self.memory, self.gains.attitude_filter_time)

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
