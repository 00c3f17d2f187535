"""Random attitudes, and every public function over batches."""

import inspect

import numpy as np
import pytest
from helpers.rotations import IDENTITY, scipy_rotation, unit_quaternions, vectors

from ftac_gym import attitude as att


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
