"""A law from outside of the package, where other processes find it."""

import numpy as np

from ftac_gym.baselines import Baseline, Range
from ftac_gym.baselines.components.allocation import pseudo_inverse, scale_to_limits
from ftac_gym.baselines.components.relative_motion import relative_motion


class CustomBaseline(Baseline):
    """Proportional-derivative control that counts its calls, so that it has a memory."""

    search_space = {"stiffness": Range(0.1, 1.0), "damping": Range(0.5, 5.0)}  # noqa: RUF012

    def __init__(self, scenario, num_spacecraft=1, stiffness=0.3, damping=2.0):
        super().__init__(scenario, num_spacecraft)
        self.stiffness, self.damping = stiffness, damping
        self.wheels = scenario.spacecraft.wheels
        self.memory.add("calls", (1,))

    def act(self, measurement):
        self.memory["calls"] = self.memory["calls"] + 1.0
        motion = relative_motion(measurement.attitude, measurement, self.scenario.reference.moving)
        turned = 2.0 * self.stiffness * motion.error[:, 1:] * np.minimum(self.memory["calls"] / 10.0, 1.0)
        torque = -self.damping * (motion.rate_error + turned) @ self.scenario.spacecraft.inertia_matrix
        return scale_to_limits(torque @ pseudo_inverse(self.wheels.axis_matrix).T, self.wheels.torque_limits)


class CustomTelemetry(CustomBaseline):
    """The same with a higher tier of information."""

    information = "telemetry"


class CustomOracle(CustomBaseline):
    """The same with the tier of the truth."""

    information = "oracle"


NO_LAW = 3
