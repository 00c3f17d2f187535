"""Modified Rodrigues parameters, against SciPy, finite differences and the quaternion."""

import numpy as np
import pytest
from helpers.rotations import (
    PROPERTY,
    TIGHT,
    central_difference,
    quaternion,
    same_attitude,
    scipy_rotation,
    triple,
    unit_quaternions,
    unit_vector,
    vectors,
)
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from ftac_gym import attitude as att


def test_mrp_matches_scipy_and_the_tangent_of_a_quarter_angle() -> None:
    q = unit_quaternions()
    sigma = att.mrp_from_quaternion(q)
    np.testing.assert_allclose(sigma, scipy_rotation(q).as_mrp(), **TIGHT)
    axis = np.array([0.48, 0.6, -0.64])
    turn = att.quaternion_from_rotation_vector(1.2 * axis)
    np.testing.assert_allclose(att.mrp_from_quaternion(turn), np.tan(0.3) * axis, **TIGHT)
    same_attitude(att.quaternion_from_mrp(sigma), Rotation.from_mrp(sigma).as_quat(scalar_first=True))


@PROPERTY
@given(quaternion())
def test_mrp_round_trip(q: np.ndarray) -> None:
    sigma = att.mrp_from_quaternion(q)
    assert np.linalg.norm(sigma) <= 1.0 + 1e-15
    np.testing.assert_array_equal(att.mrp_from_quaternion(-q)[q[0] != 0.0], sigma[q[0] != 0.0])
    same_attitude(att.quaternion_from_mrp(sigma), q)


@PROPERTY
@given(unit_vector, st.floats(1e-6, 1e6))
def test_mrp_shadow_is_the_other_mrp_of_the_attitude(axis: np.ndarray, size: float) -> None:
    sigma = size * axis
    shadow = att.mrp_shadow(sigma)
    np.testing.assert_allclose(att.mrp_shadow(shadow), sigma, rtol=0.0, atol=1e-14 * size)
    assert np.linalg.norm(shadow) * size == pytest.approx(1.0, rel=1e-14)
    q = att.quaternion_from_mrp(sigma)
    assert np.linalg.norm(q) == pytest.approx(1.0, abs=1e-15)
    np.testing.assert_allclose(att.quaternion_from_mrp(shadow), -q, **TIGHT)
    np.testing.assert_allclose(q[1:], (1.0 + q[0]) * sigma, rtol=0.0, atol=4e-15 * max(1.0, size))


@pytest.mark.parametrize("zero", [0.0, -0.0, 1e-170])
def test_mrp_shadow_of_the_identity_is_an_error(zero: float) -> None:
    with pytest.raises(ValueError, match="non-zero"):
        att.mrp_shadow(np.array([[0.1, 0.2, 0.3], [zero, 0.0, 0.0]]))


@PROPERTY
@given(triple, st.floats(0.0, 50.0))
def test_mrp_switch_chooses_the_short_branch(direction: np.ndarray, size: float) -> None:
    sigma = size * direction
    switched = att.mrp_switch(sigma)
    assert np.linalg.norm(switched) <= 1.0 + 1e-15
    same_attitude(att.quaternion_from_mrp(switched), att.quaternion_from_mrp(sigma))
    if np.linalg.norm(sigma) <= 1.0 - 1e-15:
        np.testing.assert_array_equal(switched, sigma)


def test_mrp_switch_keeps_the_unit_sphere_and_zero() -> None:
    sigma = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 2.0, 0.0]])
    with np.errstate(all="raise"):
        np.testing.assert_array_equal(att.mrp_switch(sigma), [[1.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, -0.5, 0.0]])


def test_mrp_derivative_is_the_rate_of_a_body_fixed_turn() -> None:
    q, w = unit_quaternions(), vectors()
    sigma = att.mrp_from_quaternion(q)
    start = att.quaternion_from_mrp(sigma)  # q0 >= 0

    def turned(t: float) -> np.ndarray:
        moved = att.quaternion_product(start, att.quaternion_from_rotation_vector(w * t))
        return moved[..., 1:] / (1.0 + moved[..., :1])

    expected = central_difference(turned)
    np.testing.assert_allclose(att.mrp_derivative(sigma, w), expected, atol=1e-9)
    matrix_form = (att.mrp_kinematic_matrix(sigma) @ w[..., None])[..., 0]
    np.testing.assert_allclose(matrix_form, expected, atol=1e-9)


def test_mrp_kinematic_matrix_is_the_formula() -> None:
    for s in vectors(20):
        cross_matrix = np.array([[0.0, -s[2], s[1]], [s[2], 0.0, -s[0]], [-s[1], s[0], 0.0]])
        expected = ((1.0 - s @ s) * np.eye(3) + 2.0 * cross_matrix + 2.0 * np.outer(s, s)) / 4.0
        np.testing.assert_allclose(att.mrp_kinematic_matrix(s), expected, rtol=1e-14, atol=1e-14)


@PROPERTY
@given(triple, st.floats(0.0, 10.0), triple)
def test_mrp_kinematic_matrix_inverse(direction: np.ndarray, size: float, w: np.ndarray) -> None:
    sigma = size * direction
    matrix, inverse = att.mrp_kinematic_matrix(sigma), att.mrp_kinematic_matrix_inverse(sigma)
    np.testing.assert_allclose(inverse @ matrix, np.eye(3), rtol=0.0, atol=1e-14)
    np.testing.assert_allclose(matrix @ inverse, np.eye(3), rtol=0.0, atol=1e-14)
    np.testing.assert_allclose(att.angular_velocity_from_mrp(sigma, matrix @ w), w, rtol=0.0, atol=1e-14)
    np.testing.assert_allclose(att.mrp_derivative(sigma, w), matrix @ w, rtol=1e-13, atol=1e-13)


def test_mrp_kinematic_matrix_derivative_is_the_time_derivative() -> None:
    sigma, sigma_dot, curvature = vectors(seed=1), vectors(seed=2), vectors(seed=3)
    expected = central_difference(lambda t: att.mrp_kinematic_matrix(sigma + sigma_dot * t + curvature * t**2))
    np.testing.assert_allclose(att.mrp_kinematic_matrix_derivative(sigma, sigma_dot), expected, atol=1e-9)


def test_angular_acceleration_is_the_derivative_of_the_rate() -> None:
    sigma, sigma_dot, sigma_ddot, jerk = (vectors(seed=seed, scale=0.6) for seed in range(4))

    def rate(t: float) -> np.ndarray:
        position = sigma + sigma_dot * t + sigma_ddot * t**2 / 2.0 + jerk * t**3 / 6.0
        return att.angular_velocity_from_mrp(position, sigma_dot + sigma_ddot * t + jerk * t**2 / 2.0)

    actual = att.angular_acceleration_from_mrp(sigma, sigma_dot, sigma_ddot)
    np.testing.assert_allclose(actual, central_difference(rate), atol=1e-8)


def test_angular_acceleration_inverts_the_second_derivative_exactly() -> None:
    sigma, w, w_dot = vectors(seed=1), vectors(seed=2), vectors(seed=3)
    sigma_dot = att.mrp_derivative(sigma, w)
    matrix_dot = att.mrp_kinematic_matrix_derivative(sigma, sigma_dot)
    bent = (matrix_dot @ w[..., None])[..., 0]
    np.testing.assert_allclose(att.mrp_curvature(sigma, sigma_dot, w), bent, rtol=0.0, atol=1e-13)
    sigma_ddot = bent + att.mrp_derivative(sigma, w_dot)
    np.testing.assert_allclose(
        att.angular_acceleration_from_mrp(sigma, sigma_dot, sigma_ddot), w_dot, rtol=0.0, atol=2e-13
    )


@PROPERTY
@given(quaternion(), quaternion(), st.booleans(), st.booleans())
def test_mrp_error_is_the_mrp_of_the_quaternion_error(
    q: np.ndarray, reference: np.ndarray, shadow_q: bool, shadow_reference: bool
) -> None:
    def mrp(a: np.ndarray, shadow: bool) -> np.ndarray:
        sigma = att.mrp_from_quaternion(a)
        return att.mrp_shadow(sigma) if shadow and np.linalg.norm(sigma) > 1e-2 else sigma

    error = att.mrp_error(mrp(q, shadow_q), mrp(reference, shadow_reference))
    assert np.linalg.norm(error) <= 1.0 + 1e-14
    same_attitude(att.quaternion_from_mrp(error), att.quaternion_error(q, reference), atol=2e-12)


def test_mrp_error_special_cases() -> None:
    sigma = np.array([[0.1, -0.3, 0.2], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]])
    zero = np.zeros(3)
    np.testing.assert_allclose(att.mrp_error(sigma, sigma), np.zeros((3, 3)), **TIGHT)
    np.testing.assert_allclose(att.mrp_error(sigma, zero), sigma, **TIGHT)
    np.testing.assert_allclose(att.mrp_error(zero, sigma), -sigma, **TIGHT)
    # the textbook denominator vanishes between an MRP and its own shadow
    np.testing.assert_allclose(att.mrp_error(att.mrp_shadow(sigma[0]), sigma[0]), zero, **TIGHT)
