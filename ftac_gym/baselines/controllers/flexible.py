"""Base of the controllers for flexible spacecraft: model, sliding variable, estimates and the two limits."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ftac_gym.attitude import cross
from ftac_gym.baselines import synthesis
from ftac_gym.baselines.components.allocation import within_limits
from ftac_gym.baselines.components.relative_motion import RelativeMotion
from ftac_gym.baselines.components.takagi_sugeno import TakagiSugenoModel
from ftac_gym.baselines.controllers.fault_tolerant import FaultTolerantController, FaultTolerantGains
from ftac_gym.baselines.controllers.filtered import FilteredController
from ftac_gym.baselines.gains import Range, changed, fixed, parameter
from ftac_gym.baselines.observers.attitude_filter import AttitudeFilterGains
from ftac_gym.baselines.rules import choice
from ftac_gym.baselines.synthesis.designs import DESIGNS
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, flag, non_negative, require


@dataclass(frozen=True)
class FlexibleGains(AttitudeFilterGains, FaultTolerantGains):
    """Gains of :class:`FlexibleController`."""

    smallest_effectiveness: float = fixed(0.05)
    slope: float = parameter(2.0, "beta", "rad/s", non_negative)
    limit: str = parameter("each", "Limit of every wheel, or of the sum of magnitudes", rule=choice("each", "sum"))
    short_way: bool = parameter(True, "Whether q_e has q_e0 >= 0. The printed law unwinds", rule=flag)


@dataclass(frozen=True)
class ScheduledGains(FlexibleGains):
    """Gains of a controller with the feedback K_i of the fuzzy rules, see :func:`scheduled_feedback`."""

    design: str = parameter("solved", "Source of K_i: the appendix, or solved inequalities", rule=choice(*DESIGNS))
    slope: float = changed(FlexibleGains, "slope", search=Range(0.05, 2.0, log=True))


class FlexibleController(FaultTolerantController, FilteredController):
    """A controller for a body of inertia J - delta' delta with appendages (Eqs. (35), (36) of Li et al. 2023).

    The momentum of the wheels is not in the paper's equations. In a scenario with it, its torque is a fault for the
    observer, and a disturbance for a controller without one::

        torque = the subclass's - g(s) - f^ - d^

    with the errors q_e and w_e and s = w_e + beta q_ev. The observer estimates f^, the torque of faults, and d^, that
    of vibration. The last term g is the torque of the nonlinear rest of s' (times J - delta' delta)::

        g = (J - delta' delta) (beta (q_e0 w_e + q_ev x w_e) / 2 - feed-forward) + w x J (beta q_ev - C(q_e) w_d)

    The paper limits the sum of the magnitudes of all commands to the smallest of the limits (``limit="sum"``).
    """

    gains = FlexibleGains()
    takes_torques: ClassVar[bool] = True

    def _build(self) -> None:
        super()._build()
        self._quick_inertia = self.scenario.spacecraft.quick_inertia

    @abstractmethod
    def _torque(self, measurement: Measurement, motion: RelativeMotion, variable: FloatArray) -> FloatArray:
        """Return the torque (N, 3) [N m] before the estimates are subtracted, for the errors and s (N, 3) [rad/s]."""

    def _variable(self, motion: RelativeMotion) -> FloatArray:
        """Return s = w_e + beta q_ev (N, 3) [rad/s]."""
        return motion.rate_error + self.gains.slope * motion.error[:, 1:]

    def _nonlinear_torque(self, measurement: Measurement, motion: RelativeMotion) -> FloatArray:
        """Return g (N, 3) [N m]."""
        scalar, vector = motion.error[:, :1], motion.error[:, 1:]
        change = (0.5 * self.gains.slope) * (scalar * motion.rate_error + cross(vector, motion.rate_error))
        carried = self.gains.slope * vector
        if motion.reference_rate is not None:
            change = change - motion.feed_forward(measurement)
            carried = carried - motion.reference_rate
        return change @ self._quick_inertia + cross(measurement.rate, carried @ self._inertia)

    def _gyroscopic_torque(self, measurement: Measurement, motion: RelativeMotion) -> FloatArray:
        """Return the torque along the reference, w x J w and that of its acceleration (N, 3) [N m]."""
        torque: FloatArray = cross(measurement.rate, measurement.rate @ self._inertia)
        if motion.reference_rate is not None:
            torque = torque + motion.feed_forward(measurement) @ self._quick_inertia
        return torque

    def sliding_variable(self, measurement: Measurement) -> FloatArray:
        """Return s (N, 3) [rad/s] at a measurement, for its unfiltered attitude."""
        return self._variable(self._motion(measurement, move_on=False, short_way=self.gains.short_way))

    def act(self, measurement: Measurement) -> FloatArray:
        """Return the wheel torques to command, (N, wheels) [N m]."""
        motion = self._motion(measurement, move_on=True, short_way=self.gains.short_way)
        estimate = self._faults.update(measurement)
        torque = self._torque(measurement, motion, self._variable(motion))
        command = self._to_wheels_evenly(torque, estimate)
        if self.gains.limit == "each":
            return within_limits(command, self._torque_limits)
        excess = np.maximum(np.abs(command).sum(axis=1, keepdims=True) / self._torque_limits.min(), 1.0)
        limited: FloatArray = command / excess
        return limited


def scheduled_feedback(scenario: Scenario, design: str, share: float = 1.0, scheduled: bool = True) -> FloatArray:
    """Return K_i (8, 3, 3) [N m s/rad] from a design, times a share; all are their mean unless scheduled.

    The design has a proof for every blend of the rules at a share of one. Another share is checked rule by rule.

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
