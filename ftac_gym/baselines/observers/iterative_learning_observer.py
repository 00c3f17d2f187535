"""An iterative learning observer of the lumped torque, of the family of the comparator of Li, Xu and Chang 2023."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ftac_gym.baselines.estimate import FaultEstimate
from ftac_gym.baselines.gains import Gains, Range, parameter
from ftac_gym.baselines.observers.observer import FaultObserver
from ftac_gym.baselines.observers.rate_predictor import RatePredictor
from ftac_gym.baselines.rules import interval
from ftac_gym.task.measurement import Measurement
from ftac_gym.utils.parameters import FloatArray, positive, require


@dataclass(frozen=True)
class IterativeLearningGains(Gains):
    """Gains of :class:`IterativeLearningObserver`."""

    rate_gain: float = parameter(8.0, "L over J", "1/s", positive, Range(0.5, 9.0, log=True))
    learning_gain: float = parameter(4.0, "K2 over J", "1/s^2", positive, Range(0.1, 9.0, log=True))
    forgetting: float = parameter(1.0, "K1", "", interval(0.0, 1.0, closed=True))


class IterativeLearningObserver(FaultObserver):
    """The torque on the body that the commands do not explain, renewed once a period from its last value.

    With w~ = w - w^ and the nominal total inertia J, as in Hu, Niu and Wang 2018 and Chen and Saif 2007. Their
    equations were not available: this is the class, with gains of our own::

        J w^' = -w^ x J w^ + D u + f^ + L w~,    f^_k = K1 f^_{k-1} + K2 w~_k

    for L = rate_gain J, K2 = learning_gain J. For K1 below one f^ never reaches a constant torque. There is no model of
    appendages: their torque is a part of f^.

    Raises
    ------
    ValueError
        If a gain breaks a rule, or the sampled observer is not stable at this control period.
    """

    gains = IterativeLearningGains()

    def _build(self) -> None:
        super()._build()
        own, inertia, period = self.gains, self._scenario.spacecraft.inertia_matrix, self._scenario.control_period
        self._rate_gain, self._learning_gain = own.rate_gain * inertia, own.learning_gain * inertia
        # w~ and J^-1 f^ of one axis, from one period to the next.
        decay = 1.0 - period * own.rate_gain
        step = np.array([[decay, -period], [own.learning_gain * decay, own.forgetting - own.learning_gain * period]])
        radius = float(np.abs(np.linalg.eigvals(step)).max())
        rule = f"with rate_gain = {own.rate_gain!r} must be stable at {period!r} s; its spectral radius is {radius:.3g}"
        require(radius < 1.0, "learning_gain", rule, own.learning_gain)
        self._predictor = RatePredictor(self._scenario, self._memory)
        self._memory.add("learned_torque", (3,))

    def update(self, measurement: Measurement, command: FloatArray, dt: float) -> FaultEstimate:
        """Take in a measurement and the command (N, m) [N m] of the period dt [s] that ends with it."""
        learned = self._memory["learned_torque"]
        torque = command @ self._axes_transposed + learned + self._predictor.mismatch @ self._rate_gain
        # The prediction starts at the first sample, whose mismatch is zero.
        mismatch, _ = self._predictor.update(measurement, torque, dt)
        self._memory["learned_torque"] = self.gains.forgetting * learned + mismatch @ self._learning_gain
        return self.estimate

    @property
    def estimate(self) -> FaultEstimate:
        """The latest estimate."""
        return FaultEstimate(disturbance=self._memory["learned_torque"])
