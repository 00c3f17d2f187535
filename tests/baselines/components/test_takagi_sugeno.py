"""The fuzzy model against the equations of motion, and the memberships."""

import numpy as np
import pytest
from helpers.flexible_spacecraft import INERTIA, PYRAMID, li_spacecraft, random_appendages
from hypothesis import given, settings
from hypothesis import strategies as st

from ftac_gym.baselines.components.takagi_sugeno import (
    GaussianSets,
    NearestRule,
    TakagiSugenoModel,
    TriangularSets,
    corners,
)
from ftac_gym.spacecraft.spacecraft import Spacecraft
from ftac_gym.spacecraft.wheel_array import WheelArray

BOUND = 0.7  # rad/s
MEMBERSHIPS = {"triangular": TriangularSets(), "gaussian": GaussianSets(), "nearest": NearestRule()}
EITHER = [pytest.param(membership, id=name) for name, membership in MEMBERSHIPS.items()]
SEEDS = st.integers(0, 2**32 - 1)


def bending(modes, seed):
    return Spacecraft(INERTIA, WheelArray(PYRAMID, 0.2), True, random_appendages(modes, seed))


def equations_of_motion(body, rate, torque, varpi):
    """w' and (eta, eta' + delta w)' by the mass matrix of body and modes, which the model does not use."""
    modes = body.appendages
    inertia, delta = body.inertia_matrix, np.array(modes.coupling)
    frequencies, count = np.array(modes.frequencies), modes.count
    mass = np.block([[inertia, delta.T], [delta, np.eye(count)]])
    accelerations, swings = [], []
    for w, t, v in zip(rate, torque, varpi, strict=True):
        eta, swing = v[:count], v[count:] - delta @ w
        restoring = 2.0 * np.array(modes.damping_ratios) * frequencies * swing + frequencies**2 * eta
        turning = np.cross(w, inertia @ w + delta.T @ swing)
        solved = np.linalg.solve(mass, np.concatenate([t - turning, -restoring]))
        accelerations.append(solved[:3])
        swings.append(np.concatenate([swing, solved[3:] + delta @ solved[:3]]))
    return np.array(accelerations), np.array(swings)


def drawn(modes, seed, reach, count=20):
    """A spacecraft, its model, and random rates, torques and vibrations."""
    rng = np.random.default_rng(seed)
    spacecraft = bending(modes, seed)
    motion = rng.uniform(-reach, reach, (count, 3)), rng.normal(size=(count, 3)), rng.normal(size=(count, 2 * modes))
    return spacecraft, TakagiSugenoModel(spacecraft), *motion


def error(value, truth):
    return np.abs(value - truth).max() / np.abs(truth).max()


@settings(deadline=None, max_examples=40)
@given(modes=st.integers(1, 6), seed=SEEDS)
def test_blend_of_triangular_sets_is_the_nonlinear_model_within_the_sector(modes, seed):
    body, model, rate, torque, varpi = drawn(modes, seed, BOUND)
    turn, swing = model.slopes(TriangularSets()(rate), rate, torque, varpi)
    expected_turn, expected_swing = equations_of_motion(body, rate, torque, varpi)
    assert error(turn, expected_turn) < 1e-12
    assert error(swing, expected_swing) < 1e-12


@pytest.mark.parametrize("corner", range(8))
def test_blend_is_exact_on_the_edge_of_the_sector_and_wrong_beyond(corner):
    body, model, _, torque, varpi = drawn(3, 5, BOUND, 1)
    for stretch, exact in ((1.0, True), (1.3, False)):
        rate = stretch * model.corners[corner : corner + 1]
        turn, _ = model.slopes(TriangularSets()(rate), rate, torque, varpi)
        assert (error(turn, equations_of_motion(body, rate, torque, varpi)[0]) < 1e-12) == exact


def test_sector_can_be_wider():
    body, _, rate, torque, varpi = drawn(2, 9, 2.0)
    wide = TakagiSugenoModel(body, 2.0)
    assert np.abs(wide.corners).max() == 2.0
    turn, _ = wide.slopes(TriangularSets(2.0)(rate), rate, torque, varpi)
    assert error(turn, equations_of_motion(body, rate, torque, varpi)[0]) < 1e-12


@pytest.mark.parametrize(
    ("membership", "least"), [(GaussianSets(), 0.01), (GaussianSets(width=0.5), 0.4), (NearestRule(), 5.0)]
)
def test_other_memberships_only_approximate(membership, least):
    """The gyroscopic term alone, at a rate of the paper's manoeuvres; sets as wide as the sector are right at rest."""
    model, rate, still = TakagiSugenoModel(li_spacecraft()), np.array([[0.05, -0.08, 0.03]]), np.zeros((1, 3))
    varpi = np.concatenate([np.zeros((1, 4)), rate @ np.array(li_spacecraft().appendages.coupling).T], axis=1)
    turn, _ = model.slopes(membership(rate), rate, still, varpi)
    exact, _ = model.slopes(TriangularSets()(rate), rate, still, varpi)
    assert error(exact, equations_of_motion(li_spacecraft(), rate, still, varpi)[0]) < 1e-12
    assert error(turn, exact) > least


@pytest.mark.parametrize("membership", EITHER)
@settings(deadline=None, max_examples=60)
@given(rates=st.lists(st.tuples(*(st.floats(-1e3, 1e3),) * 3), min_size=1, max_size=8))
def test_memberships_are_shares_at_any_rate(membership, rates):
    weights = membership(np.array(rates))
    assert weights.shape == (len(rates), 8)
    assert weights.min() >= 0.0
    assert np.allclose(weights.sum(axis=1), 1.0, rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("membership", EITHER)
def test_rules_are_in_the_order_of_the_corners(membership):
    assert (membership(corners()).argmax(axis=1) == np.arange(8)).all()
    assert np.array_equal(corners(1.0)[[0, 1, 2, 4, 7]], [(1, 1, 1), (1, 1, -1), (1, -1, 1), (-1, 1, 1), (-1, -1, -1)])


@pytest.mark.parametrize("membership", EITHER)
def test_each_craft_by_itself_is_as_in_a_batch(membership):
    rates = np.random.default_rng(1).normal(size=(50, 3))
    alone = np.concatenate([membership(rate[None]) for rate in rates])
    assert np.allclose(alone, membership(rates), rtol=0.0, atol=1e-15)


def test_one_rule_alone_fires_at_a_corner_and_all_alike_at_rest():
    assert np.array_equal(TriangularSets()(corners()), np.eye(8))
    assert np.allclose(TriangularSets()(np.zeros((1, 3))), 0.125, rtol=0.0, atol=1e-15)
    assert np.allclose(GaussianSets()(np.zeros((1, 3))), 0.125, rtol=0.0, atol=1e-15)
    assert set(NearestRule()(np.random.default_rng(0).normal(size=(9, 3))).ravel()) == {0.0, 1.0}


def test_triangular_sets_hold_the_last_rule_beyond_the_sector():
    sets, rates = TriangularSets(), np.random.default_rng(2).uniform(-3.0, 3.0, (100, 3))
    assert np.array_equal(sets(rates), sets(np.clip(rates, -BOUND, BOUND)))


def test_triangular_sets_blend_the_corners_to_the_rate():
    rates = np.random.default_rng(3).uniform(-BOUND, BOUND, (100, 3))
    assert np.allclose(TriangularSets()(rates) @ corners(), rates, rtol=0.0, atol=1e-14)


@pytest.mark.parametrize("bound", [0.0, -0.7, float("nan"), float("inf")])
@pytest.mark.parametrize("kind", [TriangularSets, GaussianSets])
def test_bound_is_checked(kind, bound):
    with pytest.raises(ValueError, match="bound must be"):
        kind(bound)


def test_width_is_checked():
    with pytest.raises(ValueError, match="width must be positive"):
        GaussianSets(width=0.0)


def test_model_is_one_of_a_flexible_spacecraft():
    with pytest.raises(ValueError, match="appendages must be given"):
        TakagiSugenoModel(Spacecraft(INERTIA, WheelArray(PYRAMID, 0.2), True))


def test_vibration_of_another_craft_is_refused():
    model = TakagiSugenoModel(li_spacecraft())
    with pytest.raises(ValueError, match="vibration must have 8 columns"):
        model.slopes(np.full((1, 8), 0.125), np.zeros((1, 3)), np.zeros((1, 3)), np.zeros((1, 6)))
