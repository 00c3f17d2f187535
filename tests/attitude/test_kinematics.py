"""Kinematics, rotation vectors and angles, against SciPy and finite differences."""

import numpy as np
import pytest
from helpers.rotations import (
    COUNT,
    IDENTITY,
    PROPERTY,
    TIGHT,
    angle,
    central_difference,
    quaternion,
    same_attitude,
    scipy_rotation,
    unit_quaternions,
    unit_vector,
    vectors,
)
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from ftac_gym import attitude as att


def test_quaternion_derivative_is_half_the_product_with_the_rate() -> None:
    q, w = unit_quaternions(), vectors()
    pure = np.concatenate((np.zeros((COUNT, 1)), w), axis=-1)
    np.testing.assert_allclose(att.quaternion_derivative(q, w), 0.5 * att.quaternion_product(q, pure), **TIGHT)


def test_quaternion_derivative_is_the_rate_of_a_body_fixed_turn() -> None:
    q, w = unit_quaternions(), vectors()

    def turned(t: float) -> np.ndarray:
        turned_rotation = scipy_rotation(q) * Rotation.from_rotvec(w * t)
        sample = turned_rotation.as_quat(scalar_first=True)
        return sample * np.sign(np.sum(sample * q, axis=-1, keepdims=True))

    np.testing.assert_allclose(att.quaternion_derivative(q, w), central_difference(turned), atol=1e-10)


def test_integrated_kinematics_follow_the_rotation_vector() -> None:
    w = np.array([0.7, -1.1, 0.4])
    start = unit_quaternions(1)[0]
    solution = solve_ivp(lambda _, q: att.quaternion_derivative(q, w), (0.0, 5.0), start, rtol=1e-11, atol=1e-12)
    final = solution.y[:, -1]
    assert np.linalg.norm(final) == pytest.approx(1.0, abs=1e-9)
    expected = att.quaternion_product(start, att.quaternion_from_rotation_vector(5.0 * w))
    np.testing.assert_allclose(final, expected, atol=1e-9)


def test_integrated_mrp_and_quaternion_agree_for_a_varying_rate() -> None:
    def rate(t: float) -> np.ndarray:
        return np.array([0.3 * np.cos(t), -0.2 * np.sin(2.0 * t), 0.25])

    sigma = np.array([0.1, -0.2, 0.05])
    options = {"rtol": 1e-11, "atol": 1e-12}
    q_end = solve_ivp(
        lambda t, q: att.quaternion_derivative(q, rate(t)), (0.0, 4.0), att.quaternion_from_mrp(sigma), **options
    ).y[:, -1]
    sigma_end = solve_ivp(lambda t, s: att.mrp_derivative(s, rate(t)), (0.0, 4.0), sigma, **options).y[:, -1]
    np.testing.assert_allclose(att.mrp_switch(sigma_end), att.mrp_from_quaternion(q_end), atol=1e-9)


def test_error_kinematics_use_the_reference_rate_in_body_axes() -> None:
    q, reference = unit_quaternions(seed=1), unit_quaternions(seed=2)
    w, reference_rate = vectors(seed=3), vectors(seed=4)

    def error(t: float) -> np.ndarray:
        body = att.quaternion_product(q, att.quaternion_from_rotation_vector(w * t))
        target = att.quaternion_product(reference, att.quaternion_from_rotation_vector(reference_rate * t))
        return att.quaternion_product(att.quaternion_conjugate(target), body)

    relative_rate = w - att.rotate_to_body(error(0.0), reference_rate)
    expected = att.quaternion_derivative(error(0.0), relative_rate)
    np.testing.assert_allclose(central_difference(error), expected, atol=1e-9)


def test_rotation_vectors_match_scipy() -> None:
    phi = vectors(scale=1.5)
    q = att.quaternion_from_rotation_vector(phi)
    same_attitude(q, Rotation.from_rotvec(phi).as_quat(scalar_first=True))
    np.testing.assert_allclose(
        att.rotation_vector_from_quaternion(unit_quaternions()),
        scipy_rotation(unit_quaternions()).as_rotvec(),
        rtol=0.0,
        atol=2e-14,
    )


@PROPERTY
@given(unit_vector, angle)
def test_rotation_vector_round_trip(axis: np.ndarray, size: float) -> None:
    phi = size * axis
    q = att.quaternion_from_rotation_vector(phi)
    assert np.linalg.norm(q) == pytest.approx(1.0, abs=1e-15)
    back = att.rotation_vector_from_quaternion(q)
    assert np.linalg.norm(back) <= np.pi * (1.0 + 1e-15)
    if size > np.pi - 1e-14:  # phi and -phi are the same attitude within rounding
        back = np.where(back @ phi < 0.0, -back, back)
    np.testing.assert_allclose(back, phi, rtol=1e-15, atol=2e-15 * size)


@pytest.mark.parametrize("size", [0.0, 1e-300, 1e-160, 1e-100, 1e-30, 1e-17, 1e-12, 1e-8, 1e-4])
def test_tiny_rotation_vectors_are_exact(size: float) -> None:
    phi = size * np.array([0.6, -0.8, 0.0])
    q = att.quaternion_from_rotation_vector(phi)
    assert q[0] == np.cos(0.5 * size)
    np.testing.assert_allclose(q[1:], 0.5 * phi * (1.0 - size**2 / 24.0), rtol=1e-15, atol=0.0)
    np.testing.assert_allclose(att.rotation_vector_from_quaternion(q), phi, rtol=1e-15, atol=0.0)


@pytest.mark.parametrize("distance", [0.0, 1e-15, 1e-12, 1e-8, 1e-4])
def test_rotation_vectors_near_pi(distance: float) -> None:
    axis = np.array([0.6, 0.0, -0.8])
    short = np.concatenate(([np.sin(0.5 * distance)], np.cos(0.5 * distance) * axis))
    np.testing.assert_allclose(att.rotation_vector_from_quaternion(short), (np.pi - distance) * axis, **TIGHT)
    if distance > 0.0:  # on the other side of pi the short way turns about the opposite axis
        beyond = np.concatenate(([-short[0]], short[1:]))
        np.testing.assert_allclose(att.rotation_vector_from_quaternion(beyond), (distance - np.pi) * axis, **TIGHT)


@PROPERTY
@given(quaternion(), unit_vector, angle, st.sampled_from([-1.0, 1.0]))
def test_angle_between_is_the_turn_from_one_to_the_other(
    a: np.ndarray, axis: np.ndarray, size: float, sign: float
) -> None:
    b = sign * att.quaternion_product(a, att.quaternion_from_rotation_vector(size * axis))
    assert att.angle_between(a, b) == pytest.approx(size, rel=0.0, abs=4e-15)
    assert att.angle_between(b, a) == pytest.approx(size, rel=0.0, abs=4e-15)
    assert att.angle_between(a, sign * a) <= 4e-16


def test_angle_between_keeps_relative_accuracy_near_zero() -> None:
    small = att.quaternion_from_rotation_vector(np.array([0.0, 1e-20, 0.0]))
    assert att.angle_between(IDENTITY, small) == pytest.approx(1e-20, rel=1e-14, abs=0.0)
