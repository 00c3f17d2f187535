"""The learning observer of Cao, Gong and Han 2022: as printed, and in a form that learns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ftac_gym.baselines.components.reaching import switching
from ftac_gym.baselines.estimate import FaultEstimate
from ftac_gym.baselines.gains import Range, changed, parameter
from ftac_gym.baselines.observers.excitation import Excitation, ExcitationGains
from ftac_gym.baselines.observers.observer import FaultObserver
from ftac_gym.baselines.observers.rate_predictor import RatePredictor
from ftac_gym.baselines.rules import interval, optional
from ftac_gym.baselines.units import LOOPS, PER_LOOP, TORQUE, Unit
from ftac_gym.task.measurement import Measurement
from ftac_gym.utils.parameters import FloatArray, matrix, non_negative, positive, require

_LEARNING = Unit("I/(R L)", "s/rad", inertia=1, torque=-1, loop_time=-1)
"""One over the change of the rate that the smallest torque limit makes in one loop time."""


@dataclass(frozen=True)
class LearningGains(ExcitationGains):
    """Gains of :class:`LearningObserver`."""

    rate_gain: float | Sequence[float] = parameter(2.0, "M", search=Range(0.5, 5.0, log=True))
    first: float | Sequence[Sequence[float]] = parameter(1.0, "H1", search=Range(0.01, 300.0, log=True))
    second: float | Sequence[Sequence[float]] = parameter(1.0, "H2", search=Range(0.01, 300.0, log=True))
    forgetting: float = parameter(1.0, "l", "", interval(0.0, 1.0, closed=True))
    switching: float = parameter(0.0, "n", "N m", non_negative)
    full_torque: float | None = parameter(1.0, "u0. None takes v = 1, as printed", "N m", optional(positive))
    smallest: float = parameter(1e-4, "Lower end of the effectiveness", "", interval(0.0, 1.0))


@dataclass(frozen=True)
class ScaledLearningGains(LearningGains):
    """Gains of :class:`ScaledLearningObserver`."""

    excitation_time: float = changed(ExcitationGains, "excitation_time", 10.0, unit=LOOPS)
    rate_gain: float = parameter(0.4, "M", PER_LOOP, positive, Range(0.1, 1.0, log=True))
    first: float = parameter(0.008133, "H1", _LEARNING, positive, Range(4e-5, 1.2, log=True))
    second: float = parameter(0.008133, "H2", _LEARNING, positive, Range(4e-5, 1.2, log=True))
    switching: float = changed(LearningGains, "switching", unit=TORQUE)
    full_torque: float | None = changed(LearningGains, "full_torque", 0.5, unit=TORQUE)


class LearningObserver(FaultObserver):
    """Estimate of the effectiveness of every wheel, renewed once a period from its last value.

    With w~ = w - w^, U = diag(sat(u)) and the nominal inertia J (Eqs. (7), (8)), at every sample k::

        J w^' = -w^ x J w^ + D U e^ + M w~ + n sign(w~)
        e^_k = Proj[l e^_{k-1} + v (H1 w~_k + H2 w~_{k-1})]  onto [smallest, 1]

    As printed v = 1, l = 0.9, n = 2.5 N m, and the gains are 4 x 3 although the example has three wheels. This form
    fails. Without the sign of the command the correction has the wrong sign half of the time. The factor l gives
    a time constant of ten samples, and n keeps w~ at zero, so that no information is left in it. The working form has
    v = sat(u / u0), l = 1, n = 0 and smaller gains: above the command u0 a wheel learns at full speed.

    M is given by its diagonal [N m s], or by a number [1/s] times the inertia. H1 and H2 [s/rad] are m x 3 matrices, or
    numbers times D'.

    Raises
    ------
    ValueError
        If a gain breaks a rule, or a gain matrix does not fit the number of wheels.
    """

    gains = LearningGains()

    def _build(self) -> None:
        super()._build()
        own, wheels = self.physical, self._scenario.spacecraft.wheels.count
        if isinstance(own.rate_gain, (int, float, np.number)):
            self._rate_gain = positive(float(own.rate_gain), "rate_gain") * self._scenario.spacecraft.inertia_matrix
        else:
            self._rate_gain = np.diag([positive(value, "rate_gain") for value in own.rate_gain])
            require(self._rate_gain.shape == (3, 3), "rate_gain", "must be a number or three", own.rate_gain)
        self._first = self._learning_gain(own.first, wheels, "first")
        self._second = self._learning_gain(own.second, wheels, "second")
        self._predictor = RatePredictor(self._scenario, self._memory)
        self._memory.add("injection", (3,))
        self._memory.add("effectiveness", (wheels,), initial=1.0)
        self._excitation = Excitation(self._scenario, self._memory, own)

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
        if self.physical.full_torque is not None:
            correction *= np.minimum(np.maximum(command * (1.0 / self.physical.full_torque), -1.0), 1.0)
        learned = self.physical.forgetting * effectiveness + correction
        # The first sample has no period behind it: e^(0) = 1 stays.
        learned = np.where(fresh, effectiveness, np.minimum(np.maximum(learned, self.physical.smallest), 1.0))
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
        if self.physical.switching > 0.0:
            torque = torque + self.physical.switching * switching(mismatch, 0.0)
        return torque


class ScaledLearningObserver(LearningObserver):
    """The learning observer with gains in units of the scenario, for spacecraft of any size.

    M is a number times J, H1 and H2 are numbers times D'. On the flagship they are those of the working form that
    ``predefined_time_observer`` takes: 2 1/s, 2 s/rad and u0 = 0.1 N m.
    """

    gains = ScaledLearningGains()
