"""Time histories of episodes: the truth, not the measurement."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ftac_gym.attitude import mrp_from_quaternion, quaternion_error, rotation_vector_from_quaternion
from ftac_gym.baselines import FaultEstimate
from ftac_gym.evaluation.metrics.episode import Metrics, episode_metrics
from ftac_gym.evaluation.metrics.recovery import Recoveries, recoveries
from ftac_gym.task.episodes import Episodes
from ftac_gym.task.scenario import Scenario, success_steps
from ftac_gym.task.vibration import modal_energy, vibration_torque
from ftac_gym.utils.parameters import FloatArray


@dataclass(frozen=True, eq=False)
class Rollout:
    """Time histories of N episodes of T control periods; the truth, not the measurement.

    Attributes
    ----------
    scenario, episodes
        Task and episodes.
    time
        (T + 1,) [s].
    attitude_error
        (T + 1, N) pointing error [rad].
    rate_error
        (T + 1, N) magnitude of the rate error [rad/s].
    attitude
        (T + 1, N, 4) quaternions.
    reference_attitude
        (T + 1, N, 4) quaternions of the reference.
    rate
        (T + 1, N, 3) body rates [rad/s].
    wheel_momentum
        (T + 1, N, m) [N m s].
    command
        (T, N, m) commanded wheel torques [N m].
    applied_torque
        (T, N, m) mean torque that each wheel applied in each control period [N m].
    reward
        (T, N) rewards.
    modal_displacement, modal_rate
        (T + 1, N, k) vibration modes [kg^1/2 m, kg^1/2 m/s]; k = 0 for rigid spacecraft.
    estimates
        (T, N, ...) fault estimates of the policy at the start of each control period, when it commands; None if they
        were not recorded.
    """

    scenario: Scenario
    episodes: Episodes
    time: FloatArray
    attitude_error: FloatArray
    rate_error: FloatArray
    attitude: FloatArray
    reference_attitude: FloatArray
    rate: FloatArray
    wheel_momentum: FloatArray
    command: FloatArray
    applied_torque: FloatArray
    reward: FloatArray
    modal_displacement: FloatArray
    modal_rate: FloatArray
    estimates: FaultEstimate | None = None

    @property
    def on_target(self) -> npt.NDArray[np.bool_]:
        """Mask of the spacecraft that are on target, inside the cone and slow, (T + 1, N)."""
        success = self.scenario.success
        return (self.attitude_error < success.angle) & (self.rate_error < success.rate)

    @property
    def window(self) -> slice:
        """The samples of the window of success: those that end its control periods, of axis 0 of the histories."""
        return slice(len(self.time) - success_steps(self.scenario), None)

    @property
    def error_vector(self) -> FloatArray:
        """Rotation vector of the attitude error in the window, (window, N, 3) [rad], body axes of the reference."""
        attitude, reference = self.attitude[self.window], self.reference_attitude[self.window]
        return rotation_vector_from_quaternion(quaternion_error(attitude, reference))

    @property
    def relative_error(self) -> FloatArray:
        """Angle between the error and its mean over the window, (window, N) [rad]; both as rotation vectors."""
        vector = self.error_vector
        distance: FloatArray = np.linalg.norm(vector - vector.mean(axis=0), axis=2)
        return distance

    @property
    def modal_energy(self) -> FloatArray:
        """Energy of the vibration modes, (T + 1, N) [J]."""
        return modal_energy(self.episodes.modes["stiffness"], self.modal_displacement, self.modal_rate)

    @property
    def vibration_torque(self) -> FloatArray:
        """Torque of the vibration modes on the body, (T + 1, N, 3) [N m], body axes."""
        return vibration_torque(self.episodes.modes, self.modal_displacement, self.modal_rate, self.rate)

    @property
    def error_mrp(self) -> FloatArray:
        """MRP of the attitude error, (T + 1, N, 3), short branch."""
        return mrp_from_quaternion(quaternion_error(self.attitude, self.reference_attitude))

    def metrics(self) -> Metrics:
        """Evaluate every episode."""
        return episode_metrics(self)

    def recoveries(self) -> Recoveries:
        """Return the recovery from each fault."""
        return recoveries(self.on_target, np.degrees(self.attitude_error), self.episodes, self.scenario.control_period)

    def feasible_metrics(self) -> Metrics:
        """Evaluate the feasible episodes."""
        return {name: values[self.episodes.feasible] for name, values in self.metrics().items()}
