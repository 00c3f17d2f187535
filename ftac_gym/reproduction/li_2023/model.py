"""Fuzzy model of Li, Xu and Chang 2023 beside the equations that it represents (section 5.1)."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial

import numpy as np

from ftac_gym import scenarios
from ftac_gym.attitude import cross, quaternion_derivative, quaternion_error
from ftac_gym.baselines.components import takagi_sugeno
from ftac_gym.baselines.components.takagi_sugeno import Membership, TakagiSugenoModel
from ftac_gym.task.vibration import hub_torque
from ftac_gym.utils.parameters import FloatArray

MEMBERSHIPS: dict[str, Membership] = {
    "triangular sets": takagi_sugeno.TriangularSets(),
    "Gaussian sets of width 0.6 rad/s": takagi_sugeno.GaussianSets(width=0.6),
    "nearest rule": takagi_sugeno.NearestRule(),
}
"""Sets of the fuzzy model, which the paper draws but does not print; the last one stands for models with few rules."""

STEP, DURATION = 0.02, 40.0

Slopes = Callable[[FloatArray, FloatArray, FloatArray], tuple[FloatArray, FloatArray]]
"""From rate (N, 3), torque (N, 3) and varpi (N, 2k) to the slopes of rate and varpi."""


class _Nonlinear:
    """Eqs. (6), (7) of the example's nominal spacecraft."""

    def __init__(self) -> None:
        spacecraft = scenarios.get("li_2023").spacecraft
        appendages = spacecraft.appendages
        assert appendages is not None
        self.inertia, self.quick_inertia = spacecraft.inertia_matrix, spacecraft.quick_inertia
        self.inverse: FloatArray = np.linalg.inv(self.quick_inertia).astype(np.float64)
        self.coupling = appendages.coupling_matrix
        self.stiffness, self.damping = appendages.stiffness, appendages.damping
        self.modes = appendages.count

    def pull(self, rate: FloatArray, vibration: FloatArray) -> FloatArray:
        """Return T_d (N, 3) [N m] for varpi (N, 2k)."""
        displacement, motion = vibration[:, : self.modes], vibration[:, self.modes :] - rate @ self.coupling.T
        return hub_torque(self.stiffness, self.damping, self.coupling, displacement, motion, rate)

    def slopes(self, rate: FloatArray, torque: FloatArray, vibration: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return w' (N, 3) and varpi' (N, 2k)."""
        turning = torque + self.pull(rate, vibration) - cross(rate, rate @ self.inertia)
        motion = vibration[:, self.modes :] - rate @ self.coupling.T
        force = self.damping * motion + self.stiffness * vibration[:, : self.modes]
        return turning @ self.inverse, np.concatenate([motion, -force], axis=1)


def _fuzzy_slopes(
    model: TakagiSugenoModel, sets: Membership, rate: FloatArray, torque: FloatArray, vibration: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return w' and varpi' of the fuzzy model with some sets."""
    return model.slopes(sets(rate), rate, torque, vibration)


def _fuzzy_models() -> dict[str, Slopes]:
    model = TakagiSugenoModel(scenarios.get("li_2023").spacecraft)
    return {name: partial(_fuzzy_slopes, model, sets) for name, sets in MEMBERSHIPS.items()}


@cache
def term_errors() -> dict[str, float]:
    """Return, by membership, the largest error of w' over the largest w', at random small rates and vibrations."""
    exact, random = _Nonlinear(), np.random.default_rng(0)
    rate, torque = random.uniform(-0.1, 0.1, (500, 3)), np.zeros((500, 3))
    vibration = random.uniform(-0.01, 0.01, (500, 2 * exact.modes))
    truth = exact.slopes(rate, torque, vibration)[0]
    return {
        name: float(np.abs(slopes(rate, torque, vibration)[0] - truth).max() / np.abs(truth).max())
        for name, slopes in _fuzzy_models().items()
    }


@cache
def closed_loops() -> dict[str, FloatArray]:
    """Return, by membership, the attitude quaternions (T + 1, 4) of the loop of section 5.1; "nonlinear" is the truth.

    All start at q_v = (0.1, -0.1, 0.1) and turn to (0.3, 0.2, -0.4) under Eq. (69) with the true vibration.
    """
    exact = _Nonlinear()
    start = np.zeros(7 + 2 * exact.modes)
    start[1:4], start[4:7] = (0.1, -0.1, 0.1), (0.02, -0.03, 0.01)
    start[0] = np.sqrt(1.0 - 0.03)
    # psi = eta' + delta w for appendages at rest.
    start[7 + exact.modes :] = exact.coupling @ start[4:7]
    models: dict[str, Slopes] = {"nonlinear": exact.slopes, **_fuzzy_models()}
    return {name: _integrated(exact, slopes, start) for name, slopes in models.items()}


def _integrated(exact: _Nonlinear, slopes: Slopes, start: FloatArray) -> FloatArray:
    """Return the quaternions (T + 1, 4) of a loop, integrated by the classical Runge-Kutta method."""
    target = np.array([[np.sqrt(1.0 - 0.29), 0.3, 0.2, -0.4]])

    def slope(state: FloatArray) -> FloatArray:
        attitude, rate, vibration = state[None, :4], state[None, 4:7], state[None, 7:]
        error = quaternion_error(attitude, target)
        scalar, vector = error[:, :1], error[:, 1:]
        # beta = 2: half of it times two is one.
        nonlinear = (scalar * rate + cross(vector, rate)) @ exact.quick_inertia
        nonlinear = nonlinear + cross(rate, 2.0 * vector @ exact.inertia)
        torque = -20.0 * vector - 60.0 * rate - exact.pull(rate, vibration) - nonlinear
        turning, shaking = slopes(rate, np.clip(torque, -5.0, 5.0), vibration)
        turned = quaternion_derivative(attitude, rate)
        return np.concatenate([turned[0], turning[0], shaking[0]])

    state, history = start, [start[:4]]
    for _ in range(round(DURATION / STEP)):
        first = slope(state)
        second = slope(state + 0.5 * STEP * first)
        third = slope(state + 0.5 * STEP * second)
        fourth = slope(state + STEP * third)
        state = state + STEP / 6.0 * (first + 2.0 * (second + third) + fourth)
        history.append(state[:4])
    return np.array(history)


def loop_errors() -> dict[str, float]:
    """Return, by membership, the largest difference of a quaternion component from the nonlinear loop's."""
    loops = closed_loops()
    return {name: float(np.abs(loops[name] - loops["nonlinear"]).max()) for name in MEMBERSHIPS}
