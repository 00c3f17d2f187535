"""Theorem 2 of Li, Xu and Chang 2023: feedback gains from matrix inequalities, for any flexible spacecraft."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ftac_gym.baselines.components.takagi_sugeno import TakagiSugenoModel
from ftac_gym.baselines.synthesis.certificate import SLACK, Certificate, certificate
from ftac_gym.baselines.synthesis.gain_matrices import ControllerGains
from ftac_gym.baselines.synthesis.regions import Disc
from ftac_gym.baselines.synthesis.solver import cvxpy, minimised, negative, unsolvable
from ftac_gym.utils.parameters import FloatArray, positive, require

DISC = Disc(-20.0, 20.0)
"""The region of the appendix, whose centre is printed without its sign: the right half plane is unstable."""

STATE_BOUND = 0.1
"""mu [rad/s]."""

TORQUE_BOUND = 5.0 * math.sqrt(3.0)
"""varsigma [N m]."""

LEVEL, REGION = "the H-infinity level (41)", "the pole disc (42)"
STATE, TORQUE = "the bound on s(0) (43)", "the bound on the virtual torque (44)"


@dataclass(frozen=True, eq=False)
class ControllerProof:
    """Certificate of feedback gains.

    Attributes
    ----------
    certificate
        Level from (f, vibration, d_1) errors to s, and the poles.
    state_bound
        Largest ``|s(0)|`` [rad/s] from which V = s'Ps < 1 holds.
    torque_bound
        Largest ``|K_i s|`` [N m] while V <= 1.
    """

    certificate: Certificate
    state_bound: float
    torque_bound: float

    def holds(self, state_bound: float, torque_bound: float) -> bool:
        """Return whether level and disc are proved, and these two bounds too."""
        wide = self.state_bound >= state_bound * (1.0 - SLACK) and self.torque_bound <= torque_bound * (1.0 + SLACK)
        return self.certificate.holds and wide


@dataclass(frozen=True, eq=False)
class ControllerDesign:
    """Gains with their certificate."""

    gains: ControllerGains
    proof: ControllerProof


def design_controller(
    model: TakagiSugenoModel,
    disc: Disc | None = DISC,
    gamma: float | None = None,
    state_bound: float = STATE_BOUND,
    torque_bound: float = TORQUE_BOUND,
) -> ControllerDesign:
    """Solve Theorem 2, with torques on the body in the place of wheels, and K_i = Y_i X^-1 (printed: X^-1 Y_i).

    Parameters
    ----------
    model
        The fuzzy model.
    disc
        Region for the poles of A_i + B K_i; None for no region.
    gamma
        Level from the disturbances of s' to s; None takes the smallest possible.
    state_bound
        mu: largest ``|s(0)|`` for which the bound on the torque holds [rad/s].
    torque_bound
        varsigma: bound on ``|K_i s|`` [N m].

    Raises
    ------
    ValueError
        If there is no solution: the message names the constraint that excludes one.
    MissingExtra
        Without CVXPY.
    """
    for name, value in (("state_bound", state_bound), ("torque_bound", torque_bound)):
        positive(value, name)
    if gamma is not None:
        positive(gamma, "gamma")
    level, groups, matrix, moved = _problem(model, disc, gamma, state_bound, torque_bound, None)
    if not minimised(level, groups):
        raise _reason(model, disc, gamma, state_bound, torque_bound)
    weight, unit = np.asarray(matrix.value), torque_bound / state_bound
    gains = ControllerGains(unit * np.array([np.linalg.solve(weight, part.value.T).T for part in moved]))
    proof = _proof(model, gains, np.linalg.inv(weight) / state_bound**2, disc)
    worth = round(proof.certificate.gamma, 4), round(proof.state_bound, 5), round(proof.torque_bound, 4)
    rule = "must be proved as the solver found it; gamma, bounds on s(0) and on the torque"
    level_proved = gamma is None or proof.certificate.gamma <= gamma * (1.0 + SLACK)
    require(level_proved and proof.holds(state_bound, torque_bound), "solution", rule, worth)
    return ControllerDesign(gains, proof)


def certify_controller(
    model: TakagiSugenoModel,
    gains: ControllerGains,
    disc: Disc | None = DISC,
    state_bound: float = STATE_BOUND,
    torque_bound: float = TORQUE_BOUND,
) -> ControllerProof:
    """Certify given gains: the smallest level that one P proves together with the other bounds, if one exists."""
    level, groups, matrix, _ = _problem(model, disc, None, state_bound, torque_bound, gains.feedback)
    solvable = minimised(level, groups)
    lyapunov = np.linalg.inv(np.asarray(matrix.value)) / state_bound**2 if solvable else -np.eye(3)
    return _proof(model, gains, lyapunov, disc)


def _inputs(model: TakagiSugenoModel) -> FloatArray:
    """Return the input matrices (8, 3, 6 + 2k) of the errors of f, of the vibration, and of d_1."""
    torque = np.tile(model.input, (8, 1, 1))
    return np.concatenate([torque, model.vibration_input, torque], axis=2)


def _push(model: TakagiSugenoModel) -> float:
    """Return the largest entry of the disturbances' matrices."""
    return float(np.abs(_inputs(model)).max())


def _proof(
    model: TakagiSugenoModel, gains: ControllerGains, lyapunov: FloatArray, disc: Disc | None
) -> ControllerProof:
    closed = model.state + model.input @ gains.feedback
    proof = certificate(closed, _inputs(model), lyapunov, disc, np.ones(3))
    values, vectors = np.linalg.eigh(lyapunov)
    if values[0] <= 0.0:
        return ControllerProof(proof, 0.0, float("inf"))
    inverse_root = vectors / np.sqrt(values) @ vectors.T
    largest = float(np.linalg.norm(gains.feedback @ inverse_root, ord=2, axis=(1, 2)).max())
    return ControllerProof(proof, float(1.0 / np.sqrt(values[-1])), largest)


def _problem(
    model: TakagiSugenoModel,
    disc: Disc | None,
    gamma: float | None,
    state_bound: float,
    torque_bound: float,
    feedback: FloatArray | None,
) -> tuple[Any, dict[str, list[Any]], Any, list[Any]]:
    """Return the square of a multiple of the level, constraints by name, X / mu^2 and Y_i / (mu varsigma).

    In these unknowns s has the unit mu, torques the unit varsigma, and the matrix of the disturbances is about one.
    Without this scaling the solver reports feasible problems as infeasible. Given feedback, Y_i = K_i X.
    """
    module = cvxpy()
    push, unit = _push(model), torque_bound / state_bound
    matrix = module.Variable((3, 3), symmetric=True)
    level = module.Variable() if gamma is None else module.Constant((gamma * state_bound / push) ** 2)
    moved = (
        [module.Variable((3, 3)) for _ in range(8)] if feedback is None else [gain / unit @ matrix for gain in feedback]
    )
    size = np.eye(3)
    groups: dict[str, list[Any]] = {LEVEL: [matrix >> 0], REGION: [], STATE: [], TORQUE: []}
    groups[STATE].append(matrix - size >> 0)
    for state, driven, part in zip(model.state, _inputs(model) / push, moved, strict=True):
        closed, columns = state @ matrix + unit * model.input @ part, driven.shape[1]
        block = module.bmat(
            [
                [closed, driven, state_bound * matrix],
                [np.zeros((columns, 3)), -0.5 * level * np.eye(columns), np.zeros((columns, 3))],
                [np.zeros((3, 3)), np.zeros((3, columns)), -0.5 * size],
            ]
        )
        groups[LEVEL].append(negative(block))
        if disc is not None:
            edge = -0.5 * disc.radius * matrix
            block = module.bmat([[edge, closed - disc.centre * matrix], [np.zeros((3, 3)), edge]])
            groups[REGION].append(negative(block))
        block = module.bmat([[-0.5 * matrix, -part.T], [np.zeros((3, 3)), -0.5 * size]])
        groups[TORQUE].append(negative(block))
    return level, {name: group for name, group in groups.items() if group}, matrix, moved


def _reason(
    model: TakagiSugenoModel, disc: Disc | None, gamma: float | None, state_bound: float, torque_bound: float
) -> ValueError:
    """Return the error of a problem without a solution."""
    if gamma is not None:
        level, groups, _, _ = _problem(model, disc, None, state_bound, torque_bound, None)
        if minimised(level, groups):
            least = float(np.sqrt(level.value)) * _push(model) / state_bound
            least = math.ceil(least * (1.0 + SLACK) * 1e4) / 1e4
            rule = f"must be at least {least:.4f} for {LEVEL} with these disc and bounds"
            return ValueError(f"gamma {rule}, got {gamma!r}")
    level, groups, _, _ = _problem(model, disc, gamma, state_bound, torque_bound, None)
    return unsolvable(level, groups, "disc, state_bound and torque_bound", (disc, state_bound, torque_bound))
