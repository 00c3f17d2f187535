"""Laws that ask for a torque straight from the errors, without an estimate of the faults."""

from __future__ import annotations

from ftac_gym.baselines.baseline import Baseline
from ftac_gym.baselines.components.allocation import MinimaxAllocation, limit_each, scale_to_limits
from ftac_gym.baselines.components.relative_motion import RelativeMotion, relative_motion
from ftac_gym.baselines.observers.attitude_filter import AttitudeFilter
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray


class DirectController(Baseline):
    """Attitude filter, errors and wheels of a law; the torque is the law's own.

    Of three wheels each is limited by itself, as the papers have it. Redundant wheels get the command with the smallest
    largest share and are scaled together at the limits, which keeps the direction of the torque.

    Parameters
    ----------
    scenario, num_spacecraft
        As for every baseline.
    attitude_filter_time
        Time constant of the attitude filter [s]; zero uses the star tracker as it comes.

    Raises
    ------
    ValueError
        If a gain breaks a rule.
    """

    def __init__(self, scenario: Scenario, num_spacecraft: int, attitude_filter_time: float) -> None:
        super().__init__(scenario, num_spacecraft)
        craft = scenario.spacecraft
        self._inertia = craft.inertia_matrix
        self._period = scenario.control_period
        self._moving = scenario.reference.moving
        self._torque_limits = craft.wheels.torque_limits
        self._redundant = craft.wheels.count > 3
        self._minimax = MinimaxAllocation(craft.wheels)
        self._filter = AttitudeFilter(scenario, self.memory, attitude_filter_time)

    def _motion(self, attitude: FloatArray, measurement: Measurement, short_way: bool) -> RelativeMotion:
        """Return the errors of craft with an attitude (N, 4), the short way or as the quaternions' signs have it."""
        return relative_motion(attitude, measurement, self._moving, short_way)

    def _to_wheels(self, torque: FloatArray) -> FloatArray:
        """Return wheel torques (N, m) [N m] within the limits that give a torque (N, 3), as far as they can."""
        command = self._minimax(torque)
        return (scale_to_limits if self._redundant else limit_each)(command, self._torque_limits)
