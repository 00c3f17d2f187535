"""Random rotations, strategies for them, and comparisons that do without the code under test."""

from collections.abc import Callable

import numpy as np
from hypothesis import settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

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
