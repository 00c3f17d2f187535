"""The barrier-function adaptive sliding-mode fault observer of Zhang and Zhou 2019."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
import numpy.typing as npt

from ftac_gym.baselines.components.reaching import switching
from ftac_gym.baselines.estimate import FaultEstimate
from ftac_gym.baselines.gains import Range, SearchSpace
from ftac_gym.baselines.memory import Memory
from ftac_gym.baselines.observers.excitation import Excitation
from ftac_gym.baselines.observers.rate_predictor import RatePredictor
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, non_negative, positive, within

BoolArray = npt.NDArray[np.bool_]


class SlidingModeObserver:
    """Estimate of effectiveness and bias of every wheel from the error of an estimated rate.

    With w~ = w - w^, U = diag(sat(u)) and the nominal inertia J (Eqs. (15)-(18), corrected):

        w^' = L w~ + J^-1 (-w^ x J w^ + D U e^ + D b^ + K sign(w~))
        e^' = Proj[g1 U D' J^-1 w~],  b^' = g2 D' J^-1 w~

    K grows by K' = g3 |J^-1| |w~|_1 until |w~|_1 is first below the barrier (17), and is then the barrier function
    K = k |w~|_1 / (barrier - |w~|_1), at most ``largest_switching`` (18).

    Differences from the print: U holds the limited command, not the raw one, which is tens of times larger while a
    wheel saturates; e^ is projected onto [smallest, 1], since the controllers divide by it; the barrier (18) takes the
    norm that its phase test takes (printed, it takes w~'w~, with which there is no barrier at |w~|_1 = barrier).
    The theorem gives a small w~ and bounded estimates, not accurate ones: that needs sustained torque.

    The rate estimate takes one Euler step per update, with the gyroscopic torque at the middle of the period; the
    estimates then take one with the new w~, which is stable for larger periods than two explicit steps.

    Parameters
    ----------
    scenario
        The task; its nominal inertia and axes are the model.
    memory
        Where the state is kept.
    rate_gain
        L [1/s], times the identity.
    effectiveness_gain
        g1 [1/(N m)^2 ...] as in the paper, for w~ in rad/s and torques in N m.
    bias_gain
        g2.
    switching_gain
        g3.
    barrier
        [rad/s].
    barrier_torque
        k [N m]; 1 in the paper, where it has no symbol.
    largest_switching
        Largest K [N m].
    smallest
        Lower end of the effectiveness.
    layer
        Boundary layer of the sign [rad/s]; zero for none.
    printed_barrier
        Whether (18) is taken as printed, with w~'w~.
    know_rate
        Whether w^ starts from the first measurement; else from zero.
    excitation_time, excitation_threshold
        See :class:`~ftac_gym.baselines.observers.excitation.Excitation`.

    Raises
    ------
    ValueError
        If a gain breaks a rule.
    """

    search_space: ClassVar[SearchSpace] = {
        "rate_gain": Range(0.5, 5.0, log=True),
        "effectiveness_gain": Range(1e2, 1e6, log=True),
        "bias_gain": Range(10.0, 3000.0, log=True),
    }

    def __init__(
        self,
        scenario: Scenario,
        memory: Memory,
        rate_gain: float = 5.0,
        effectiveness_gain: float = 200.0,
        bias_gain: float = 100.0,
        switching_gain: float = 0.1,
        barrier: float = 0.05,
        barrier_torque: float = 1.0,
        largest_switching: float = 50.0,
        smallest: float = 0.05,
        layer: float = 0.01,
        printed_barrier: bool = False,
        know_rate: bool = True,
        excitation_time: float = 2.0,
        excitation_threshold: float = 0.05,
    ) -> None:
        self._effectiveness_gain = non_negative(effectiveness_gain, "effectiveness_gain")
        self._bias_gain = non_negative(bias_gain, "bias_gain")
        self._rate_torque = positive(rate_gain, "rate_gain") * scenario.spacecraft.inertia_matrix
        self._barrier = positive(barrier, "barrier")
        self._barrier_torque = non_negative(barrier_torque, "barrier_torque")
        self._largest = non_negative(largest_switching, "largest_switching")
        self._smallest = within(smallest, 0.0, 1.0, "smallest")
        self._layer = non_negative(layer, "layer")
        self._printed_barrier = bool(printed_barrier)
        craft = scenario.spacecraft
        inverse_inertia = np.linalg.inv(craft.inertia_matrix)
        self._axes_transposed = craft.wheels.axis_matrix.T.copy()
        self._to_wheels = inverse_inertia @ craft.wheels.axis_matrix
        self._growth = non_negative(switching_gain, "switching_gain") * float(np.linalg.norm(inverse_inertia, 2))
        wheels = craft.wheels.count
        self._predictor = RatePredictor(scenario, memory, know_rate)
        self._memory = memory
        memory.add("injection", (3,))
        memory.add("adaptive_switching", (1,))
        memory.add("inside_barrier", (1,), initial=False)
        memory.add("effectiveness", (wheels,), initial=1.0)
        memory.add("bias", (wheels,))
        self._excitation = Excitation(scenario, memory, excitation_time, excitation_threshold)

    def update(self, measurement: Measurement, command: FloatArray, dt: float) -> FaultEstimate:
        """Take in a measurement and the command (N, m) [N m] of the period dt [s] that ends with it."""
        memory, effectiveness, bias = self._memory, self._memory["effectiveness"], self._memory["bias"]
        torque = (effectiveness * command + bias) @ self._axes_transposed + memory["injection"]
        mismatch, fresh = self._predictor.update(measurement, torque, dt)
        inside = memory["inside_barrier"]
        # Nothing could be learned before the first period.
        step = np.where(fresh, 0.0, dt)
        size = np.abs(mismatch).sum(axis=1, keepdims=True)
        adaptive = memory["adaptive_switching"] + (self._growth * step) * size * ~inside
        inside = inside | (size < self._barrier)
        switched = self._gain(mismatch, size, adaptive, inside) * switching(mismatch, self._layer)
        drive = mismatch @ self._to_wheels
        effectiveness = effectiveness + (self._effectiveness_gain * step) * command * drive
        effectiveness = np.minimum(np.maximum(effectiveness, self._smallest), 1.0)
        bias = bias + (self._bias_gain * step) * drive
        memory["injection"] = switched + mismatch @ self._rate_torque
        memory["adaptive_switching"], memory["inside_barrier"] = adaptive, inside
        memory["effectiveness"], memory["bias"] = effectiveness, bias
        self._excitation.update(command, dt)
        return self.estimate

    @property
    def estimate(self) -> FaultEstimate:
        """The latest estimate; its disturbance is what the faults do not explain, K sign(w~) + J L w~."""
        memory, known = self._memory, self._excitation.identifiable
        return FaultEstimate(memory["injection"], memory["effectiveness"], memory["bias"], known)

    def _gain(self, mismatch: FloatArray, size: FloatArray, adaptive: FloatArray, inside: BoolArray) -> FloatArray:
        """Return K (N, 1) [N m]."""
        if self._printed_barrier:
            size = np.einsum("ni,ni->n", mismatch, mismatch)[:, None]
        # K reaches its largest value before the barrier, which a sampled observer can overstep.
        barrier = self._barrier_torque * size / np.maximum(self._barrier - size, 1e-12)
        gain: FloatArray = np.minimum(np.where(inside, barrier, adaptive), self._largest)
        return gain
