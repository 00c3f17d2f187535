"""A disturbance observer: the torque on the body beyond model and commands."""

from __future__ import annotations

import numpy as np

from ftac_gym.baselines.components.gyroscopic import GyroscopicModel
from ftac_gym.baselines.memory import Memory
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, positive


class DisturbanceObserver:
    """First-order observer of the lumped torque d in J w' = -w x (J w + D h) + D u + d.

    Each control period it low-passes the balance of the last period::

        r = J (w_k - w_{k-1}) / T + gyroscopic torque - D u_{k-1},

    the discrete counterpart of the observer d^ = z + L J w (Chen, Ballance, Gawthrop, O'Reilly, IEEE T-IE 47(4), 2000),
    without its drift. The estimate contains faults, inertia errors, external torque and errors of the gyroscopic model.

    Parameters
    ----------
    scenario
        The task; its nominal inertia and axes are the model.
    memory
        Store of the state.
    bandwidth
        Bandwidth L [rad/s].
    gyroscopic
        Model of the gyroscopic torque.
    """

    def __init__(self, scenario: Scenario, memory: Memory, bandwidth: float, gyroscopic: GyroscopicModel) -> None:
        self._bandwidth = positive(bandwidth, "bandwidth")
        self._own_gain = 1.0 - np.exp(-self._bandwidth * scenario.control_period)
        self._gain: float | FloatArray = self._own_gain
        self._inertia = scenario.spacecraft.inertia_matrix
        self._axes_transposed = scenario.spacecraft.wheels.axis_matrix.T.copy()
        self._period = scenario.control_period
        self._gyroscopic = gyroscopic
        self._memory = memory
        memory.add("disturbance", (3,))
        memory.add("last_rate", (3,))
        memory.add("fresh", (1,), initial=True)

    def set_bandwidth(self, bandwidth: float | FloatArray) -> None:
        """Use a bandwidth [rad/s], a number or (N, 1), from now on."""
        # Exponentials of arrays may differ from those of numbers in the last bit.
        gain = 1.0 - np.exp(-bandwidth * self._period)
        self._gain = np.where(bandwidth == self._bandwidth, self._own_gain, gain)

    @property
    def disturbance(self) -> FloatArray:
        """(N, 3) estimated torque in body axes [N m]."""
        return self._memory["disturbance"]

    def update(self, measurement: Measurement, residual: FloatArray | None = None) -> FloatArray:
        """Take in a measurement and return the estimate (N, 3) [N m].

        Parameters
        ----------
        measurement
            The measurement.
        residual
            Torque (N, 3) of the last period beyond the commands [N m]; None for that of the nominal spacecraft.
        """
        memory, disturbance = self._memory, self._memory["disturbance"]
        if residual is None:
            residual = self._balance(measurement, memory["last_rate"])
        # A spacecraft just reset has no period behind it to balance.
        updated: FloatArray = disturbance + self._gain * np.where(memory["fresh"], 0.0, residual - disturbance)
        memory["disturbance"], memory["last_rate"] = updated, measurement.rate
        memory["fresh"] = np.zeros_like(memory["fresh"])
        return updated

    def _balance(self, measurement: Measurement, last_rate: FloatArray) -> FloatArray:
        """Return the torque (N, 3) [N m] of the last period that nominal spacecraft and commands do not explain."""
        acceleration = (measurement.rate - last_rate) / self._period
        explained = measurement.command_in_effect @ self._axes_transposed
        gyroscopic = self._gyroscopic.torque(0.5 * (measurement.rate + last_rate), measurement.wheel_momentum)
        residual: FloatArray = acceleration @ self._inertia + gyroscopic - explained
        return residual
