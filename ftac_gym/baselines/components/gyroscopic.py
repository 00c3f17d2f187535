"""The nominal gyroscopic torque, as far as the measurements give it."""

from __future__ import annotations

import numpy as np

from ftac_gym.attitude import cross
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray


class GyroscopicModel:
    """The nominal gyroscopic torque w x (J w + D h), as far as the measurements give it.

    Where the wheels' momentum h acts on the body but is not measured, the model is zero. After a start near rest the
    momenta of body and wheels nearly cancel, so that one without the other increases the error.

    Parameters
    ----------
    scenario
        The task.
    telemetry
        Whether the measured wheel momentum may be used.
    """

    def __init__(self, scenario: Scenario, telemetry: bool) -> None:
        wheels = scenario.spacecraft.wheels
        self._inertia = scenario.spacecraft.inertia_matrix
        self._axes_transposed = wheels.axis_matrix.T.copy()
        self._stored = wheels.momentum_coupling
        self._known = telemetry or not wheels.momentum_coupling

    def torque(self, rate: FloatArray, wheel_momentum: FloatArray) -> FloatArray:
        """Return the torque (N, 3) [N m] for rates (N, 3) [rad/s] and wheel momenta (N, m) [N m s]."""
        if not self._known:
            return np.zeros_like(rate)
        momentum = rate @ self._inertia
        if self._stored:
            momentum = momentum + wheel_momentum @ self._axes_transposed
        return cross(rate, momentum)
