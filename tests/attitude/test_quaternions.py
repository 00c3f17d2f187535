"""Quaternions: products, normalisation and rotations, against SciPy and algebraic properties."""

import numpy as np
import pytest
from helpers.rotations import (
    COUNT,
    IDENTITY,
    PROPERTY,
    TIGHT,
    quaternion,
    same_attitude,
    scipy_rotation,
    triple,
    unit_quaternions,
    vectors,
)
from hypothesis import given

from ftac_gym import attitude as att


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


def test_product_follows_the_hamilton_table() -> None:
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
