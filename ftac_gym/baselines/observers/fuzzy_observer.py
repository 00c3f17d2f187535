"""The fuzzy adaptive fault-estimation observer of Li, Xu and Chang 2023, for flexible spacecraft."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ftac_gym.baselines import synthesis
from ftac_gym.baselines.components.takagi_sugeno import TakagiSugenoModel, TriangularSets
from ftac_gym.baselines.estimate import FaultEstimate
from ftac_gym.baselines.gains import Gains, parameter
from ftac_gym.baselines.observers.observer import FaultObserver
from ftac_gym.baselines.rules import choice, optional
from ftac_gym.baselines.synthesis import ObserverGains, error_dynamics
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.vibration import hub_torque
from ftac_gym.utils.parameters import FloatArray, flag, positive, require

STABLE_STEP = 2.78
"""Largest step times the fastest pole with which the Runge-Kutta method is stable; Euler's limit is smaller."""


@dataclass(frozen=True)
class FuzzyObserverGains(Gains):
    """Gains and method of :class:`FuzzyObserver`."""

    design: str = parameter("solved", "Source of the gain matrices: appendix, or solved inequalities")
    torque_bound: float | None = parameter(None, "f_max", "N m", optional(positive))
    vibration_bound: float | None = parameter(None, "Largest sum of the magnitudes of d^", "", optional(positive))
    start: str = parameter("measured", "Initial estimate of the rate", rule=choice("measured", "zero"))
    interpolate: bool = parameter(True, "Whether the rate is interpolated within a period", rule=flag)
    method: str = parameter("rk4", "Integrator", rule=choice("rk4", "euler"))
    longest_step: float = parameter(0.05, "Largest step into which the period is divided", "s", positive)
    scheduled: bool = parameter(True, "Whether the active rules set the gains. Else their mean", rule=flag)


class FuzzyObserver(FaultObserver):
    """Estimate of rate, fault torque and vibration from the measured rate alone: Eqs. (16), (17), without derivatives.

    With e = w - x^, t = D u the torque commanded, and the sums over the rules blended by the measured rate::

        f^ = z_f + P_f e,   varpi^ = z_v + P_v e,   d^ = varpi^ - (0, delta w) = (eta^, eta^')
        x^' = sum h_i {A_i x^ + B (t + f^) + D_i d^ + K_i e}
        z_f' = sum h_i F_i e,   z_v' = A_v varpi^ + B_v w + sum h_i G_i e

    which is the printed law with its term in y' integrated by parts (Eq. (22)). f is the torque of the faults on the
    body, not the torque of each wheel: with more than three wheels those are not observable. Beyond a ``torque_bound``
    f_max, which must exceed the whole equivalent fault (E - I) u + f, f^ is clipped and z_f is constant. Beyond a
    ``vibration_bound`` d^ is scaled down. The start is the first measured rate with the appendages at rest, or zero.

    The observer is sampled: it integrates the last period, with the held command, along the line between the two rates
    measured at its ends.

    Raises
    ------
    ValueError
        If the spacecraft is rigid, a parameter breaks a rule, the gains leave an unstable error for this spacecraft, or
        the step is too long for it.
    """

    gains = FuzzyObserverGains()

    def _build(self) -> None:
        super()._build()
        own = self.gains
        self._steps = math.ceil(self._scenario.control_period / own.longest_step - 1e-9)
        model = TakagiSugenoModel(self._scenario.spacecraft)
        matrices = synthesis.gains(self._scenario.spacecraft, own.design).observer
        matrices = matrices if own.scheduled else matrices.mean()
        poles = np.linalg.eigvals(error_dynamics(model, matrices))
        slowest = float(poles.real.max())
        require(
            slowest < 0.0, "design", f"must leave a stable error; the slowest pole is {slowest:.3g} 1/s", own.design
        )
        step = self._scenario.control_period / self._steps
        fastest = float(np.abs(poles).max())
        rule = f"must be at most {STABLE_STEP / fastest:.3g} s: the fastest pole of the error is {fastest:.3g} 1/s"
        require(step * fastest <= STABLE_STEP, "longest_step", rule, own.longest_step)
        appendages = self._scenario.spacecraft.appendages
        assert appendages is not None
        self._coupling = appendages.coupling_matrix
        self._stiffness, self._damping = appendages.stiffness, appendages.damping
        self._membership = TriangularSets()
        self._proportional = np.concatenate([matrices.fault_proportional, matrices.vibration_proportional]).T.copy()
        self._modes = appendages.count
        self._rules = _rules(model, matrices)
        self._memory.add("fuzzy_state", (6 + 2 * self._modes,))
        self._memory.add("observed_rate", (3,))
        self._memory.add("rate_mismatch", (3,))
        self._memory.add("fault_torque", (3,))
        self._memory.add("vibration", (2 * self._modes,))
        self._memory.add("vibration_torque", (3,))
        self._memory.add("observer_fresh", (1,), initial=True)

    @property
    def estimate(self) -> FaultEstimate:
        """The latest estimate."""
        return FaultEstimate(disturbance=self._memory["fault_torque"], vibration=self._memory["vibration_torque"])

    def update(self, measurement: Measurement, command: FloatArray, dt: float) -> FaultEstimate:
        """Take in a measurement and the command (N, m) [N m] of the period dt [s] that ends with it."""
        memory, rate = self._memory, measurement.rate
        fresh, before = memory["observer_fresh"], memory["observed_rate"]
        state = self._advanced(memory["fuzzy_state"], command @ self._axes_transposed, before, rate, dt)
        if fresh.any():
            state = np.where(fresh, self._initial(rate), state)
        mismatch, fault, _, vibration = self._parts(state, rate)
        displacement, modal_rate = vibration[:, : self._modes], vibration[:, self._modes :]
        torque = hub_torque(self._stiffness, self._damping, self._coupling, displacement, modal_rate, rate)
        memory["fuzzy_state"], memory["observed_rate"], memory["rate_mismatch"] = state, rate, mismatch
        memory["fault_torque"], memory["vibration"] = fault, vibration
        memory["vibration_torque"] = torque
        memory["observer_fresh"] = np.zeros_like(fresh)
        return self.estimate

    def _initial(self, rate: FloatArray) -> FloatArray:
        """Return the state (N, 6 + 2k) at the first measurement, where f^ = 0 and the appendages are at rest."""
        state = np.zeros((len(rate), 6 + 2 * self._modes))
        if self.gains.start == "measured":
            state[:, :3] = rate
            state[:, 6 + self._modes :] = rate @ self._coupling.T
        else:
            state[:, 3:] = -rate @ self._proportional
        return state

    def _parts(self, state: FloatArray, rate: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Return e (N, 3), f^ (N, 3), varpi^ (N, 2k) and d^ (N, 2k) of a state at a rate."""
        mismatch: FloatArray = rate - state[:, :3]
        corrected = state[:, 3:] + mismatch @ self._proportional
        fault, motion = corrected[:, :3], corrected[:, 3:]
        if self.gains.torque_bound is not None:
            fault = np.minimum(np.maximum(fault, -self.gains.torque_bound), self.gains.torque_bound)
        vibration = motion.copy()
        vibration[:, self._modes :] -= rate @ self._coupling.T
        if self.gains.vibration_bound is not None:
            size = np.abs(vibration).sum(axis=1, keepdims=True)
            vibration *= self.gains.vibration_bound / np.maximum(size, self.gains.vibration_bound)
        return mismatch, fault, motion, vibration

    def _slope(self, state: FloatArray, rate: FloatArray, torque: FloatArray, weights: FloatArray) -> FloatArray:
        mismatch, fault, motion, vibration = self._parts(state, rate)
        inputs = np.concatenate([state[:, :3], mismatch, fault, motion, vibration, rate, torque], axis=1)
        by_rule = (inputs @ self._rules).reshape(len(state), weights.shape[1], -1)
        slope: FloatArray = np.einsum("nr,nri->ni", weights, by_rule)
        if self.gains.torque_bound is not None:
            unclipped = state[:, 3:6] + mismatch @ self._proportional[:, :3]
            pushed = (np.abs(unclipped) >= self.gains.torque_bound) & (unclipped * slope[:, 3:6] > 0.0)
            slope[:, 3:6][pushed] = 0.0
        return slope

    def _advanced(
        self, state: FloatArray, torque: FloatArray, before: FloatArray, after: FloatArray, dt: float
    ) -> FloatArray:
        """Return the state at the end of a period with rates (N, 3) at its ends and a torque (N, 3) on the body."""
        step, change = dt / self._steps, after - before
        if not self.gains.interpolate:
            change = np.zeros_like(change)
        rate, weights = before, self._membership(before)
        for number in range(self._steps):
            first = self._slope(state, rate, torque, weights)
            if self.gains.method == "euler":
                state = state + step * first
                rate = before + ((number + 1) / self._steps) * change
                weights = self._membership(rate)
                continue
            middle, end = (before + ((number + part) / self._steps) * change for part in (0.5, 1.0))
            weights_middle, weights_end = self._membership(middle), self._membership(end)
            second = self._slope(state + (0.5 * step) * first, middle, torque, weights_middle)
            third = self._slope(state + (0.5 * step) * second, middle, torque, weights_middle)
            fourth = self._slope(state + step * third, end, torque, weights_end)
            state = state + (step / 6.0) * (first + 2.0 * (second + third) + fourth)
            rate, weights = end, weights_end
        return state


def _rules(model: TakagiSugenoModel, gains: ObserverGains) -> FloatArray:
    """Return the matrix (inputs, 8 * slopes) of the slopes of (x^, z_f, z_v) by each rule, side by side.

    The inputs are (x^, e, f^, varpi^, d^, w, t).
    """
    count = model.vibration.shape[0]
    rows, columns = (
        np.split(np.arange(6 + count), [3, 6]),
        np.split(np.arange(15 + 2 * count), np.cumsum([3, 3, 3, count, count, 3])),
    )
    rate, fault, motion = rows
    estimated, mismatch, torque, whole, vibration, measured, commanded = columns
    rules = np.zeros((len(model.state), 6 + count, 15 + 2 * count))
    for row, column, part in (
        (rate, estimated, model.state),
        (rate, mismatch, gains.rate),
        (rate, torque, model.input),
        (rate, vibration, model.vibration_input),
        (rate, commanded, model.input),
        (fault, mismatch, gains.fault),
        (motion, mismatch, gains.vibration),
        (motion, whole, model.vibration),
        (motion, measured, model.rate_to_vibration),
    ):
        rules[:, row[:, None], column[None, :]] = part
    return rules.transpose(2, 0, 1).reshape(rules.shape[2], -1).copy()
