"""Theorem 2: its inequalities as they are printed, the paper's gains, the optimum, and what cannot be solved."""

import math
import re

import numpy as np
import pytest
from helpers.flexible_spacecraft import INERTIA, PYRAMID, li_spacecraft, random_appendages
from hypothesis import given, settings
from hypothesis import strategies as st

from ftac_gym.baselines.components.takagi_sugeno import TakagiSugenoModel
from ftac_gym.baselines.synthesis import ControllerGains, Disc, certify_controller, design_controller, published
from ftac_gym.spacecraft.spacecraft import Spacecraft
from ftac_gym.spacecraft.wheel_array import WheelArray

cvxpy = pytest.importorskip("cvxpy")

LI = TakagiSugenoModel(li_spacecraft())
PRINTED = TakagiSugenoModel(li_spacecraft(0.83674))
STATE, TORQUE = 0.1, 5.0 * math.sqrt(3.0)  # rad/s, N m


@pytest.fixture(scope="module")
def designed():
    return design_controller(LI)


@pytest.fixture(scope="module")
def cases(designed):
    """Feedback and proof by name."""
    feedback = published().controller
    return {"designed": (designed.gains, designed.proof), "published": (feedback, certify_controller(LI, feedback))}


NAMES = pytest.mark.parametrize("name", ["designed", "published"])


def largest(block):
    """Largest eigenvalue of a matrix whose upper blocks are given, relative to its size."""
    return np.linalg.eigvalsh(block, UPLO="U")[-1] / np.abs(block).max()


def printed_inequalities(feedback, lyapunov, gamma, radius, state, torque):
    """Largest relative eigenvalues of (41) to (44) over the rules, with X = P^-1 and Y_i = K_i X."""
    matrix = np.linalg.inv(lyapunov)
    found = {41: [], 42: [], 43: [largest(state**2 * np.eye(3) - matrix)], 44: []}
    for own, pulled, gain in zip(LI.state, LI.vibration_input, feedback, strict=True):
        unknown = gain @ matrix
        moved, driven = own @ matrix + LI.input @ unknown, np.concatenate([LI.input, pulled, LI.input], axis=1)
        columns = driven.shape[1]
        level = np.block(
            [
                [moved + moved.T, driven, matrix],
                [np.zeros((columns, 3)), -(gamma**2) * np.eye(columns), np.zeros((columns, 3))],
                [np.zeros((3, 3 + columns)), -np.eye(3)],
            ]
        )
        region = np.block([[-matrix, moved + 20.0 * matrix], [np.zeros((3, 3)), -(radius**2) * matrix]])
        found[41].append(largest(level))
        found[42].append(largest(region))
        found[44].append(largest(np.block([[-matrix, -unknown.T], [np.zeros((3, 3)), -(torque**2) * np.eye(3)]])))
    return {number: max(values) for number, values in found.items()}


@NAMES
def test_certified_gains_satisfy_the_printed_inequalities(cases, name):
    gains, proof = cases[name]
    assert proof.holds(STATE, TORQUE)
    more = 1.0 + 1e-5
    level, lyapunov = proof.certificate.gamma, proof.certificate.lyapunov
    found = printed_inequalities(gains.feedback, lyapunov, level * more, 20.0 * more, STATE, TORQUE * more)
    assert max(found.values()) < 0.0
    tight = printed_inequalities(gains.feedback, lyapunov, level * (1.0 - 1e-3), 20.0, STATE, TORQUE)
    assert tight[41] > 0.0


@NAMES
def test_bounds_are_exact(cases, name):
    gains, proof = cases[name]
    lyapunov, less = proof.certificate.lyapunov, 1.0 - 1e-4
    wide = proof.state_bound / less, proof.torque_bound / less
    assert printed_inequalities(gains.feedback, lyapunov, 2.0, 20.0, proof.state_bound * less, wide[1])[43] < 0.0
    assert printed_inequalities(gains.feedback, lyapunov, 2.0, 20.0, wide[0], wide[1])[43] > 0.0
    assert printed_inequalities(gains.feedback, lyapunov, 2.0, 20.0, STATE, wide[1])[44] < 0.0
    assert printed_inequalities(gains.feedback, lyapunov, 2.0, 20.0, STATE, proof.torque_bound * less)[44] > 0.0


def test_published_gains_hold_what_the_appendix_says(cases):
    proof = cases["published"][1].certificate
    assert proof.gamma == pytest.approx(1.7906, abs=2e-4)
    assert proof.gamma < 1.7919
    assert proof.reach.max() < 20.0


def test_published_gains_do_not_hold_with_the_printed_sign():
    assert certify_controller(PRINTED, published().controller).certificate.gamma == pytest.approx(1.992, abs=1e-3)
    assert design_controller(PRINTED).proof.certificate.gamma == pytest.approx(1.947, abs=1e-3)


def test_smallest_level_is_below_the_published_one(designed):
    assert designed.proof.certificate.gamma == pytest.approx(1.7903, abs=2e-4)


def test_gains_as_they_are_printed_are_worth_less(designed):
    """K = X^-1 Y instead of Y X^-1."""
    matrix = np.linalg.inv(designed.proof.certificate.lyapunov)
    printed = ControllerGains(np.linalg.solve(matrix, designed.gains.feedback @ matrix))
    worse = certify_controller(LI, printed).certificate.gamma
    assert worse > 1.7919
    assert worse > designed.proof.certificate.gamma + 1e-3


def test_disc_makes_no_difference(designed):
    free = design_controller(LI, None).proof.certificate
    assert free.gamma == pytest.approx(designed.proof.certificate.gamma, rel=1e-5)
    assert designed.proof.certificate.contraction.max() < 20.0 - 0.01
    assert free.in_disc and free.disc is None


def test_virtual_control_alone_does_not_shrink_the_norm_of_s():
    """Stable poles do not make s'(A + B K)s negative, as Eq. (49) has it."""
    closed = LI.state + LI.input @ published().controller.feedback
    assert np.linalg.eigvals(closed).real.max() < 0.0
    assert (np.linalg.eigvalsh(0.5 * (closed + closed.transpose(0, 2, 1)))[:, -1] > 0.1).all()


@NAMES
@settings(deadline=None, max_examples=20)
@given(seed=st.integers(0, 2**32 - 1))
def test_virtual_torque_stays_below_its_bound_from_small_errors(cases, name, seed):
    gains, proof = cases[name]
    closed, rng, step = LI.state + LI.input @ gains.feedback, np.random.default_rng(seed), 0.05
    error = rng.normal(size=(20, 3))
    error *= proof.state_bound / np.linalg.norm(error, axis=1, keepdims=True)
    identity = np.eye(3)
    for _ in range(60):
        weights = rng.dirichlet(np.full(8, 0.2), 20)
        torque = np.einsum("nr,rij,nj->ni", weights, gains.feedback, error)
        assert np.linalg.norm(torque, axis=1).max() <= TORQUE * (1.0 + 1e-6)
        matrix = step * np.einsum("nr,rij->nij", weights, closed)
        squared = matrix @ matrix
        growth = identity + matrix + squared / 2.0 + squared @ matrix / 6.0 + squared @ squared / 24.0
        error = np.einsum("nij,nj->ni", growth, error)


@settings(deadline=None, max_examples=8)
@given(modes=st.integers(1, 5), seed=st.integers(0, 1000), torque=st.floats(0.8, 8.0))
def test_any_other_craft_gets_gains_that_hold(modes, seed, torque):
    """Small bounds leave hardly any room: the level rises to dozens, and is still found."""
    spacecraft = Spacecraft(INERTIA, WheelArray(PYRAMID, 0.2), True, random_appendages(modes, seed))
    found = design_controller(TakagiSugenoModel(spacecraft), torque_bound=torque)
    assert found.proof.holds(STATE, torque)
    assert found.proof.certificate.peak_gain.max() <= found.proof.certificate.gamma
    assert found.proof.certificate.poles.real.max() < 0.0


def test_level_that_cannot_be_had_is_refused_with_the_one_that_can():
    with pytest.raises(ValueError, match=r"gamma must be at least .*\(41\).*got 1\.5") as refused:
        design_controller(LI, gamma=1.5)
    named = float(re.search(r"at least (\S+)", str(refused.value))[1])
    assert design_controller(LI, gamma=named).proof.certificate.gamma <= named * (1.0 + 1e-6)


def test_promise_of_a_sloppy_solver_is_not_believed(monkeypatch, designed):
    """The level of a design is its certificate, not the optimum of the solver."""
    solve, least = cvxpy.Problem.solve, designed.proof.certificate.gamma
    sloppy = {"tol_gap_abs": 0.01, "tol_gap_rel": 0.01, "tol_feas": 0.01}
    monkeypatch.setattr(cvxpy.Problem, "solve", lambda problem, **options: solve(problem, **options, **sloppy))
    found = design_controller(LI)
    assert found.proof.certificate.gamma > least * 1.001
    again = printed_inequalities(
        found.gains.feedback, found.proof.certificate.lyapunov, found.proof.certificate.gamma * 1.00001, 20.0, 0.1, 8.67
    )
    assert max(again.values()) < 0.0
    with pytest.raises(ValueError, match=r"gamma must be at least|solution must hold"):
        design_controller(LI, gamma=least * 0.999)


@pytest.mark.parametrize(
    ("change", "blamed"),
    [
        ({"disc": Disc(20.0, 20.0)}, r"without the pole disc \(42\); got"),
        ({"disc": Disc(-20.0, 1.0)}, r"without the pole disc \(42\)"),
        ({"torque_bound": 0.5}, r"without the bound on the virtual torque \(44\)"),
        ({"state_bound": 5.0}, r"without the bound on s\(0\) \(43\) or without the bound on the virtual torque \(44\)"),
    ],
)
def test_constraint_to_blame_is_named(change, blamed):
    with pytest.raises(ValueError, match=blamed):
        design_controller(LI, **change)


@pytest.mark.parametrize("field", ["gamma", "state_bound", "torque_bound"])
def test_numbers_are_checked(field):
    with pytest.raises(ValueError, match=f"{field} must be positive"):
        design_controller(LI, **{field: 0.0})


def test_gains_that_destabilise_prove_nothing():
    proof = certify_controller(LI, ControllerGains(-published().controller.feedback))
    assert not proof.holds(STATE, TORQUE)
    assert proof.certificate.gamma == float("inf")
    assert not proof.certificate.in_disc
