"""The barrier-function adaptive sliding-mode fault observer of Zhang and Zhou 2019."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ftac_gym.baselines.components.reaching import switching
from ftac_gym.baselines.components.rows import dot
from ftac_gym.baselines.estimate import FaultEstimate
from ftac_gym.baselines.gains import Range, changed, parameter
from ftac_gym.baselines.observers.excitation import Excitation, ExcitationGains
from ftac_gym.baselines.observers.observer import FaultObserver
from ftac_gym.baselines.observers.rate_predictor import RatePredictor
from ftac_gym.baselines.rules import interval
from ftac_gym.baselines.units import LOOPS, PER_LOOP, TORQUE, Unit
from ftac_gym.task.measurement import Measurement
from ftac_gym.utils.parameters import FloatArray, flag, non_negative, positive

BoolArray = npt.NDArray[np.bool_]


@dataclass(frozen=True)
class SlidingModeGains(ExcitationGains):
    """Gains of :class:`SlidingModeObserver`, in the units of the paper: w~ in rad/s, torques in N m."""

    rate_gain: float = parameter(5.0, "L, times the identity", "1/s", positive, Range(0.5, 5.0, log=True))
    effectiveness_gain: float = parameter(200.0, "g1", "", non_negative, Range(1e2, 1e6, log=True))
    bias_gain: float = parameter(100.0, "g2", "", non_negative, Range(10.0, 3000.0, log=True))
    switching_gain: float = parameter(0.1, "g3", "", non_negative)
    barrier: float = parameter(0.05, "Barrier", "rad/s", positive)
    barrier_torque: float = parameter(1.0, "k; 1 in the paper, where it has no symbol", "N m", non_negative)
    largest_switching: float = parameter(50.0, "Largest K", "N m", non_negative)
    smallest: float = parameter(0.05, "Lower end of the effectiveness", "", interval(0.0, 1.0))
    layer: float = parameter(0.01, "Boundary layer of the sign. Zero for none", "rad/s", non_negative)
    printed_barrier: bool = parameter(False, "Whether (18) is taken as printed, with w~'w~", rule=flag)
    know_rate: bool = parameter(True, "Whether w^ starts from the first measurement. Else from zero", rule=flag)


_RATE = Unit("R L/I", "rad/s", torque=1, loop_time=1, inertia=-1)
"""The change of the rate that the smallest torque limit makes in one loop time."""
_EFFECTIVENESS = Unit("(I/(R L))^2", "s^2", inertia=2, torque=-2, loop_time=-2)
_TORQUE_GAIN = Unit("(I/L)^2", "kg^2 m^4/s^2", inertia=2, loop_time=-2)


@dataclass(frozen=True)
class ScaledSlidingModeGains(SlidingModeGains):
    """Gains of :class:`ScaledSlidingModeObserver`."""

    excitation_time: float = changed(ExcitationGains, "excitation_time", 10.0, unit=LOOPS)
    rate_gain: float = changed(SlidingModeGains, "rate_gain", 1.0, unit=PER_LOOP, search=Range(0.1, 1.0, log=True))
    effectiveness_gain: float = changed(
        SlidingModeGains, "effectiveness_gain", 3.307e-3, unit=_EFFECTIVENESS, search=Range(1e-3, 16.0, log=True)
    )
    bias_gain: float = changed(
        SlidingModeGains, "bias_gain", 0.04134, unit=_TORQUE_GAIN, search=Range(4e-3, 1.2, log=True)
    )
    switching_gain: float = changed(SlidingModeGains, "switching_gain", 4.134e-5, unit=_TORQUE_GAIN)
    barrier: float = changed(SlidingModeGains, "barrier", 12.3, unit=_RATE)
    barrier_torque: float = changed(SlidingModeGains, "barrier_torque", 5.0, unit=TORQUE, meaning="k")
    largest_switching: float = changed(SlidingModeGains, "largest_switching", 250.0, unit=TORQUE)
    layer: float = changed(SlidingModeGains, "layer", 2.459, unit=_RATE)


class SlidingModeObserver(FaultObserver):
    """Estimate of effectiveness and bias of every wheel from the error of an estimated rate.

    With w~ = w - w^, U = diag(sat(u)) and the nominal inertia J (Eqs. (15)-(18), corrected)::

        w^' = L w~ + J^-1 (-w^ x J w^ + D U e^ + D b^ + K sign(w~))
        e^' = Proj[g1 U D' J^-1 w~],  b^' = g2 D' J^-1 w~

    K grows by K' = g3 ``|J^-1|`` ``|w~|_1`` until ``|w~|_1`` is first below the barrier (17), and is then the barrier
    function K = k ``|w~|_1`` / (barrier - ``|w~|_1``), at most ``largest_switching`` (18).

    Differences from the print: U holds the limited command, not the raw one, which is tens of times larger while a
    wheel saturates. The estimate e^ is projected onto [smallest, 1], since the controllers divide by it. The barrier
    (18) takes the norm of its phase test. As printed it takes w~'w~, which gives no barrier at ``|w~|_1`` = barrier.
    The theorem gives a small w~ and bounded estimates, not accurate ones: accuracy needs sustained torque.

    The rate estimate takes one Euler step per update, with the gyroscopic torque at the middle of the period; the
    estimates then take one with the new w~, which is stable for larger periods than two explicit steps.
    """

    gains = SlidingModeGains()

    def _build(self) -> None:
        super()._build()
        own, spacecraft = self.physical, self._scenario.spacecraft
        inverse_inertia = np.linalg.inv(spacecraft.inertia_matrix)
        self._rate_torque = own.rate_gain * spacecraft.inertia_matrix
        self._to_wheels = inverse_inertia @ spacecraft.wheels.axis_matrix
        self._growth = own.switching_gain * float(np.linalg.norm(inverse_inertia, 2))
        self._predictor = RatePredictor(self._scenario, self._memory, own.know_rate)
        wheels = spacecraft.wheels.count
        self._memory.add("injection", (3,))
        self._memory.add("adaptive_switching", (1,))
        self._memory.add("inside_barrier", (1,), initial=False)
        self._memory.add("effectiveness", (wheels,), initial=1.0)
        self._memory.add("bias", (wheels,))
        self._excitation = Excitation(self._scenario, self._memory, own)

    def update(self, measurement: Measurement, command: FloatArray, dt: float) -> FaultEstimate:
        """Take in a measurement and the command (N, m) [N m] of the period dt [s] that ends with it."""
        memory, effectiveness, bias = self._memory, self._memory["effectiveness"], self._memory["bias"]
        torque = (effectiveness * command + bias) @ self._axes_transposed + memory["injection"]
        mismatch, fresh = self._predictor.update(measurement, torque, dt)
        inside = memory["inside_barrier"]
        # The first measurement has no period behind it.
        step = np.where(fresh, 0.0, dt)
        size = np.abs(mismatch).sum(axis=1, keepdims=True)
        adaptive = memory["adaptive_switching"] + (self._growth * step) * size * ~inside
        inside = inside | (size < self.physical.barrier)
        switched = self._switching(mismatch, size, adaptive, inside) * switching(mismatch, self.physical.layer)
        drive = mismatch @ self._to_wheels
        effectiveness = effectiveness + (self.physical.effectiveness_gain * step) * command * drive
        effectiveness = np.minimum(np.maximum(effectiveness, self.physical.smallest), 1.0)
        bias = bias + (self.physical.bias_gain * step) * drive
        memory["injection"] = switched + mismatch @ self._rate_torque
        memory["adaptive_switching"], memory["inside_barrier"] = adaptive, inside
        memory["effectiveness"], memory["bias"] = effectiveness, bias
        self._excitation.update(command, dt)
        return self.estimate

    @property
    def estimate(self) -> FaultEstimate:
        """The latest estimate; its disturbance is the rest of the torque, K sign(w~) + J L w~."""
        memory, known = self._memory, self._excitation.identifiable
        return FaultEstimate(memory["injection"], memory["effectiveness"], memory["bias"], known)

    def _switching(self, mismatch: FloatArray, size: FloatArray, adaptive: FloatArray, inside: BoolArray) -> FloatArray:
        """Return K (N, 1) [N m]."""
        if self.physical.printed_barrier:
            size = dot(mismatch, mismatch)
        # K reaches its largest value before the barrier, which a sampled observer can overstep.
        barrier = self.physical.barrier_torque * size / np.maximum(self.physical.barrier - size, 1e-12)
        return np.minimum(np.where(inside, barrier, adaptive), self.physical.largest_switching)


class ScaledSlidingModeObserver(SlidingModeObserver):
    """The sliding-mode observer with gains in units of the scenario, for spacecraft of any size.

    On the flagship the gains are those of the usable form of :class:`SlidingModeObserver`.
    """

    gains = ScaledSlidingModeGains()
