"""Tests of `ftac_gym.attitude` against SciPy rotations, finite differences, and algebraic properties."""

import inspect
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from ftac_gym import attitude as att

IDENTITY = np.array([1.0, 0.0, 0.0, 0.0])
COUNT = 200
PROPERTY = settings(max_examples=80, deadline=None, derandomize=True)
TIGHT = {"rtol": 0.0, "atol": 4e-15}


def unit_quaternions(count: int = COUNT, seed: int = 0) -> np.ndarray:
    """Return unit quaternions of both signs of q0, made without the code under test."""
    q = np.random.default_rng(seed).normal(size=(count, 4))
    return q / np.linalg.norm(q, axis=-1, keepdims=True)


def vectors(count: int = COUNT, seed: int = 100, scale: float = 1.0) -> np.ndarray:
    return scale * np.random.default_rng(seed).normal(size=(count, 3))


def scipy_rotation(q: np.ndarray) -> Rotation:
    """SciPy's rotation maps body components to inertial ones: its matrix is C(q)^T."""
    return Rotation.from_quat(q, scalar_first=True)


def same_attitude(a: np.ndarray, b: np.ndarray, atol: float = 4e-15) -> None:
    """Assert equality of unit quaternions up to sign."""
    sign = np.sign(np.sum(a * b, axis=-1, keepdims=True))
    np.testing.assert_allclose(a, sign * b, rtol=0.0, atol=atol)


def central_difference(f: Callable[[float], np.ndarray], step: float = 1e-3) -> np.ndarray:
    """Return f'(0) to fourth order."""
    return (8.0 * (f(step) - f(-step)) - (f(2.0 * step) - f(-2.0 * step))) / (12.0 * step)


coordinate = st.floats(-1.0, 1.0)
triple = st.tuples(coordinate, coordinate, coordinate).map(np.array)
unit_vector = triple.filter(lambda v: np.linalg.norm(v) > 1e-2).map(lambda v: v / np.linalg.norm(v))
# angles: ordinary ones, and ones within 1e-1 .. 1e-16 of 0 and of pi
closeness = st.floats(1.0, 16.0).map(lambda exponent: 10.0**-exponent)
angle = st.one_of(
    st.floats(0.0, np.pi), closeness, closeness.map(lambda distance: np.pi - distance), st.sampled_from([0.0, np.pi])
)


@st.composite
def quaternion(draw: st.DrawFn) -> np.ndarray:
    """Unit quaternion of either sign, with angles gathered near 0 and pi."""
    half, axis, sign = 0.5 * draw(angle), draw(unit_vector), draw(st.sampled_from([-1.0, 1.0]))
    return sign * np.concatenate(([np.cos(half)], np.sin(half) * axis))


# ------------------------------------------------------------------------------------------------ vectors, products


@pytest.mark.parametrize("count", [1, 7, 20000])
def test_cross_equals_numpy_for_small_and_large_batches(count: int) -> None:
    a, b = vectors(count, 1), vectors(count, 2)
    np.testing.assert_allclose(att.cross(a, b), np.cross(a, b), **TIGHT)
    np.testing.assert_allclose(att.cross(a[0], b), np.cross(a[0], b), **TIGHT)
    np.testing.assert_allclose(att.cross(a, b[0]), np.cross(a, b[0]), **TIGHT)
    np.testing.assert_allclose(att.cross(a[:, None], b[:2]), np.cross(a[:, None], b[:2]), **TIGHT)


def test_cross_does_not_depend_on_the_batch_size() -> None:
    a, b = vectors(20000, 1), vectors(20000, 2)
    np.testing.assert_array_equal(att.cross(a, b)[:50], att.cross(a[:50], b[:50]))


def test_skew_is_the_matrix_of_the_cross_product() -> None:
    a, b = vectors(seed=1), vectors(seed=2)
    matrix = att.skew(a)
    np.testing.assert_allclose((matrix @ b[..., None])[..., 0], np.cross(a, b), **TIGHT)
    np.testing.assert_array_equal(matrix, -np.swapaxes(matrix, -1, -2))


def test_product_obeys_the_hamilton_table() -> None:
    one, i, j, k = np.eye(4)
    for a, b, expected in [(i, j, k), (j, k, i), (k, i, j), (j, i, -k), (i, i, -one), (j, j, -one), (k, k, -one)]:
        np.testing.assert_array_equal(att.quaternion_product(a, b), expected)
    np.testing.assert_array_equal(att.quaternion_product(one, j), j)
    np.testing.assert_array_equal(att.quaternion_product(j, one), j)


def test_product_composes_like_scipy() -> None:
    a, b = unit_quaternions(seed=1), unit_quaternions(seed=2)
    same_attitude(att.quaternion_product(a, b), (scipy_rotation(a) * scipy_rotation(b)).as_quat(scalar_first=True))


def test_product_norm_is_the_product_of_norms() -> None:
    rng = np.random.default_rng(3)
    a, b = rng.normal(size=(COUNT, 4)), 3.0 * rng.normal(size=(COUNT, 4))
    norm = np.linalg.norm(att.quaternion_product(a, b), axis=-1)
    np.testing.assert_allclose(norm, np.linalg.norm(a, axis=-1) * np.linalg.norm(b, axis=-1), rtol=1e-14)


@PROPERTY
@given(quaternion(), quaternion())
def test_conjugate_is_the_inverse_and_reverses_products(a: np.ndarray, b: np.ndarray) -> None:
    np.testing.assert_allclose(att.quaternion_product(a, att.quaternion_conjugate(a)), IDENTITY, **TIGHT)
    left = att.quaternion_conjugate(att.quaternion_product(a, b))
    right = att.quaternion_product(att.quaternion_conjugate(b), att.quaternion_conjugate(a))
    np.testing.assert_allclose(left, right, **TIGHT)


# ------------------------------------------------------------------------------------------- normalisation and sign


@pytest.mark.parametrize("magnitude", [5e-324, 1e-300, 1e-150, 1e-8, 1.0, 1e8, 1e160, 1.7e308])
def test_normalize_keeps_the_direction_at_any_magnitude(magnitude: float) -> None:
    q = magnitude * np.array([[-1.0, 1.0, -1.0, 1.0], [0.0, 0.0, 1.0, 0.0]])
    expected = [[-0.5, 0.5, -0.5, 0.5], [0.0, 0.0, 1.0, 0.0]]
    np.testing.assert_allclose(att.quaternion_normalize(q), expected, **TIGHT)
    np.testing.assert_allclose(att.quaternion_normalize(q[:, None])[:, 0], expected, **TIGHT)
    np.testing.assert_allclose(att.quaternion_normalize(q[0]), expected[0], **TIGHT)


@pytest.mark.parametrize(
    ("bad", "rule"), [(0.0, "non-zero"), (np.nan, "must be finite"), (np.inf, "must be finite"), (-np.inf, "finite")]
)
def test_normalize_rejects_zero_and_non_finite(bad: float, rule: str) -> None:
    q = np.tile(IDENTITY, (3, 1))
    q[1, 0] = bad
    with pytest.raises(ValueError, match=rule):
        att.quaternion_normalize(q)


def test_canonical_chooses_the_sign_of_the_scalar_part() -> None:
    q = unit_quaternions()
    assert (q[:, 0] < 0.0).any() and (q[:, 0] > 0.0).any()
    c = att.canonical(q)
    assert (c[:, 0] >= 0.0).all()
    np.testing.assert_array_equal(c, np.where(q[:, :1] < 0.0, -q, q))
    np.testing.assert_array_equal(att.canonical(-q), c)
    pure = np.array([0.0, -1.0, 0.0, 0.0])
    np.testing.assert_array_equal(att.canonical(pure), pure)


# --------------------------------------------------------------------------------------- rotations, frame direction


def test_rotation_direction_of_a_quarter_turn() -> None:
    # body turned +90 deg about z: the inertial x axis is seen along body -y, and body x lies along inertial y
    q = np.array([np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)])
    x, y = np.eye(3)[:2]
    np.testing.assert_allclose(att.rotate_to_body(q, x), -y, **TIGHT)
    np.testing.assert_allclose(att.rotate_to_reference(q, x), y, **TIGHT)
    np.testing.assert_allclose(att.rotation_matrix(q) @ x, -y, **TIGHT)


def test_rotations_match_scipy() -> None:
    q, v = unit_quaternions(), vectors()
    rotation = scipy_rotation(q)
    np.testing.assert_allclose(att.rotation_matrix(q), rotation.inv().as_matrix(), **TIGHT)
    np.testing.assert_allclose(att.rotate_to_reference(q, v), rotation.apply(v), **TIGHT)
    np.testing.assert_allclose(att.rotate_to_body(q, v), rotation.apply(v, inverse=True), **TIGHT)


@PROPERTY
@given(quaternion(), quaternion(), triple)
def test_rotation_properties(a: np.ndarray, b: np.ndarray, v: np.ndarray) -> None:
    matrix = att.rotation_matrix(a)
    np.testing.assert_allclose(matrix @ matrix.T, np.eye(3), **TIGHT)
    assert np.linalg.det(matrix) == pytest.approx(1.0, abs=1e-14)
    np.testing.assert_allclose(att.rotate_to_body(a, v), matrix @ v, **TIGHT)
    np.testing.assert_allclose(att.rotate_to_reference(a, v), matrix.T @ v, **TIGHT)
    # C(a (x) b) = C(b) C(a): first to the axes of a, then on to those of b
    product = att.rotation_matrix(att.quaternion_product(a, b))
    np.testing.assert_allclose(product, att.rotation_matrix(b) @ matrix, **TIGHT)


@PROPERTY
@given(quaternion())
def test_rotation_matrix_round_trip(q: np.ndarray) -> None:
    back = att.quaternion_from_rotation_matrix(att.rotation_matrix(q))
    assert back[0] >= 0.0
    assert np.linalg.norm(back) == pytest.approx(1.0, abs=1e-15)
    same_attitude(back, q)


def test_quaternion_from_rotation_matrix_uses_every_pivot() -> None:
    axes = np.concatenate((np.eye(4), unit_quaternions(), [[0.0, 0.6, -0.8, 0.0], [0.5, 0.5, -0.5, 0.5]]))
    pivots = set(np.argmax(np.abs(axes), axis=-1))
    assert pivots == {0, 1, 2, 3}
    back = att.quaternion_from_rotation_matrix(scipy_rotation(axes).inv().as_matrix())
    same_attitude(back, axes)


def test_quaternion_from_rotation_matrix_rejects_non_finite() -> None:
    matrix = np.tile(np.eye(3), (2, 1, 1))
    matrix[1, 2, 0] = np.nan
    with pytest.raises(ValueError, match="finite"):
        att.quaternion_from_rotation_matrix(matrix)


def test_quaternion_error_is_relative_to_the_reference() -> None:
    q, reference = unit_quaternions(seed=1), unit_quaternions(seed=2)
    error = att.quaternion_error(q, reference)
    assert (error[:, 0] >= 0.0).all()
    expected = scipy_rotation(reference).inv() * scipy_rotation(q)
    same_attitude(error, expected.as_quat(scalar_first=True))
    # C(q_e) = C(q) C(q_d)^T maps reference-frame components to body components
    chain = att.rotation_matrix(q) @ np.swapaxes(att.rotation_matrix(reference), -1, -2)
    np.testing.assert_allclose(att.rotation_matrix(error), chain, **TIGHT)


# ------------------------------------------------------------------------------------------------------- kinematics


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


# -------------------------------------------------------------------------------------- rotation vectors and angles


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


# -------------------------------------------------------------------------------------------------------------- MRP


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


# -------------------------------------------------------------------------------------------------- random attitudes


def test_random_quaternions_are_uniform_over_rotations() -> None:
    count = 200_000
    q = att.random_quaternion_from_uniforms(np.random.default_rng(5).random((count, 3)))
    np.testing.assert_allclose(np.linalg.norm(q, axis=-1), 1.0, rtol=0.0, atol=1e-15)
    assert (q[:, 0] >= 0.0).all()
    # zero mean, and second moments E[C_ij^2] = 1/3, for the Haar measure; tolerances are six standard errors
    matrix = att.rotation_matrix(q)
    np.testing.assert_allclose(matrix.mean(axis=0), np.zeros((3, 3)), atol=6.0 * np.sqrt(1.0 / 3.0 / count))
    np.testing.assert_allclose((matrix**2).mean(axis=0), np.full((3, 3), 1.0 / 3.0), atol=6.0 * 0.3 / np.sqrt(count))
    # the angle has the density (1 - cos(angle)) / pi
    size = np.sort(att.angle_between(q, IDENTITY))
    distribution = (size - np.sin(size)) / np.pi
    assert np.abs(distribution - (np.arange(count) + 0.5) / count).max() < 2.0 / np.sqrt(count)


@pytest.mark.parametrize("bad", [1.0, -1e-9, np.nan])
def test_random_quaternion_rejects_what_is_not_a_uniform(bad: float) -> None:
    with pytest.raises(ValueError, match=r"\[0, 1\)"):
        att.random_quaternion_from_uniforms(np.array([0.5, bad, 0.5]))


def test_random_quaternion_covers_the_ends_of_the_uniforms() -> None:
    last = np.nextafter(1.0, 0.0)
    u = np.array([[0.0, 0.0, 0.0], [last, last, last], [0.0, last, 0.5]])
    np.testing.assert_allclose(np.linalg.norm(att.random_quaternion_from_uniforms(u), axis=-1), 1.0, atol=1e-15)


# ------------------------------------------------------------------------------------------ every function: batching

SHAPES = {
    "cross": (3, 3),
    "skew": (3,),
    "quaternion_product": (4, 4),
    "quaternion_conjugate": (4,),
    "quaternion_normalize": (4,),
    "canonical": (4,),
    "quaternion_error": (4, 4),
    "rotate_to_body": (4, 3),
    "rotate_to_reference": (4, 3),
    "rotation_matrix": (4,),
    "quaternion_from_rotation_matrix": (9,),
    "quaternion_derivative": (4, 3),
    "quaternion_from_rotation_vector": (3,),
    "rotation_vector_from_quaternion": (4,),
    "angle_between": (4, 4),
    "mrp_from_quaternion": (4,),
    "quaternion_from_mrp": (3,),
    "mrp_shadow": (3,),
    "mrp_switch": (3,),
    "mrp_kinematic_matrix": (3,),
    "mrp_kinematic_matrix_inverse": (3,),
    "mrp_kinematic_matrix_derivative": (3, 3),
    "mrp_derivative": (3, 3),
    "mrp_curvature": (3, 3, 3),
    "angular_velocity_from_mrp": (3, 3),
    "angular_acceleration_from_mrp": (3, 3, 3),
    "mrp_error": (3, 3),
    "random_quaternion_from_uniforms": (3,),
}


def make_argument(name: str, size: int, lead: tuple[int, ...], seed: int) -> np.ndarray:
    count = int(np.prod(lead))
    if size == 4:
        return unit_quaternions(count, seed).reshape(*lead, 4)
    if size == 9:
        return scipy_rotation(unit_quaternions(count, seed)).as_matrix().reshape(*lead, 3, 3)
    if name == "random_quaternion_from_uniforms":
        return np.random.default_rng(seed).random((*lead, 3))
    return vectors(count, seed).reshape(*lead, 3)


def test_every_public_function_is_in_the_batching_table() -> None:
    public = {n for n, f in inspect.getmembers(att, inspect.isfunction) if not n.startswith("_")}
    assert public == set(SHAPES)


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize(
    "leads", [((5,), (5,), (5,)), ((2, 1, 3), (4, 1), (1,)), ((3,), (2, 3), ()), ((), (4,), (2, 4))]
)
def test_broadcasting_equals_a_loop_and_leaves_the_arguments_alone(name: str, leads: tuple[tuple[int, ...]]) -> None:
    function, sizes = getattr(att, name), SHAPES[name]
    leads = leads[: len(sizes)]
    arguments = [
        make_argument(name, size, lead, seed) for seed, (size, lead) in enumerate(zip(sizes, leads, strict=True))
    ]
    copies = [argument.copy() for argument in arguments]
    result = np.asarray(function(*arguments))
    for argument, copy in zip(arguments, copies, strict=True):
        np.testing.assert_array_equal(argument, copy)
        assert not np.shares_memory(result, argument)
    lead = np.broadcast_shapes(*leads)
    core = [2 if size == 9 else 1 for size in sizes]
    wide = [
        np.broadcast_to(argument, lead + argument.shape[argument.ndim - rank :])
        for argument, rank in zip(arguments, core, strict=True)
    ]
    for index in np.ndindex(*lead):
        single = np.asarray(function(*(argument[index] for argument in wide)))
        assert single.dtype == result.dtype == np.float64
        assert single.shape == result.shape[len(lead) :]
        np.testing.assert_allclose(result[index], single, rtol=1e-14, atol=1e-15)
    assert result.shape[: len(lead)] == lead


@pytest.mark.parametrize("name", SHAPES)
def test_an_empty_batch_gives_an_empty_batch(name: str) -> None:
    arguments = [make_argument(name, size, (0,), 0) for size in SHAPES[name] if size != 9] or [np.empty((0, 3, 3))]
    assert getattr(att, name)(*arguments).shape[0] == 0
