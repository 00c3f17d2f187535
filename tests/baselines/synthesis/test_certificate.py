"""Certificates by hand: they are the judge of what a solver returns."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ftac_gym.baselines.synthesis import Disc
from ftac_gym.baselines.synthesis.certificate import certificate

LOW_PASS = np.full((8, 1, 1), -2.0), np.full((8, 1, 1), 3.0)
"""e' = -2 e + 3 d, whose largest gain is 1.5."""


def low_pass(weight, disc=None):
    return certificate(*LOW_PASS, np.array([[weight]]), disc, np.ones(1))


@settings(deadline=None, max_examples=30)
@given(weight=st.floats(0.26, 100.0))
def test_level_of_one_state(weight):
    """2 a p + 1 + (p b / gamma)^2 = 0."""
    proof = low_pass(weight)
    assert proof.gamma == pytest.approx(3.0 * weight / np.sqrt(4.0 * weight - 1.0))
    assert proof.gamma >= 1.5 * (1.0 - 1e-12)
    assert proof.peak_gain == pytest.approx(1.5)
    assert proof.holds


def test_best_weight_proves_the_norm_itself():
    assert low_pass(0.5).gamma == pytest.approx(1.5)


@pytest.mark.parametrize("weight", [0.2, 0.0, -1.0])
def test_weight_that_proves_nothing(weight):
    proof = low_pass(weight)
    assert proof.gamma == float("inf")
    assert not proof.holds


def test_unstable_rule_among_stable_ones():
    closed = LOW_PASS[0].copy()
    closed[5] = 0.1
    proof = certificate(closed, LOW_PASS[1], np.eye(1), None, np.ones(1))
    assert proof.gamma == float("inf")
    assert proof.poles[5, 0].real == pytest.approx(0.1)


@pytest.mark.parametrize(
    ("disc", "inside"), [(Disc(-1.0, 1.1), True), (Disc(-1.0, 0.9), False), (Disc(2.0, 2.0), False)]
)
def test_disc(disc, inside):
    proof = low_pass(1.0, disc)
    assert proof.in_disc == proof.holds == inside
    assert proof.reach == pytest.approx(np.full(8, abs(-2.0 - disc.centre)))
    assert proof.contraction == pytest.approx(proof.reach)


def test_poles_inside_are_not_enough_without_a_metric_that_shows_it():
    """Within the unit circle around -1, but far from normal."""
    closed = np.tile([[-1.0, 10.0], [0.0, -1.0]], (8, 1, 1))
    pushed, disc = np.tile(np.eye(2), (8, 1, 1)), Disc(-1.0, 1.0)
    plain = certificate(closed, pushed, 100.0 * np.eye(2), disc, np.ones(2))
    assert plain.in_disc and not plain.holds
    fitting = certificate(closed, pushed, np.diag([1.0, 400.0]), disc, np.ones(2))
    assert fitting.holds
    assert fitting.contraction == pytest.approx(np.full(8, 0.5))


@settings(deadline=None, max_examples=30)
@given(seed=st.integers(0, 2**32 - 1))
def test_scale_changes_nothing(seed):
    rng = np.random.default_rng(seed)
    closed = -2.0 * np.eye(4) + 0.2 * rng.normal(size=(8, 4, 4))
    inputs, weight = rng.normal(size=(8, 4, 2)), np.eye(4)
    plain = certificate(closed, inputs, weight, Disc(-2.0, 1.9), np.ones(4))
    scaled = certificate(closed, inputs, weight, Disc(-2.0, 1.9), np.array([1e-2, 1.0, 30.0, 0.1]))
    assert scaled.gamma == pytest.approx(plain.gamma, rel=1e-6)
    assert scaled.contraction == pytest.approx(plain.contraction, rel=1e-6)
    assert scaled.reach == pytest.approx(plain.reach, rel=1e-6)
    assert plain.peak_gain.max() <= plain.gamma


@pytest.mark.parametrize(
    ("centre", "radius", "field"), [(-1.0, 0.0, "radius"), (-1.0, -2.0, "radius"), (np.nan, 1.0, "centre")]
)
def test_disc_is_checked(centre, radius, field):
    with pytest.raises(ValueError, match=f"{field} must be"):
        Disc(centre, radius)


def test_reach_of_matrices():
    matrices = np.array([[[0.0, 3.0], [-3.0, 0.0]], [[-4.0, 0.0], [0.0, -1.0]]])
    assert Disc(-4.0, 1.0).reach(matrices) == pytest.approx([5.0, 3.0])
