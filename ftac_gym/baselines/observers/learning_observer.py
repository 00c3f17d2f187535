"""The learning observer of Cao, Gong and Han 2022: as printed, and in a form that learns."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from ftac_gym.baselines.components.reaching import switching
from ftac_gym.baselines.estimate import FaultEstimate
from ftac_gym.baselines.gains import Range, SearchSpace
from ftac_gym.baselines.memory import Memory
from ftac_gym.baselines.observers.excitation import Excitation
from ftac_gym.baselines.observers.rate_predictor import RatePredictor
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, finite, matrix, non_negative, positive, require, within


class LearningObserver:
    """Estimate of the effectiveness of every wheel, renewed once a period from its last value.

    With w~ = w - w^, U = diag(sat(u)) and the nominal inertia J (Eqs. (7), (8)), at every sample k:

        J w^' = -w^ x J w^ + D U e^ + M w~ + n sign(w~)
        e^_k = Proj[l e^_{k-1} + v (H1 w~_k + H2 w~_{k-1})]  onto [smallest, 1]

    As printed v = 1, l = 0.9, n = 2.5 N m, and the gains are 4 x 3 although the example has three wheels. It cannot
    work: without the sign of the command the correction has the wrong sign half of the time; l forgets with a time
    constant of ten samples; n holds w~ at zero against everything there is to learn from. The working form has
    v = sat(u / u0), l = 1, n = 0 and smaller gains.

    Parameters
    ----------
    scenario
        The task; its nominal inertia and axes are the model.
    memory
        Where the state is kept.
    rate_gain
        The diagonal of M [N m s], or a number times the inertia [1/s].
    first, second
        H1 and H2, m x 3 matrices, or a number times D' [s/rad].
    forgetting
        l, within (0, 1].
    switching
        n [N m].
    full_torque
        u0 [N m]: the command from which on a wheel learns at full speed; None takes v = 1, as printed.
    smallest
        Lower end of the effectiveness.
    excitation_time, excitation_threshold
        See :class:`~ftac_gym.baselines.observers.excitation.Excitation`.

    Raises
    ------
    ValueError
        If a gain breaks a rule, or a gain matrix does not fit the number of wheels.
    """

    search_space: ClassVar[SearchSpace] = {
        "rate_gain": Range(0.5, 5.0, log=True),
        "first": Range(0.01, 300.0, log=True),
        "second": Range(0.01, 300.0, log=True),
    }

    def __init__(
        self,
        scenario: Scenario,
        memory: Memory,
        rate_gain: float | Sequence[float] = 2.0,
        first: float | Sequence[Sequence[float]] = 1.0,
        second: float | Sequence[Sequence[float]] = 1.0,
        forgetting: float = 1.0,
        switching: float = 0.0,
        full_torque: float | None = 1.0,
        smallest: float = 1e-4,
        excitation_time: float = 2.0,
        excitation_threshold: float = 0.05,
    ) -> None:
        craft = scenario.spacecraft
        wheels = craft.wheels.count
        self._axes_transposed = craft.wheels.axis_matrix.T.copy()
        if isinstance(rate_gain, (int, float, np.number)):
            self._rate_gain = positive(float(rate_gain), "rate_gain") * craft.inertia_matrix
        else:
            self._rate_gain = np.diag([positive(value, "rate_gain") for value in rate_gain])
            require(self._rate_gain.shape == (3, 3), "rate_gain", "must be a number or three", rate_gain)
        self._first, self._second = (
            self._learning_gain(value, wheels, name) for value, name in ((first, "first"), (second, "second"))
        )
        require(0.0 < finite(forgetting, "forgetting") <= 1.0, "forgetting", "must lie within (0, 1]", forgetting)
        self._forgetting = forgetting
        self._switching_gain = non_negative(switching, "switching")
        self._full_torque = None if full_torque is None else positive(full_torque, "full_torque")
        self._smallest = within(smallest, 0.0, 1.0, "smallest")
        self._predictor = RatePredictor(scenario, memory)
        self._memory = memory
        memory.add("injection", (3,))
        memory.add("effectiveness", (wheels,), initial=1.0)
        self._excitation = Excitation(scenario, memory, excitation_time, excitation_threshold)

    def _learning_gain(self, gain: float | Sequence[Sequence[float]], wheels: int, name: str) -> FloatArray:
        """Return the transpose (3, m) of a gain."""
        if isinstance(gain, (int, float, np.number)):
            return positive(float(gain), name) * self._axes_transposed.T
        rows = len(gain)
        require(rows == wheels, name, f"must have one row for each of the {wheels} wheels", f"{rows} rows")
        return matrix(gain, wheels, 3, name).T

    def update(self, measurement: Measurement, command: FloatArray, dt: float) -> FaultEstimate:
        """Take in a measurement and the command (N, m) [N m] of the period dt [s] that ends with it."""
        memory, effectiveness, last_mismatch = self._memory, self._memory["effectiveness"], self._predictor.mismatch
        torque = (effectiveness * command) @ self._axes_transposed + memory["injection"]
        mismatch, fresh = self._predictor.update(measurement, torque, dt)
        correction = mismatch @ self._first + last_mismatch @ self._second
        if self._full_torque is not None:
            correction *= np.minimum(np.maximum(command * (1.0 / self._full_torque), -1.0), 1.0)
        learned = self._forgetting * effectiveness + correction
        # The first sample brings no news: e^(0) = 1 stands.
        learned = np.where(fresh, effectiveness, np.minimum(np.maximum(learned, self._smallest), 1.0))
        memory["injection"], memory["effectiveness"] = self._injection(mismatch), learned
        self._excitation.update(command, dt)
        return self.estimate

    @property
    def estimate(self) -> FaultEstimate:
        """The latest estimate."""
        memory = self._memory
        return FaultEstimate(memory["injection"], memory["effectiveness"], None, self._excitation.identifiable)

    def _injection(self, mismatch: FloatArray) -> FloatArray:
        """Return M w~ + n sign(w~) (N, 3) [N m]: the torque that the estimated effectiveness does not explain."""
        torque: FloatArray = mismatch @ self._rate_gain
        if self._switching_gain > 0.0:
            torque = torque + self._switching_gain * switching(mismatch, 0.0)
        return torque
