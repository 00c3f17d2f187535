"""An iterative learning observer of the lumped torque: the family that Li, Xu and Chang 2023 compare theirs with."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from ftac_gym.baselines.estimate import FaultEstimate
from ftac_gym.baselines.gains import Range, SearchSpace
from ftac_gym.baselines.memory import Memory
from ftac_gym.baselines.observers.rate_predictor import RatePredictor
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, positive, require


class IterativeLearningObserver:
    """The torque on the body that the commands do not explain, renewed once a period from its last value.

    With w~ = w - w^ and the nominal total inertia J, as in Hu, Niu and Wang 2018 and Chen and Saif 2007 (their
    equations were not to be had: this is the class, with gains of ours):

        J w^' = -w^ x J w^ + D u + f^ + L w~,    f^_k = K1 f^_{k-1} + K2 w~_k

    for L = rate_gain J, K2 = learning_gain J. It knows no appendages: their torque is a part of f^.

    Parameters
    ----------
    scenario
        The task; its nominal inertia and axes are the model.
    memory
        Where the state is kept.
    rate_gain
        [1/s].
    learning_gain
        [1/s^2] for w~ of one period.
    forgetting
        K1, within (0, 1]; below one f^ never reaches a lasting torque.

    Raises
    ------
    ValueError
        If a gain breaks a rule, or the sampled observer is not stable at this control period.
    """

    search_space: ClassVar[SearchSpace] = {
        "rate_gain": Range(0.5, 9.0, log=True),
        "learning_gain": Range(0.1, 9.0, log=True),
    }

    def __init__(
        self,
        scenario: Scenario,
        memory: Memory,
        rate_gain: float = 8.0,
        learning_gain: float = 4.0,
        forgetting: float = 1.0,
    ) -> None:
        inertia, period = scenario.spacecraft.inertia_matrix, scenario.control_period
        self._axes_transposed = scenario.spacecraft.wheels.axis_matrix.T.copy()
        self._rate_gain = positive(rate_gain, "rate_gain") * inertia
        self._learning_gain = positive(learning_gain, "learning_gain") * inertia
        require(0.0 < forgetting <= 1.0, "forgetting", "must lie within (0, 1]", forgetting)
        self._forgetting = forgetting
        # w~ and J^-1 f^ of one axis, from one period to the next.
        decay = 1.0 - period * rate_gain
        step = np.array([[decay, -period], [learning_gain * decay, forgetting - learning_gain * period]])
        radius = float(np.abs(np.linalg.eigvals(step)).max())
        rule = f"with rate_gain = {rate_gain!r} must be stable at {period!r} s; its spectral radius is {radius:.3g}"
        require(radius < 1.0, "learning_gain", rule, learning_gain)
        self._predictor = RatePredictor(scenario, memory)
        self._memory = memory
        memory.add("learned_torque", (3,))

    def update(self, measurement: Measurement, command: FloatArray, dt: float) -> FaultEstimate:
        """Take in a measurement and the command (N, m) [N m] of the period dt [s] that ends with it."""
        learned = self._memory["learned_torque"]
        torque = command @ self._axes_transposed + learned + self._predictor.mismatch @ self._rate_gain
        # The first sample brings no news: the prediction starts there.
        mismatch, _ = self._predictor.update(measurement, torque, dt)
        self._memory["learned_torque"] = self._forgetting * learned + mismatch @ self._learning_gain
        return self.estimate

    @property
    def estimate(self) -> FaultEstimate:
        """The latest estimate."""
        return FaultEstimate(disturbance=self._memory["learned_torque"])
