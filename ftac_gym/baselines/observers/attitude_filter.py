"""Blend of star tracker and gyro: a fixed-gain attitude filter."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ftac_gym.attitude import canonical, quaternion_conjugate, quaternion_from_rotation_vector, quaternion_product
from ftac_gym.baselines.components.rows import length
from ftac_gym.baselines.estimators.navigator import NavigationGains
from ftac_gym.baselines.gains import parameter
from ftac_gym.baselines.memory import Memory
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, non_negative


@dataclass(frozen=True)
class AttitudeFilterGains(NavigationGains):
    """Gain of :class:`AttitudeFilter` in a controller."""

    attitude_filter_time: float = parameter(
        0.0, "Time constant of the fixed-gain filter in place of the Kalman filter. Zero for none", "s", non_negative
    )


class AttitudeFilter:
    """Propagate the attitude with the gyros and pull it towards the star tracker.

    ::

        q^_{k|k-1} = q^_{k-1} (x) dq(w T),    q^_k = q^_{k|k-1} (x) dq(g phi)

    w is the mean of the last two rates, phi the rotation from the propagated to the measured attitude, and
    g = 1 - exp(-T / time constant). This is the steady state of a Kalman filter whose gyros are accurate over times
    shorter than the time constant.

    Parameters
    ----------
    scenario
        The task.
    memory
        Store of the state.
    time_constant
        [s]; zero passes the measured attitude through.
    """

    def __init__(self, scenario: Scenario, memory: Memory, time_constant: float) -> None:
        self._period = scenario.control_period
        time_constant = non_negative(time_constant, "attitude_filter_time")
        self._active = time_constant > 0.0
        self._gain = 1.0 - np.exp(-self._period / time_constant) if self._active else 1.0
        self._memory = memory
        memory.add("filtered_attitude", (4,))
        memory.add("filter_rate", (3,))
        memory.add("filter_fresh", (1,), initial=True)

    def update(self, measurement: Measurement) -> FloatArray:
        """Take in a measurement and return the filtered attitude, quaternions (N, 4)."""
        if not self._active:
            return measurement.attitude
        memory, measured = self._memory, measurement.attitude
        fresh = memory["filter_fresh"]
        # A spacecraft just reset starts from the measurement.
        previous = np.where(fresh, measured, memory["filtered_attitude"])
        turn = np.where(fresh, 0.0, (0.5 * self._period) * (measurement.rate + memory["filter_rate"]))
        propagated = quaternion_product(previous, quaternion_from_rotation_vector(turn))
        innovation = canonical(quaternion_product(quaternion_conjugate(propagated), measured))
        # The innovation is of the size of the sensor noise: twice its vector part is the rotation vector.
        correction = self._gain * innovation
        correction[:, 0] = 1.0
        filtered = quaternion_product(propagated, correction)
        filtered /= length(filtered)
        memory["filtered_attitude"], memory["filter_rate"] = filtered, measurement.rate
        memory["filter_fresh"] = np.zeros_like(fresh)
        return filtered
