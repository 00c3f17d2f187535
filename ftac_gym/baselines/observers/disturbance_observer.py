"""A disturbance observer: the torque that the model and the commands do not explain."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ftac_gym.attitude import cross
from ftac_gym.measurement import Measurement
from ftac_gym.parameters import FloatArray, positive
from ftac_gym.scenario import Scenario


class DisturbanceObserver:
    """First-order observer of the lumped torque d in J w' = -w x (J w + stored) + D u + d.

    Each control period it evaluates the momentum balance of the period that has just ended,
    r = J (w_k - w_{k-1}) / T + w x (J w + stored) - D u_{k-1}, and low-passes it: the discrete counterpart of the
    classical observer d^ = z + L J w (Chen et al., IEEE T-IE 47(4), 2000), but free of drift. Faults, inertia errors
    and external torque all end up in d. Where the wheels' stored momentum acts on the body but is not measured, the whole
    gyroscopic torque is left to d: the body's share alone would mostly be undone by the wheels' share.

    Parameters
    ----------
    scenario
        The task; its nominal inertia and axes are the model.
    num_craft
        Number of craft N.
    bandwidth
        Bandwidth L [rad/s].
    telemetry
        Whether to use the measured wheel momentum.
    """

    def __init__(self, scenario: Scenario, num_craft: int, bandwidth: float, telemetry: bool) -> None:
        wheels = scenario.spacecraft.wheels
        self._gain = 1.0 - np.exp(-positive(bandwidth, "bandwidth") * scenario.control_period)
        self._inertia = scenario.spacecraft.inertia_matrix
        self._axes_transposed = wheels.axis_matrix.T.copy()
        self._period = scenario.control_period
        self._stored = wheels.momentum_coupling and telemetry
        self._gyroscopic = telemetry or not wheels.momentum_coupling
        self._last_rate = np.zeros((num_craft, 3))
        self._fresh = np.ones((num_craft, 1), dtype=np.bool_)
        self.disturbance = np.zeros((num_craft, 3))
        """(N, 3) estimated torque in body axes [N m]."""

    def reset(self, chosen: npt.NDArray[np.bool_]) -> None:
        """Forget the past of the chosen craft (N,)."""
        self.disturbance = np.where(chosen[:, None], 0.0, self.disturbance)
        self._fresh = self._fresh | chosen[:, None]

    def gyroscopic_torque(self, rate: FloatArray, wheel_momentum: FloatArray) -> FloatArray | float:
        """Return w x (J w + stored), (N, 3) [N m], as far as it is modelled."""
        if not self._gyroscopic:
            return 0.0
        momentum = rate @ self._inertia
        if self._stored:
            momentum += wheel_momentum @ self._axes_transposed
        return cross(rate, momentum)

    def update(self, measurement: Measurement) -> FloatArray:
        """Take in a measurement and return the estimate (N, 3) [N m]."""
        rate = measurement.rate
        acceleration = (rate - self._last_rate) / self._period
        middle = 0.5 * (rate + self._last_rate)
        explained = measurement.last_command @ self._axes_transposed
        gyroscopic = self.gyroscopic_torque(middle, measurement.wheel_momentum)
        residual = acceleration @ self._inertia + gyroscopic - explained
        # A craft just reset has no period behind it to balance.
        change = np.where(self._fresh, 0.0, residual - self.disturbance)
        self.disturbance = self.disturbance + self._gain * change
        self._last_rate = rate
        self._fresh = np.zeros_like(self._fresh)
        return self.disturbance
