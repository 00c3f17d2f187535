"""Theorem 1 of Li, Xu and Chang 2023: observer gains from matrix inequalities, for any flexible spacecraft."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil
from typing import Any

import numpy as np

from ftac_gym.baselines.components.takagi_sugeno import TakagiSugenoModel
from ftac_gym.baselines.synthesis.certificate import SLACK, Certificate, certificate
from ftac_gym.baselines.synthesis.gain_matrices import (
    ObserverGains,
    default_fault_proportional,
    default_vibration_proportional,
)
from ftac_gym.baselines.synthesis.regions import Disc
from ftac_gym.baselines.synthesis.solver import cvxpy, minimised, negative, unsolvable
from ftac_gym.utils.parameters import FloatArray, matrix, positive, require

DISC = Disc(-10.0, 10.0)
"""The region of section 5.2."""

LEVEL, REGION = "the H-infinity level (23)", "the pole disc (24)"

NAMED = 1.0003
"""Level that a refusal names over the smallest one, at which a proof depends on the rounding of the machine."""


@dataclass(frozen=True, eq=False)
class ObserverDesign:
    """Gains with their certificate."""

    gains: ObserverGains
    certificate: Certificate


def error_dynamics(model: TakagiSugenoModel, gains: ObserverGains, fault_axes: FloatArray | None = None) -> FloatArray:
    """Return M^-1 (A_i - K_i C) (8, n, n) of Eq. (19), the dynamics of the errors of w, f and varpi."""
    mixing, state, _ = _augmented(model, gains.fault_proportional, gains.vibration_proportional, fault_axes)
    injected = np.concatenate([gains.rate, gains.fault, gains.vibration], axis=1)
    state[:, :, :3] -= injected
    return np.linalg.solve(mixing, state).astype(np.float64)


def error_inputs(model: TakagiSugenoModel, gains: ObserverGains, fault_axes: FloatArray | None = None) -> FloatArray:
    """Return M^-1 B_d (n, 3 + p) of Eq. (19), the inputs d_1 [N m] and f' [N m/s] of these errors."""
    mixing, _, inputs = _augmented(model, gains.fault_proportional, gains.vibration_proportional, fault_axes)
    return np.linalg.solve(mixing, inputs).astype(np.float64)


def _augmented(
    model: TakagiSugenoModel, fault: FloatArray, vibration: FloatArray, fault_axes: FloatArray | None
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return M (n, n), A_i (8, n, n) and B_d (n, 3 + p) of Eq. (20), for faults along axes (3, p)."""
    axes = np.eye(3) if fault_axes is None else matrix(fault_axes, 3, None, "fault_axes")
    faults, rows = axes.shape[1], 2 * model.modes
    fits = np.shape(fault) == (faults, 3)
    require(fits, "fault_proportional", f"must be {faults} x 3, one row for each axis of a fault", np.shape(fault))
    fits = np.shape(vibration) == (rows, 3)
    require(fits, "vibration_proportional", f"must be {rows} x 3 for {model.modes} modes", np.shape(vibration))
    size, first = 3 + faults + rows, 3 + faults
    mixing, state, inputs = np.eye(size), np.zeros((8, size, size)), np.zeros((size, 3 + faults))
    mixing[3:first, :3], mixing[first:, :3] = fault, vibration
    state[:, :3, :3], state[:, :3, 3:first] = model.state, model.input @ axes
    state[:, :3, first:], state[:, first:, first:] = model.vibration_input, model.vibration
    inputs[:3, :3], inputs[3:first, 3:] = model.input, np.eye(faults)
    return mixing, state, inputs


def scale_of(model: TakagiSugenoModel, faults: int = 3) -> FloatArray:
    """Return magnitudes (n,) of the errors: a torque of one, its rate in a second, vibration a tenth.

    Without them the solver fails: entries of P differ by ten orders of magnitude.
    """
    return np.concatenate([np.full(3, np.trace(model.input) / 3.0), np.ones(faults), np.full(2 * model.modes, 0.1)])


def check_observable(model: TakagiSugenoModel, fault_axes: FloatArray | None = None) -> None:
    """Raise a ValueError unless faults along axes (3, p) and the vibration are observable from the measured rate.

    The test is that of Popov, Belevitch and Hautus. With more than three wheels the faults of single wheels are not
    observable; their torque on the body is. A mode is not observable without coupling to the body, or with the coupling
    of another mode of the same frequency and damping.
    """
    faults = 3 if fault_axes is None else fault_axes.shape[1]
    nothing = np.zeros((faults, 3)), np.zeros((2 * model.modes, 3))
    _, state, _ = _augmented(model, *nothing, fault_axes)
    scale = scale_of(model, faults)
    size = len(scale)
    for rule in state / scale[:, None] * scale:
        for pole in np.linalg.eigvals(rule):
            rank = int(np.linalg.matrix_rank(np.concatenate([pole * np.eye(size) - rule, np.eye(3, size)]), tol=1e-7))
            if rank < size:
                why = f"must be observable: the rank at the pole {pole:.3g} is {rank} of {size}"
                # A fault is an integrator; oscillating modes are those of appendages.
                slow = abs(pole) < 1e-6
                raise ValueError(f"{'fault_axes' if slow else 'appendages'} {why}, got {faults} axes of faults")


def design_observer(
    model: TakagiSugenoModel,
    disc: Disc | None = DISC,
    gamma: float | None = None,
    fault_axes: FloatArray | None = None,
    fault_proportional: FloatArray | None = None,
    vibration_proportional: FloatArray | None = None,
) -> ObserverDesign:
    """Solve Theorem 1.

    With P = M'Q M and L_i = M^-1 K_i, (23) and (24) are those of a plain observer, linear in P and P L_i. They are
    posed for scaled errors.

    Parameters
    ----------
    model
        The fuzzy model.
    disc
        Region for all poles; None leaves (24) out, and the gains without bounds.
    gamma
        Level from (d_1, f') to the errors; None takes the smallest possible. It is never below 1: the observer cannot
        distinguish a constant d_1 from a fault.
    fault_axes
        (3, p) axes of the faults; None for torques about the body axes.
    fault_proportional, vibration_proportional
        theta_1 F_2 (p, 3) and theta_2 G_2 (2k, 3); None for those of Eq. (68), three axes of faults.

    Raises
    ------
    ValueError
        If the faults are not observable, or there is no solution: the message names the constraint that excludes one.
    MissingExtra
        Without CVXPY.
    """
    if fault_axes is not None:
        fault_axes = matrix(fault_axes, 3, None, "fault_axes")
    check_observable(model, fault_axes)
    fault = default_fault_proportional() if fault_proportional is None else np.asarray(fault_proportional, dtype=float)
    vibration = vibration_proportional
    if vibration is None:
        vibration = default_vibration_proportional(model.modes)
    mixing, state, inputs = _augmented(model, fault, vibration, fault_axes)
    scale = scale_of(model, fault.shape[0])
    if gamma is not None:
        positive(gamma, "gamma")
    closed: FloatArray = np.linalg.solve(mixing, state).astype(np.float64)
    driven: FloatArray = np.linalg.solve(mixing, inputs).astype(np.float64)
    found = _solve(closed, driven, scale, disc, gamma)
    if found is None:
        raise _reason(closed, driven, scale, disc, gamma)
    lyapunov, injected = found
    whole = mixing @ injected
    last = 3 + fault.shape[0]
    gains = ObserverGains(whole[:, :3], whole[:, 3:last], whole[:, last:], fault, vibration)
    closed[:, :, :3] -= injected
    proof = certificate(closed, np.tile(driven, (8, 1, 1)), lyapunov, disc, scale)
    proved = proof.holds and (gamma is None or proof.gamma <= gamma * (1.0 + SLACK))
    require(proved, "solution", "must be proved as the solver found it; gamma and contraction", _summary(proof))
    return ObserverDesign(gains, proof)


def certify_observer(
    model: TakagiSugenoModel, gains: ObserverGains, disc: Disc | None = DISC, fault_axes: FloatArray | None = None
) -> Certificate:
    """Certify given gains: the smallest level that one P proves together with the disc, if one exists."""
    closed, driven = error_dynamics(model, gains, fault_axes), error_inputs(model, gains, fault_axes)
    scale = scale_of(model, len(gains.fault_proportional))
    found = _solve(closed, driven, scale, disc, None, fixed=True)
    lyapunov = -np.eye(len(scale)) if found is None else found[0]  # no metric: proves nothing
    return certificate(closed, np.tile(driven, (8, 1, 1)), lyapunov, disc, scale)


def _summary(proof: Certificate) -> tuple[float, float]:
    return round(proof.gamma, 4), round(float(proof.contraction.max()), 4)


def _problem(
    state: FloatArray, inputs: FloatArray, scale: FloatArray, disc: Disc | None, gamma: float | None, fixed: bool
) -> tuple[Any, dict[str, list[Any]], Any, list[Any]]:
    """Return objective, constraints by name, P and P L_i of the scaled problem; ``fixed``: state is closed already."""
    module, size = cvxpy(), len(scale)
    state, inputs, weight = state / scale[:, None] * scale, inputs / scale[:, None], np.diag(scale**2)
    matrix = module.Variable((size, size), symmetric=True)
    level = module.Variable() if gamma is None else module.Constant(gamma**2)
    injected = [np.zeros((size, 3)) if fixed else module.Variable((size, 3)) for _ in state]
    groups: dict[str, list[Any]] = {LEVEL: [matrix >> 0]}
    output = np.eye(3, size) * scale[0]
    for own, gain in zip(state, injected, strict=True):
        moved = matrix @ own - gain @ output
        pushed = matrix @ inputs
        block = module.bmat(
            [[moved + 0.5 * weight, pushed], [np.zeros(pushed.shape[::-1]), -0.5 * level * np.eye(pushed.shape[1])]]
        )
        groups[LEVEL].append(negative(block))
        if disc is not None:
            nothing, edge = np.zeros((size, size)), -0.5 * disc.radius**2 * matrix
            block = module.bmat([[-0.5 * matrix, moved - disc.centre * matrix], [nothing, edge]])
            groups.setdefault(REGION, []).append(negative(block))
    return level, groups, matrix, injected


def _solve(
    state: FloatArray,
    inputs: FloatArray,
    scale: FloatArray,
    disc: Disc | None,
    gamma: float | None,
    fixed: bool = False,
) -> tuple[FloatArray, FloatArray] | None:
    """Return P (n, n) and L_i (8, n, 3), or None."""
    level, groups, matrix, injected = _problem(state, inputs, scale, disc, gamma, fixed)
    if not minimised(level, groups):
        return None
    weight = np.asarray(matrix.value)
    lyapunov: FloatArray = weight / scale[:, None] / scale
    if fixed:
        return lyapunov, np.zeros((len(state), len(scale), 3))
    return lyapunov, np.array([scale[:, None] * np.linalg.solve(weight, gain.value) for gain in injected])


def _reason(
    state: FloatArray, inputs: FloatArray, scale: FloatArray, disc: Disc | None, gamma: float | None
) -> ValueError:
    """Return the error of a problem without a solution."""
    if gamma is not None:
        level, groups, _, _ = _problem(state, inputs, scale, disc, None, False)
        if minimised(level, groups):
            least = float(np.sqrt(level.value))
            rule = f"must be at least {ceil(least * NAMED * 1e4) / 1e4:.4f} for {LEVEL} with this disc"
            return ValueError(f"gamma {rule}, got {gamma!r}")
    level, groups, _, _ = _problem(state, inputs, scale, disc, gamma, False)
    return unsolvable(level, groups, "disc", disc)
