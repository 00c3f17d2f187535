"""Model of the rate, with which fault observers compare the measured rate."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ftac_gym.baselines.components.gyroscopic import GyroscopicModel
from ftac_gym.baselines.memory import Memory
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray


class RatePredictor:
    """J w^' = -w^ x J w^ + torque, one Euler step per period, with the nominal inertia J.

    The gyroscopic torque is taken at the middle of the period, w^ + (w_k - w_{k-1}) / 2. It is of the size of the wheel
    torque, and the only part of a step that can be computed to second order.

    Parameters
    ----------
    scenario
        The task.
    memory
        Store of the state.
    know_rate
        Whether w^ starts from the first measurement; else from zero.
    """

    def __init__(self, scenario: Scenario, memory: Memory, know_rate: bool = True) -> None:
        self._inverse_inertia = np.linalg.inv(scenario.spacecraft.inertia_matrix)
        self._gyroscopic = GyroscopicModel(scenario, telemetry=False)
        self._know_rate = bool(know_rate)
        self._memory = memory
        memory.add("rate_estimate", (3,))
        memory.add("rate_mismatch", (3,))
        memory.add("observed_rate", (3,))
        memory.add("observer_fresh", (1,), initial=True)

    @property
    def mismatch(self) -> FloatArray:
        """The latest w~ = w - w^ (N, 3) [rad/s]."""
        return self._memory["rate_mismatch"]

    def update(
        self, measurement: Measurement, torque: FloatArray, dt: float
    ) -> tuple[FloatArray, npt.NDArray[np.bool_]]:
        """Take in a measurement.

        Parameters
        ----------
        measurement
            The measurement.
        torque
            (N, 3) torque of the period that ends with it [N m].
        dt
            The period [s].

        Returns
        -------
        w~ (N, 3) [rad/s], and the mask (N, 1) of spacecraft at their first sample, without a prediction.
        """
        memory, rate, fresh = self._memory, measurement.rate, self._memory["observer_fresh"]
        estimated = memory["rate_estimate"]
        middle = estimated + 0.5 * (rate - memory["observed_rate"])
        torque = torque - self._gyroscopic.torque(middle, measurement.wheel_momentum)
        estimated = estimated + dt * (torque @ self._inverse_inertia)
        estimated = np.where(fresh, rate if self._know_rate else 0.0, estimated)
        mismatch: FloatArray = rate - estimated
        memory["rate_estimate"], memory["rate_mismatch"], memory["observed_rate"] = estimated, mismatch, rate
        memory["observer_fresh"] = np.zeros_like(fresh)
        return mismatch, fresh
