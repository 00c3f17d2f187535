"""Tests of `layouts`: unit axes that span space, and torque envelopes against known numbers and a program."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

from ftac_gym.spacecraft import WheelArray, orthogonal_and_skew, pyramid, sign_pyramid, three_orthogonal
from ftac_gym.spacecraft.envelope import envelope_normals

LAYOUTS = {
    "orthogonal and skew": (orthogonal_and_skew(), 1.414, 0.577),
    "sign pyramid": (sign_pyramid(), 1.633, 0.816),
    "pyramid of 30 deg": (pyramid(math.radians(30.0)), 1.549, 0.775),
    "pyramid of 45 deg": (pyramid(math.radians(45.0), azimuth=0.3), 1.414, 0.707),
    "pyramid of 54.7 deg": (pyramid(math.atan(math.sqrt(2.0))), 1.155, 0.577),
}
PROPERTY = settings(max_examples=60, deadline=None, derandomize=True)


def weakest(axes):
    """Torque in the weakest direction, in units of a wheel's torque: the sphere inscribed in the envelope."""
    return np.abs(envelope_normals(axes) @ axes).sum(axis=1).min()


def losses(axes):
    """The layouts (3, m - 1) left after the loss of each wheel."""
    return [np.delete(axes, wheel, axis=1) for wheel in range(axes.shape[1])]


def largest_torque(axes, direction):
    """Largest s for which some |tau_j| <= 1 gives D tau = s direction."""
    solution = linprog(
        c=np.r_[np.zeros(axes.shape[1]), -1.0],
        A_eq=np.column_stack([axes, -direction]),
        b_eq=np.zeros(3),
        bounds=[*([(-1.0, 1.0)] * axes.shape[1]), (0.0, None)],
    )
    assert solution.success
    return -solution.fun


def half_sphere(count):
    """Directions (count, 3) spread evenly over one half of the sphere; an envelope is the same on the other."""
    height = (np.arange(count) + 0.5) / count
    longitude = np.arange(count) * math.pi * (3.0 - math.sqrt(5.0))
    radius = np.sqrt(1.0 - height**2)
    return np.stack([radius * np.cos(longitude), radius * np.sin(longitude), height], axis=1)


@pytest.mark.parametrize(("layout", "healthy", "after_loss"), LAYOUTS.values(), ids=LAYOUTS)
def test_weakest_direction_before_and_after_the_worst_loss(layout, healthy, after_loss):
    axes = np.array(layout)
    assert weakest(axes) == pytest.approx(healthy, abs=5e-4)
    assert min(weakest(rest) for rest in losses(axes)) == pytest.approx(after_loss, abs=5e-4)


@pytest.mark.parametrize("name", ["orthogonal and skew", "pyramid of 30 deg"])
def test_weakest_direction_agrees_with_a_linear_program(name):
    axes = np.array(LAYOUTS[name][0])
    for wheels in (axes, min(losses(axes), key=weakest)):
        least = min(largest_torque(wheels, direction) for direction in half_sphere(200))
        # The grid meets the weakest direction within 8 degrees, whose cosine is 0.990.
        assert weakest(wheels) * (1.0 - 1e-9) <= least <= weakest(wheels) / 0.99


def test_any_wheel_of_a_pyramid_is_as_dear_as_the_others():
    for layout in (sign_pyramid(), pyramid(0.5)):
        after = [weakest(rest) for rest in losses(np.array(layout))]
        np.testing.assert_allclose(after, after[0], rtol=1e-12)


def test_three_orthogonal_wheels_have_none_to_spare():
    axes = np.array(three_orthogonal())
    np.testing.assert_array_equal(axes, np.eye(3))
    assert weakest(axes) == 1.0
    assert all(np.linalg.matrix_rank(rest) == 2 for rest in losses(axes))


@pytest.mark.parametrize("layout", [three_orthogonal(), *(entry[0] for entry in LAYOUTS.values())])
def test_layouts_are_plain_unit_axes_that_span_space(layout):
    assert all(type(value) is float for row in layout for value in row)
    axes = np.array(WheelArray(layout, torque_limit=0.2).axes)
    np.testing.assert_allclose(np.linalg.norm(axes, axis=0), 1.0, rtol=0.0, atol=1e-15)
    assert np.linalg.matrix_rank(axes) == 3


def test_sign_pyramid_is_the_one_of_the_wheel_array():
    assert sign_pyramid() == WheelArray.sign_pyramid(0.2, 12.0).axes
    np.testing.assert_allclose(np.array(sign_pyramid()) @ np.array(sign_pyramid()).T, 4.0 / 3.0 * np.eye(3), atol=1e-15)


def test_pyramid_with_the_elevation_of_a_cube_diagonal_is_the_sign_pyramid():
    drawn = np.array(pyramid(math.radians(35.26438968275466), azimuth=math.radians(45.0)))
    signs = np.array(sign_pyramid())
    nearest = np.argmax(signs.T @ drawn, axis=0)
    assert sorted(nearest) == [0, 1, 2, 3]
    np.testing.assert_allclose(drawn, signs[:, nearest], atol=1e-14)


@PROPERTY
@given(st.floats(-1.5, 1.5).filter(lambda angle: abs(angle) > 0.01), st.integers(3, 9), st.floats(-10.0, 10.0))
def test_pyramids_are_even_around_z(elevation, count, azimuth):
    axes = np.array(pyramid(elevation, count, azimuth))
    assert axes.shape == (3, count) and np.linalg.matrix_rank(axes) == 3
    np.testing.assert_allclose(np.linalg.norm(axes, axis=0), 1.0, atol=1e-14)
    np.testing.assert_allclose(np.arcsin(axes[2]), elevation, atol=1e-9)
    first = [math.cos(azimuth) * math.cos(elevation), math.sin(azimuth) * math.cos(elevation)]
    np.testing.assert_allclose(axes[:2, 0], first, atol=1e-14)
    turn = 2.0 * math.pi / count
    rotation = np.array([[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]])
    np.testing.assert_allclose(np.roll(axes[:2], -1, axis=1), rotation @ axes[:2], atol=1e-13)
    # The envelope does not depend on where the first wheel stands.
    assert weakest(axes) == pytest.approx(weakest(np.array(pyramid(elevation, count))), rel=1e-9)


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: pyramid(0.0), "elevation must lie within"),
        (lambda: pyramid(0.5 * math.pi), "elevation must lie within"),
        (lambda: pyramid(-2.0), "elevation must lie within"),
        (lambda: pyramid(float("nan")), "elevation must be finite"),
        (lambda: pyramid("steep"), "elevation must be a number"),
        (lambda: pyramid(0.5, 2), "count must be an integer of at least 3"),
        (lambda: pyramid(0.5, -4), "count must be an integer of at least 3"),
        (lambda: pyramid(0.5, 4.0), "count must be an integer of at least 3"),
        (lambda: pyramid(0.5, 4, float("inf")), "azimuth must be finite"),
        (lambda: pyramid(0.5, 4, None), "azimuth must be a number"),
    ],
)
def test_rules(build, message):
    with pytest.raises(ValueError, match=message):
        build()
