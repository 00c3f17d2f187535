"""The fuzzy adaptive fault-estimation observer of Li, Xu and Chang 2023, for flexible spacecraft."""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np

from ftac_gym.baselines import synthesis
from ftac_gym.baselines.components.takagi_sugeno import TakagiSugenoModel, TriangularSets
from ftac_gym.baselines.estimate import FaultEstimate
from ftac_gym.baselines.gains import SearchSpace
from ftac_gym.baselines.memory import Memory
from ftac_gym.baselines.synthesis import ObserverGains, error_dynamics
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.scenario import Scenario
from ftac_gym.task.vibration import hub_torque
from ftac_gym.utils.parameters import FloatArray, positive, require

METHODS = ("rk4", "euler")
STARTS = ("measured", "zero")

STABLE_STEP = 2.78
"""Longer steps than this over the fastest pole make the Runge-Kutta method diverge, and Euler's long before."""


class FuzzyObserver:
    """Estimate of rate, fault torque and vibration from the measured rate alone: Eqs. (16), (17), without derivatives.

    With e = w - x^, t = D u the torque commanded, and the sums over the rules blended by the measured rate:

        f^ = z_f + P_f e,   varpi^ = z_v + P_v e,   d^ = varpi^ - (0, delta w) = (eta^, eta^')
        x^' = sum h_i {A_i x^ + B (t + f^) + D_i d^ + K_i e}
        z_f' = sum h_i F_i e,   z_v' = A_v varpi^ + B_v w + sum h_i G_i e

    which is the printed law with its term in y' integrated by parts (Eq. (22)). f is the torque of the faults on the
    body, not the torque of each wheel: with more than three wheels those cannot be told apart.

    The observer is sampled: it integrates the period behind it, with the command that was held, along the line between
    the two rates measured at its ends.

    Parameters
    ----------
    scenario
        The task; its nominal spacecraft, with appendages, is the model.
    memory
        Where the state is kept.
    design
        ``"published"``: the gains of the paper's appendix; ``"solved"``: those that solving the paper's matrix
        inequalities for this spacecraft gives.
    torque_bound
        f_max [N m]; beyond it f^ is clipped and z_f stands still. It must exceed the whole equivalent fault
        (E - I) u + f. None for no bound.
    vibration_bound
        Largest sum of the magnitudes of d^, which is scaled down to it; None for no bound.
    start
        ``"measured"``: from the first measured rate, appendages at rest; ``"zero"``: from nothing.
    interpolate
        Whether the rate is interpolated within a period; else it is held at its start.
    method
        ``"rk4"`` or ``"euler"``.
    longest_step
        The period is divided into steps of at most this [s].
    scheduled
        Whether the gains are those of the rules that fire; else they are the mean of all, at any rate.

    Raises
    ------
    ValueError
        If the spacecraft is rigid, a parameter breaks a rule, the gains leave an unstable error for this spacecraft, or
        the step is too long for it.
    """

    search_space: ClassVar[SearchSpace] = {}

    def __init__(
        self,
        scenario: Scenario,
        memory: Memory,
        design: str = "solved",
        torque_bound: float | None = None,
        vibration_bound: float | None = None,
        start: str = "measured",
        interpolate: bool = True,
        method: str = "rk4",
        longest_step: float = 0.05,
        scheduled: bool = True,
    ) -> None:
        require(start in STARTS, "start", f"must be one of {list(STARTS)}", start)
        require(method in METHODS, "method", f"must be one of {list(METHODS)}", method)
        self._torque_bound = None if torque_bound is None else positive(torque_bound, "torque_bound")
        self._vibration_bound = None if vibration_bound is None else positive(vibration_bound, "vibration_bound")
        self._know_rate, self._interpolate, self._method = start == "measured", bool(interpolate), method
        self._steps = math.ceil(scenario.control_period / positive(longest_step, "longest_step") - 1e-9)
        model = TakagiSugenoModel(scenario.spacecraft)
        gains = synthesis.gains(scenario.spacecraft, design).observer
        gains = gains if scheduled else gains.mean()
        poles = np.linalg.eigvals(error_dynamics(model, gains))
        slowest = float(poles.real.max())
        require(slowest < 0.0, "design", f"must leave a stable error; the slowest pole is {slowest:.3g} 1/s", design)
        step = scenario.control_period / self._steps
        fastest = float(np.abs(poles).max())
        rule = f"must be at most {STABLE_STEP / fastest:.3g} s: the fastest pole of the error is {fastest:.3g} 1/s"
        require(step * fastest <= STABLE_STEP, "longest_step", rule, longest_step)
        appendages = scenario.spacecraft.appendages
        assert appendages is not None
        self._coupling = appendages.coupling_matrix
        self._stiffness, self._damping = appendages.stiffness, appendages.damping
        self._axes_transposed = scenario.spacecraft.wheels.axis_matrix.T.copy()
        self._membership = TriangularSets()
        self._proportional = np.concatenate([gains.fault_proportional, gains.vibration_proportional]).T.copy()
        self._modes = appendages.count
        self._rules = _rules(model, gains)
        self._memory = memory
        memory.add("fuzzy_state", (6 + 2 * self._modes,))
        memory.add("observed_rate", (3,))
        memory.add("rate_mismatch", (3,))
        memory.add("fault_torque", (3,))
        memory.add("vibration", (2 * self._modes,))
        memory.add("vibration_torque", (3,))
        memory.add("observer_fresh", (1,), initial=True)

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
        displacement, swing = vibration[:, : self._modes], vibration[:, self._modes :]
        pull = hub_torque(self._stiffness, self._damping, self._coupling, displacement, swing, rate)
        memory["fuzzy_state"], memory["observed_rate"], memory["rate_mismatch"] = state, rate, mismatch
        memory["fault_torque"], memory["vibration"] = fault, vibration
        memory["vibration_torque"] = pull
        memory["observer_fresh"] = np.zeros_like(fresh)
        return self.estimate

    def _initial(self, rate: FloatArray) -> FloatArray:
        """Return the state (N, 6 + 2k) at the first measurement, where f^ = 0 and the appendages are at rest."""
        state = np.zeros((len(rate), 6 + 2 * self._modes))
        if self._know_rate:
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
        if self._torque_bound is not None:
            fault = np.minimum(np.maximum(fault, -self._torque_bound), self._torque_bound)
        vibration = motion.copy()
        vibration[:, self._modes :] -= rate @ self._coupling.T
        if self._vibration_bound is not None:
            size = np.abs(vibration).sum(axis=1, keepdims=True)
            vibration *= self._vibration_bound / np.maximum(size, self._vibration_bound)
        return mismatch, fault, motion, vibration

    def _slope(self, state: FloatArray, rate: FloatArray, torque: FloatArray, weights: FloatArray) -> FloatArray:
        mismatch, fault, motion, vibration = self._parts(state, rate)
        everything = np.concatenate([state[:, :3], mismatch, fault, motion, vibration, rate, torque], axis=1)
        by_rule = (everything @ self._rules).reshape(len(state), weights.shape[1], -1)
        slope: FloatArray = np.einsum("nr,nri->ni", weights, by_rule)
        if self._torque_bound is not None:
            wanted = state[:, 3:6] + mismatch @ self._proportional[:, :3]
            pushed = (np.abs(wanted) >= self._torque_bound) & (wanted * slope[:, 3:6] > 0.0)
            slope[:, 3:6][pushed] = 0.0
        return slope

    def _advanced(
        self, state: FloatArray, torque: FloatArray, before: FloatArray, after: FloatArray, dt: float
    ) -> FloatArray:
        """Return the state at the end of a period with rates (N, 3) at its ends and a torque (N, 3) on the body."""
        step, change = dt / self._steps, after - before
        if not self._interpolate:
            change = np.zeros_like(change)
        rate, weights = before, self._membership(before)
        for number in range(self._steps):
            first = self._slope(state, rate, torque, weights)
            if self._method == "euler":
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
    """Return what each rule makes of (x^, e, f^, varpi^, d^, w, t): its slopes of (x^, z_f, z_v), side by side.

    The array is (inputs, 8 * slopes).
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
    side_by_side: FloatArray = rules.transpose(2, 0, 1).reshape(rules.shape[2], -1).copy()
    return side_by_side
