"""Theorem 1: its inequalities as they are printed, the paper's gains, the optimum, and what cannot be solved."""

import numpy as np
import pytest
from helpers.flexible_spacecraft import INERTIA, PYRAMID, li_spacecraft, random_appendages
from hypothesis import given, settings
from hypothesis import strategies as st

from ftac_gym.baselines.components.takagi_sugeno import TakagiSugenoModel, TriangularSets
from ftac_gym.baselines.synthesis import (
    Disc,
    certify_observer,
    design_observer,
    error_dynamics,
    error_inputs,
    published,
)
from ftac_gym.spacecraft.spacecraft import Spacecraft
from ftac_gym.spacecraft.wheel_array import WheelArray

pytest.importorskip("cvxpy")

DISC = Disc(-10.0, 10.0)
LI = TakagiSugenoModel(li_spacecraft())
OTHER_WHEELS = WheelArray(PYRAMID, 0.2)
OTHER = TakagiSugenoModel(Spacecraft(INERTIA, OTHER_WHEELS, True, random_appendages(3, 4)))
SMALL = TakagiSugenoModel(Spacecraft(INERTIA, OTHER_WHEELS, True, random_appendages(1, 2)))
SCALE = {LI: 1.0 / 300.0, OTHER: 1.0 / 20.0}  # 1/(kg m^2)


@pytest.fixture(scope="module")
def designed():
    return design_observer(LI)


@pytest.fixture(scope="module")
def proof_of_published():
    return certify_observer(LI, published().observer)


@pytest.fixture(scope="module")
def other():
    return design_observer(OTHER)


@pytest.fixture(scope="module")
def cases(designed, proof_of_published, other):
    """Model, gains and certificate by name."""
    return {
        "designed": (LI, designed.gains, designed.certificate),
        "published": (LI, published().observer, proof_of_published),
        "other spacecraft": (OTHER, other.gains, other.certificate),
    }


NAMES = pytest.mark.parametrize("name", ["designed", "published", "other spacecraft"])


def printed_matrices(model, gains):
    """The matrices of Eq. (20) as they are printed: M, A_i, K_i, C, B_d."""
    rows = 2 * model.modes
    identity, nothing = np.eye(3), np.zeros((3, 3))
    mixing = np.block(
        [
            [identity, nothing, np.zeros((3, rows))],
            [gains.fault_proportional, identity, np.zeros((3, rows))],
            [gains.vibration_proportional, np.zeros((rows, 3)), np.eye(rows)],
        ]
    )
    state = [
        np.block(
            [
                [own, model.input, pulled],
                [nothing, nothing, np.zeros((3, rows))],
                [np.zeros((rows, 6)), model.vibration],
            ]
        )
        for own, pulled in zip(model.state, model.vibration_input, strict=True)
    ]
    injected = [np.concatenate(parts) for parts in zip(gains.rate, gains.fault, gains.vibration, strict=True)]
    seen = np.concatenate([identity, np.zeros((3, 3 + rows))], axis=1)
    inputs = np.block([[model.input, nothing], [nothing, identity], [np.zeros((rows, 6))]])
    return mixing, state, injected, seen, inputs


def symmetric(matrix):
    return matrix + matrix.T


def largest(block, *scales):
    """Largest eigenvalue of a block matrix after a congruence, which leaves its sign and keeps rounding small."""
    scale = np.concatenate(scales)
    return np.linalg.eigvalsh(scale[:, None] * block * scale)[-1]


def printed_inequalities(model, gains, lyapunov, gamma, disc):
    """Largest eigenvalues of (23) and of (24) over the rules, with Q = M^-T P M^-1 and Y_i = Q K_i."""
    mixing, state, injected, seen, inputs = printed_matrices(model, gains)
    inverse = np.linalg.inv(mixing)
    size = len(mixing)
    scale = np.concatenate([np.full(3, SCALE[model]), np.ones(3), np.full(size - 6, 0.1)])
    weight = inverse.T @ lyapunov @ inverse
    level, region = [], []
    for own, gain in zip(state, injected, strict=True):
        unknown = weight @ gain
        pushed = mixing.T @ weight @ inputs
        falls = symmetric(mixing.T @ weight @ own - mixing.T @ unknown @ seen) + np.eye(size)
        level.append(largest(np.block([[falls, pushed], [pushed.T, -(gamma**2) * np.eye(6)]]), scale, np.ones(6)))
        moved = mixing.T @ (-disc.centre * weight @ mixing + weight @ own - unknown @ seen)
        whole = mixing.T @ weight @ mixing  # the first row and column of (24) times M' and M
        region.append(largest(np.block([[-whole, moved], [moved.T, -(disc.radius**2) * whole]]), scale, scale))
    return max(level), max(region)


@NAMES
def test_certified_gains_satisfy_the_printed_inequalities(cases, name):
    model, gains, proof = cases[name]
    assert proof.holds
    assert np.linalg.eigvalsh(proof.lyapunov)[0] > 0.0
    wider = Disc(-10.0, 10.0 * (1.0 + 1e-5))
    assert max(printed_inequalities(model, gains, proof.lyapunov, proof.gamma * (1.0 + 1e-5), wider)) < 0.0
    level, _ = printed_inequalities(model, gains, proof.lyapunov, proof.gamma * (1.0 - 1e-3), wider)
    assert level > 0.0


@NAMES
def test_error_dynamics_are_those_of_the_paper(cases, name):
    model, gains, _ = cases[name]
    mixing, state, injected, seen, inputs = printed_matrices(model, gains)
    assert np.allclose(error_inputs(model, gains), np.linalg.solve(mixing, inputs), rtol=1e-12, atol=1e-12)
    for found, own, gain in zip(error_dynamics(model, gains), state, injected, strict=True):
        expected = np.linalg.solve(mixing, own - gain @ seen)
        assert np.allclose(found, expected, rtol=1e-10, atol=1e-10 * np.abs(expected).max())


def test_published_gains_hold_what_the_appendix_says(proof_of_published):
    assert proof_of_published.holds
    assert proof_of_published.gamma == pytest.approx(1.6534, abs=2e-4)
    assert proof_of_published.gamma < 1.6563
    assert proof_of_published.reach.max() == pytest.approx(9.926, abs=1e-3)


def test_published_gains_do_not_hold_with_the_printed_sign():
    proof = certify_observer(TakagiSugenoModel(li_spacecraft(0.83674)), published().observer)
    outside = np.flatnonzero(proof.reach > 10.0) + 1
    assert outside.tolist() == [3, 4, 8]
    assert proof.reach[outside - 1] == pytest.approx([10.097, 10.230, 10.218], abs=1e-3)
    assert not proof.in_disc and not proof.holds
    assert proof.gamma == float("inf")


def test_smallest_level_is_below_the_published_one(designed):
    assert designed.certificate.gamma == pytest.approx(1.6203, abs=2e-4)
    assert designed.certificate.disc == DISC


@NAMES
def test_level_is_at_least_one_and_at_least_that_of_every_rule(cases, name):
    """A constant d_1 looks like a fault: the gain from it to the error of f is exactly -1."""
    model, gains, proof = cases[name]
    closed, inputs = error_dynamics(model, gains), error_inputs(model, gains)
    constant = -np.linalg.solve(closed, np.tile(inputs, (8, 1, 1)))
    assert np.allclose(constant[:, 3:6, :3], -np.eye(3), rtol=0.0, atol=1e-6)
    assert proof.peak_gain.min() >= 1.0
    assert proof.peak_gain.max() <= proof.gamma
    # A level is above the norm of a rule if and only if this matrix has no eigenvalue on the imaginary axis.
    for own in closed:
        for level, above in ((proof.gamma * (1.0 + 1e-6), True), (0.999 * proof.peak_gain.min(), False)):
            hamiltonian = np.block([[own, inputs @ inputs.T / level**2], [-np.eye(len(own)), -own.T]])
            assert (np.abs(np.linalg.eigvals(hamiltonian).real).min() > 1e-6) == above


@NAMES
@settings(deadline=None, max_examples=40)
@given(seed=st.integers(0, 2**32 - 1))
def test_poles_of_every_blend_lie_in_the_disc(cases, name, seed):
    """One matrix for all rules proves more than the rules by themselves."""
    model, gains, _ = cases[name]
    weights = np.random.default_rng(seed).dirichlet(np.full(8, 0.3), 10)
    blended = np.einsum("nr,rij->nij", weights, error_dynamics(model, gains))
    assert DISC.reach(blended).max() <= 10.0 * (1.0 + 1e-6)


def simulated(closed, inputs, weights, disturbance, start, step):
    """Errors (T + 1, N, n) by the classic Runge-Kutta method, rules and disturbance held within a step."""
    error, errors = start, [start]
    for blend, push in zip(weights, disturbance, strict=True):
        matrix = np.einsum("nr,rij->nij", blend, closed)
        driven = push @ inputs.T

        def slope(e, matrix=matrix, driven=driven):
            return np.einsum("nij,nj->ni", matrix, e) + driven

        first = slope(error)
        second = slope(error + 0.5 * step * first)
        third = slope(error + 0.5 * step * second)
        error = error + step / 6.0 * (first + 2.0 * second + 2.0 * third + slope(error + step * third))
        errors.append(error)
    return np.array(errors)


@pytest.fixture(scope="module")
def tumbling():
    """Weights (T, N, 8) of rates that sweep the sector."""
    time, rng = 0.01 * np.arange(4000), np.random.default_rng(7)
    frequency, phase = rng.uniform(0.1, 5.0, (2, 12, 3))
    rate = 0.7 * np.sin(frequency * time[:, None, None] + phase)
    return TriangularSets()(rate.reshape(-1, 3)).reshape(4000, 12, 8)


@NAMES
def test_energy_of_the_error_stays_below_the_level(cases, name, tumbling):
    model, gains, proof = cases[name]
    closed, inputs = error_dynamics(model, gains), error_inputs(model, gains)
    time, rng = 0.01 * np.arange(len(tumbling)), np.random.default_rng(8)
    frequency = np.array([0.0, 0.1, 0.3, 0.6, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 10.0, 20.0])
    push = np.cos(frequency * time[:, None])[:, :, None] * rng.normal(size=(12, 6))
    errors = simulated(closed, inputs, tumbling, push, np.zeros((12, len(inputs))), 0.01)
    ratio = np.sqrt((errors[1:] ** 2).sum(axis=(0, 2)) / (push**2).sum(axis=(0, 2)))
    assert ratio.max() < proof.gamma
    assert ratio.max() > 0.5


@NAMES
def test_undisturbed_error_dies_away_and_its_lyapunov_function_never_rises(cases, name, tumbling):
    model, gains, proof = cases[name]
    closed, inputs = error_dynamics(model, gains), error_inputs(model, gains)
    start = np.random.default_rng(9).normal(size=(12, len(inputs)))
    errors = simulated(closed, inputs, tumbling, np.zeros((4000, 12, 6)), start, 0.01)
    levels = np.einsum("tni,ij,tnj->tn", errors, proof.lyapunov, errors)
    assert (np.diff(levels, axis=0) < 1e-9 * levels[:-1]).all()
    assert (levels[-1] < 1e-3 * levels[0]).all()
