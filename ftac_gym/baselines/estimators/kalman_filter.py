"""The Kalman filter of attitude and gyro bias as a component."""

from __future__ import annotations

import numpy as np

from ftac_gym.baselines.estimators.attitude_kernel import ATTITUDE_STATE, AttitudeModel, filter_attitude
from ftac_gym.baselines.memory import Memory
from ftac_gym.task.measurement import Measurement
from ftac_gym.utils.parameters import FloatArray


class AttitudeKalmanFilter:
    """Multiplicative extended Kalman filter of attitude and gyro bias (Lefferts, Markley and Shuster, JGCD 5(5), 1982).

    The gyros carry the attitude from one control period to the next, and the samples of the star tracker correct
    attitude and bias. A sample that arrives late was carried forward with the gyros, bias included. The innovation and
    its covariance allow for that, exactly while no other sample arrives in between. Errors in proportion to the rate
    widen the covariance of the bias as the rate changes.

    A sample whose squared normalised innovation is beyond the gate is left out. After five such samples in a row that
    agree with each other, attitude or bias has changed. The covariance is then widened, and the next sample is taken.

    Parameters
    ----------
    model
        Errors of the sensors, see :func:`~ftac_gym.baselines.estimators.models.attitude_model`.
    memory
        Store of the state.
    """

    def __init__(self, model: AttitudeModel, memory: Memory) -> None:
        self.model = model
        self._memory = memory
        memory.add("attitude_filter", (), initial=np.zeros((), ATTITUDE_STATE))

    def update(self, measurement: Measurement) -> tuple[FloatArray, FloatArray]:
        """Take in a measurement; return attitude (N, 4) and rate without bias (N, 3) [rad/s]."""
        state = self._memory["attitude_filter"]
        filter_attitude(
            state,
            self.model,
            measurement.time,
            measurement.attitude,
            measurement.attitude_age,
            measurement.rate,
        )
        return state["attitude"].copy(), measurement.rate - state["bias"]

    @property
    def bias(self) -> FloatArray:
        """(N, 3) estimated gyro bias [rad/s]."""
        bias: FloatArray = self._memory["attitude_filter"]["bias"].copy()
        return bias

    @property
    def covariance(self) -> FloatArray:
        """(N, 6, 6) covariance of the errors of attitude [rad], in body axes, and bias [rad/s]."""
        covariance: FloatArray = self._memory["attitude_filter"]["covariance"].copy()
        return covariance

    @property
    def innovation_square(self) -> FloatArray:
        """(N,) squared normalised innovation of the newest sample, chi-square with three degrees of freedom."""
        square: FloatArray = self._memory["attitude_filter"]["innovation_square"].copy()
        return square
