"""Allocation of a torque to wheels, against SciPy's linear programme."""

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

from ftac_gym.baselines.components.allocation import MinimaxAllocation, pseudo_inverse, scale_to_limits
from ftac_gym.spacecraft.wheel_array import WheelArray

ROOT = 1.0 / np.sqrt(2.0)
COPLANAR = {
    "three wheels in a plane": [[1, 0, 0, ROOT], [0, 1, 0, ROOT], [0, 0, 1, 0]],
    "all but one in a plane": [[1, 0, ROOT, ROOT, 0], [0, 1, ROOT, -ROOT, 0], [0, 0, 0, 0, 1]],
    "two wheels on each axis": np.hstack([np.eye(3), np.eye(3)]),
    "opposite wheels": np.hstack([np.eye(3), -np.eye(3)[:, :1]]),
}
SEEDS = st.integers(0, 2**32 - 1)


def random_layout(seed, count):
    """Return wheels with random axes that span space well, and unequal limits; and a generator."""
    random = np.random.default_rng(seed)
    axes = random.normal(size=(3, count))
    axes /= np.linalg.norm(axes, axis=0)
    assume(np.linalg.svd(axes, compute_uv=False)[2] > 0.05)
    return WheelArray(axes.tolist(), random.uniform(0.05, 1.0, count).tolist()), random


def largest_share(wheels, torque):
    """Return the smallest possible largest share of the torque limits, by linear programming."""
    count = wheels.count
    # Variables: wheel torques u and the share s; |u_j| <= s r_j, D u = torque.
    limits = np.diag(wheels.torque_limits)
    rows = np.eye(count)
    result = linprog(
        np.append(np.zeros(count), 1.0),
        A_ub=np.block([[rows, -np.diag(limits)[:, None]], [-rows, -np.diag(limits)[:, None]]]),
        b_ub=np.zeros(2 * count),
        A_eq=np.hstack([wheels.axis_matrix, np.zeros((3, 1))]),
        b_eq=torque,
        bounds=[(None, None)] * count + [(0.0, None)],
        method="highs",
    )
    assert result.success
    return result.fun


def assert_minimax(wheels, torque):
    allocated = MinimaxAllocation(wheels)(torque)
    assert allocated.shape == (len(torque), wheels.count)
    size = np.abs(torque).max(axis=1)
    np.testing.assert_allclose((allocated @ wheels.axis_matrix.T) / size[:, None], torque / size[:, None], atol=1e-9)
    share = (np.abs(allocated) / wheels.torque_limits).max(axis=1)
    best = np.array([largest_share(wheels, row) for row in torque])
    np.testing.assert_allclose(share, best, rtol=1e-6)


@settings(max_examples=40, deadline=None)
@given(seed=SEEDS, count=st.integers(3, 6))
@example(seed=6460, count=6)  # two facets that are nearly, but not quite, parallel
def test_minimax_is_the_optimum_of_the_linear_programme(seed, count):
    wheels, random = random_layout(seed, count)
    assert_minimax(wheels, random.normal(size=(4, 3)) * random.uniform(0.01, 10.0))


@pytest.mark.parametrize("limit", [0.2, "unequal"])
@pytest.mark.parametrize("layout", COPLANAR)
def test_minimax_of_layouts_with_wheels_in_a_plane(layout, limit):
    axes = np.array(COPLANAR[layout], dtype=float)
    limits = np.linspace(0.1, 0.5, axes.shape[1]).tolist() if limit == "unequal" else limit
    wheels = WheelArray(axes.tolist(), limits)
    assert_minimax(wheels, np.random.default_rng(0).normal(size=(60, 3)))


def test_minimax_of_the_sign_pyramid():
    wheels = WheelArray.sign_pyramid(0.2, None)
    assert_minimax(wheels, np.random.default_rng(1).normal(size=(60, 3)))
    # About a body axis all four wheels pull alike: |t| sqrt(3) / 4 each.
    allocated = MinimaxAllocation(wheels)(np.eye(3))
    np.testing.assert_allclose(np.abs(allocated), np.sqrt(3.0) / 4.0, atol=1e-12)


def test_minimax_of_three_wheels_is_the_inverse():
    wheels = WheelArray(np.eye(3).tolist(), (0.1, 0.2, 0.3))
    torque = np.random.default_rng(0).normal(size=(20, 3))
    np.testing.assert_allclose(MinimaxAllocation(wheels)(torque), torque, atol=1e-12)


def test_minimax_without_limits_treats_the_wheels_as_equals():
    axes = WheelArray.sign_pyramid(0.2, None).axes
    torque = np.random.default_rng(0).normal(size=(20, 3))
    np.testing.assert_allclose(
        MinimaxAllocation(WheelArray(axes, None))(torque), MinimaxAllocation(WheelArray(axes, 1.0))(torque), atol=1e-12
    )


@settings(max_examples=20, deadline=None)
@given(seed=SEEDS, factor=st.floats(-50.0, 50.0))
def test_minimax_is_odd_and_homogeneous(seed, factor):
    wheels, random = random_layout(seed, 4)
    allocation, torque = MinimaxAllocation(wheels), random.normal(size=(3, 3))
    np.testing.assert_allclose(allocation(factor * torque), factor * allocation(torque), rtol=1e-9, atol=1e-9)


def test_minimax_of_no_torque_is_zero():
    np.testing.assert_array_equal(MinimaxAllocation(WheelArray.sign_pyramid(0.2, None))(np.zeros((2, 3))), 0.0)


@settings(max_examples=30, deadline=None)
@given(seed=SEEDS, count=st.integers(3, 6))
def test_pseudo_inverse_is_the_least_squares_solution(seed, count):
    wheels, random = random_layout(seed, count)
    axes, torque = wheels.axis_matrix, random.normal(size=3)
    command = pseudo_inverse(axes) @ torque
    np.testing.assert_allclose(axes @ command, torque, atol=1e-9)
    # Least squares: nothing of it lies in the null space.
    null_space = np.linalg.svd(axes)[2][3:]
    np.testing.assert_allclose(null_space @ command, 0.0, atol=1e-9)


@pytest.mark.parametrize("build", [lambda wheels: pseudo_inverse(wheels.axis_matrix), MinimaxAllocation])
@pytest.mark.parametrize("axes", [np.eye(3)[:, :2], [[1, 0, ROOT], [0, 1, ROOT], [0, 0, 0]]])
def test_wheels_must_span_space(build, axes):
    with pytest.raises(ValueError, match="axes must span three dimensions"):
        build(WheelArray(np.array(axes, dtype=float).tolist(), 0.2))


@settings(max_examples=40, deadline=None)
@given(seed=SEEDS, count=st.integers(1, 6))
def test_scaling_keeps_direction_and_limits(seed, count):
    random = np.random.default_rng(seed)
    limits = random.uniform(0.05, 1.0, count)
    command = random.normal(size=(8, count)) * random.uniform(0.01, 5.0)
    scaled = scale_to_limits(command, limits)
    share = (np.abs(command) / limits).max(axis=1)
    assert (np.abs(scaled) <= limits * (1.0 + 1e-12)).all()
    np.testing.assert_allclose(scaled * np.maximum(share, 1.0)[:, None], command, rtol=1e-12)
    np.testing.assert_array_equal(scaled[share <= 1.0], command[share <= 1.0])
    np.testing.assert_allclose((np.abs(scaled[share > 1.0]) / limits).max(axis=1), 1.0)
