"""Controllers that compute a torque from the errors, without an estimate of the faults."""

from __future__ import annotations

from ftac_gym.baselines.baseline import Baseline
from ftac_gym.baselines.components.allocation import MinimaxAllocation, within_limits
from ftac_gym.baselines.components.relative_motion import RelativeMotion, relative_motion
from ftac_gym.baselines.observers.attitude_filter import AttitudeFilter, AttitudeFilterGains
from ftac_gym.task.measurement import Measurement
from ftac_gym.utils.parameters import FloatArray


class DirectController(Baseline):
    """Attitude filter, errors and wheels of a controller; the torque is defined by the subclass.

    Three wheels are limited one by one, as in the papers. Redundant wheels get the command with the smallest largest
    share and are scaled together at the limits, which keeps the direction of the torque.
    """

    gains = AttitudeFilterGains()

    def _build(self) -> None:
        super()._build()
        self._minimax = MinimaxAllocation(self.scenario.spacecraft.wheels)
        self._filter = AttitudeFilter(self.scenario, self.memory, self.gains.attitude_filter_time)

    def _motion(self, measurement: Measurement, move_on: bool, short_way: bool) -> RelativeMotion:
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

    def _to_wheels(self, torque: FloatArray) -> FloatArray:
        """Return wheel torques (N, m) [N m] within the limits for a torque (N, 3) [N m] on the body."""
        return within_limits(self._minimax(torque), self._torque_limits)
