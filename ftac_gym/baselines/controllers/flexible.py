"""What the laws for flexible spacecraft share: the model, the sliding variable, the estimates, the two limits."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from ftac_gym.attitude import cross
from ftac_gym.baselines import synthesis
from ftac_gym.baselines.components.allocation import limit_each, scale_to_limits
from ftac_gym.baselines.components.relative_motion import RelativeMotion, relative_motion
from ftac_gym.baselines.components.takagi_sugeno import TakagiSugenoModel
from ftac_gym.baselines.controllers.fault_tolerant import FaultTolerantController
from ftac_gym.baselines.observers.attitude_filter import AttitudeFilter
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, non_negative, require

LIMITS = ("each", "sum")


class FlexibleController(FaultTolerantController):
    """A law for a body of inertia J - delta' delta that appendages pull at (Eqs. (35), (36) of Li et al. 2023).

    The momentum of the wheels is not in the paper's equations: where a scenario has it, what it does is a fault to the
    observer, and a disturbance to a law without one.

        torque = the subclass's - g(s) - f^ - d^

    with q_e, w_e the errors, s = w_e + beta q_ev, f^ the torque of faults and d^ the torque of vibration that an
    observer estimates, and g the torque that the nonlinear rest of s' takes (times J - delta' delta):

        g = (J - delta' delta) (beta (q_e0 w_e + q_ev x w_e) / 2 - feed-forward) + w x J (beta q_ev - C(q_e) w_d)

    Parameters
    ----------
    scenario, num_spacecraft
        As for every baseline.
    faults, observer
        See :class:`~ftac_gym.baselines.controllers.fault_tolerant.FaultTolerantController`.
    slope
        beta [rad/s].
    limit
        ``"each"``: every wheel keeps to its own limit; ``"sum"``: the magnitudes of all commands together keep to the
        smallest of the limits, which is how the paper prints it.
    short_way
        Whether q_e is the one of the two quaternions with q_e0 >= 0; as printed it is not, and the law unwinds.
    attitude_filter_time
        Time constant of the attitude filter [s]; zero for none.

    Raises
    ------
    ValueError
        If a gain breaks a rule.
    """

    takes_torques: ClassVar[bool] = True

    def __init__(
        self,
        scenario: Scenario,
        num_spacecraft: int,
        faults: str,
        observer: Mapping[str, Any] | None,
        slope: float,
        limit: str,
        short_way: bool,
        attitude_filter_time: float,
    ) -> None:
        super().__init__(scenario, num_spacecraft, faults=faults, observer=observer)
        require(limit in LIMITS, "limit", f"must be one of {list(LIMITS)}", limit)
        self._slope = non_negative(slope, "slope")
        self._limit, self._short_way = limit, bool(short_way)
        self._moving = scenario.reference.moving
        self._quick_inertia = scenario.spacecraft.quick_inertia
        self._redundant = scenario.spacecraft.wheels.count > 3
        self._filter = AttitudeFilter(scenario, self.memory, attitude_filter_time)

    @abstractmethod
    def _torque(self, measurement: Measurement, motion: RelativeMotion, variable: FloatArray) -> FloatArray:
        """Return the torque (N, 3) [N m] before the estimates are taken off, for the errors and s (N, 3) [rad/s]."""

    def _variable(self, motion: RelativeMotion) -> FloatArray:
        """Return s = w_e + beta q_ev (N, 3) [rad/s]."""
        return motion.rate_error + self._slope * motion.error[:, 1:]

    def _nonlinear_torque(self, measurement: Measurement, motion: RelativeMotion) -> FloatArray:
        """Return g (N, 3) [N m]."""
        scalar, vector = motion.error[:, :1], motion.error[:, 1:]
        change = (0.5 * self._slope) * (scalar * motion.rate_error + cross(vector, motion.rate_error))
        carried = self._slope * vector
        if motion.reference_rate is not None:
            change = change - motion.feed_forward(measurement)
            carried = carried - motion.reference_rate
        torque: FloatArray = change @ self._quick_inertia + cross(measurement.rate, carried @ self._inertia)
        return torque

    def _gyroscopic_torque(self, measurement: Measurement, motion: RelativeMotion) -> FloatArray:
        """Return what following the reference takes by itself, w x J w and its acceleration (N, 3) [N m]."""
        torque: FloatArray = cross(measurement.rate, measurement.rate @ self._inertia)
        if motion.reference_rate is not None:
            torque = torque + motion.feed_forward(measurement) @ self._quick_inertia
        return torque

    def sliding_variable(self, measurement: Measurement) -> FloatArray:
        """Return s (N, 3) [rad/s] at a measurement, for its unfiltered attitude."""
        return self._variable(relative_motion(measurement.attitude, measurement, self._moving, self._short_way))

    def act(self, measurement: Measurement) -> FloatArray:
        """Return the wheel torques to command, (N, wheels) [N m]."""
        attitude = self._filter.update(measurement)
        motion = relative_motion(attitude, measurement, self._moving, self._short_way)
        estimate = self._faults.update(measurement)
        torque = self._torque(measurement, motion, self._variable(motion))
        return self._limited(self._to_wheels_evenly(torque, estimate))

    def _limited(self, command: FloatArray) -> FloatArray:
        """Return wheel torques (N, m) [N m] within the limits."""
        if self._limit == "sum":
            smallest = self._torque_limits.min()
            excess = np.maximum(np.abs(command).sum(axis=1, keepdims=True) / smallest, 1.0)
            limited: FloatArray = command / excess
            return limited
        return (scale_to_limits if self._redundant else limit_each)(command, self._torque_limits)


def scheduled_feedback(scenario: Scenario, design: str, share: float = 1.0, scheduled: bool = True) -> FloatArray:
    """Return K_i (8, 3, 3) [N m s/rad] from a design, times a share; all are their mean unless scheduled.

    What the design proves for every blend of the rules is proved for a share of one alone; any other is checked rule by
    rule.

    Raises
    ------
    ValueError
        If the spacecraft is rigid, the design is unknown, or A_i + B K_i is not stable at every rule.
    """
    model, gains = TakagiSugenoModel(scenario.spacecraft), synthesis.gains(scenario.spacecraft, design).controller
    feedback: FloatArray = share * (gains if scheduled else gains.mean()).feedback
    slowest = float(np.linalg.eigvals(model.state + model.input @ feedback).real.max())
    rule = f"with feedback_share = {share!r} must leave a stable s; the slowest pole is {slowest:.3g} 1/s"
    require(slowest < 0.0, "design", rule, design)
    return feedback
