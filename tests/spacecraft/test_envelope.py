"""Envelopes of wheel arrays against linear programming."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

from ftac_gym.spacecraft import sign_pyramid
from ftac_gym.spacecraft.envelope import Envelope, Load, envelope_normals

DISTANCE = 0.5 * math.sqrt(2.0)
SIX = DISTANCE * np.array([[1, 1, 1, 1, 0, 0], [1, -1, 0, 0, 1, 1], [0, 0, 1, -1, 1, -1]])


def largest_scale(point, axes, reach):
    """Largest s for which some |tau_j| <= reach_j gives D tau = s point."""
    wheels = axes.shape[1]
    solution = linprog(
        c=np.r_[np.zeros(wheels), -1.0],
        A_eq=np.column_stack([axes, -point]),
        b_eq=np.zeros(3),
        bounds=[*((-limit, limit) for limit in reach), (0.0, None)],
    )
    assert solution.success
    return -solution.fun


@st.composite
def envelope(draw):
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    wheels = draw(st.integers(3, 6))
    axes = rng.normal(size=(3, wheels))
    axes /= np.linalg.norm(axes, axis=0)
    assume(np.linalg.svd(axes, compute_uv=False)[-1] > 0.05)
    return rng, axes, rng.uniform(0.1, 1.0, wheels)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(envelope(), st.floats(0.01, 2.0))
def test_point_inside_exactly_if_a_linear_program_says_so(drawn, size):
    rng, axes, reach = drawn
    point = rng.normal(size=3) * size
    scale = largest_scale(point, axes, reach)
    for factor, expected in ((0.999 * scale, True), (1.001 * scale, False)):
        inside = Envelope(axes).contains(Load(factor * point[None]), reach[None])
        assert inside.shape == (1,) and inside[0] == expected


@settings(max_examples=25, deadline=None, derandomize=True)
@given(envelope(), st.floats(0.01, 1.0))
def test_box_inside_exactly_if_all_its_corners_are(drawn, size):
    rng, axes, reach = drawn
    point, margin = rng.normal(size=3) * size, rng.uniform(0.0, size, 3)
    corners = point + margin * np.array(list(itertools.product([-1.0, 1.0], repeat=3)))
    scale = min(largest_scale(corner, axes, reach) for corner in corners)
    for factor, expected in ((0.999 * scale, True), (1.001 * scale, False)):
        assert Envelope(axes).contains(Load(factor * point[None], factor * margin[None]), reach[None])[0] == expected


def test_dead_wheels_leave_the_envelope_of_the_others():
    axes = SIX
    reach = np.array([[1.0, 1.0, 0.0, 0.5, 1.0, 0.0]])
    alive = reach[0] > 0.0
    for point in np.random.default_rng(0).normal(size=(20, 3)):
        scale = largest_scale(point, axes[:, alive], reach[0, alive])
        assert Envelope(axes).contains(Load(0.999 * scale * point[None]), reach)[0]
        assert not Envelope(axes).contains(Load(1.001 * scale * point[None]), reach)[0]


@pytest.mark.parametrize("reach", [(0.0, 1.0, 1.0), (0.0, 0.0, 0.0), (1e-300, 0.0, 1.0)])
def test_wheels_that_do_not_span_space_hold_nothing(reach):
    assert not Envelope(np.eye(3)).contains(Load(np.zeros((1, 3))), np.array([reach]))[0]


@pytest.mark.parametrize("axes", [np.eye(3)[:, :1], np.eye(3)[:, :2], np.eye(3)[:, [0, 0, 0, 0]]])
def test_too_few_directions_hold_nothing(axes):
    assert not Envelope(axes).contains(Load(np.zeros((2, 3))), np.ones((2, axes.shape[1]))).any()


def test_unlimited_wheels_hold_everything():
    assert Envelope(np.array(sign_pyramid())).contains(
        Load(np.full((1, 3), 1e6), np.ones((1, 3))), np.full((1, 4), np.inf)
    )[0]


def test_envelope_normals_are_unit_normals_of_pairs():
    normals = envelope_normals(SIX)
    assert normals.shape == (15, 3)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0)
    assert np.all(np.sum(np.abs(normals @ SIX) < 1e-12, axis=1) >= 2)
    assert len(envelope_normals(np.eye(3)[:, [0, 0, 1]])) == 2
