"""Tests of `ftac_gym.task.inertia`: every drawn inertia belongs to a body, and the parts mean what they say."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from ftac_gym.task import InertiaUncertainty
from ftac_gym.task.inertia import exact_inertia

NOMINAL = np.array([[10.0, 1.2, 0.5], [1.2, 19.0, 1.5], [0.5, 1.5, 25.0]])  # kg m^2
PROPERTY = settings(max_examples=80, deadline=None, derandomize=True)


def deviates(count=500, seed=0):
    return np.random.default_rng(seed).random((count, 6))


def mass_moment(inertia):
    """The second moment of mass, the integral of r r' dm, from the integral of |r|^2 I - r r'."""
    trace = np.trace(inertia, axis1=-2, axis2=-1)[..., None, None]
    return 0.5 * trace * np.eye(3) - inertia


@st.composite
def physical_inertia(draw):
    """Inertia of a cloud of mass with positive second moments along random axes."""
    moments = np.array([draw(st.floats(0.05, 10.0)) for _ in range(3)])
    axes = Rotation.random(rng=draw(st.integers(0, 10_000))).as_matrix()
    return axes @ np.diag(moments.sum() - moments) @ axes.T


@PROPERTY
@given(physical_inertia(), st.floats(0.0, 0.95), st.integers(0, 10_000))
def test_every_drawn_inertia_is_physical(nominal, relative, seed):
    uncertainty = InertiaUncertainty(relative=relative)
    drawn = uncertainty.draw(nominal, deviates(20, seed))["constant"]
    moments = np.linalg.eigvalsh(drawn)
    assert np.all(moments[:, 0] > 0.0)
    assert np.all(moments[:, 2] <= (moments[:, 0] + moments[:, 1]) * (1.0 + 1e-9))
    np.testing.assert_allclose(drawn, np.swapaxes(drawn, 1, 2), rtol=0.0, atol=1e-12 * moments.max())


def test_physical_at_the_corners_of_the_distribution():
    corners = np.stack(np.meshgrid(*[[0.0, 1.0 - 2.0**-53]] * 6), axis=-1).reshape(-1, 6)
    moments = np.linalg.eigvalsh(InertiaUncertainty(relative=0.95).draw(NOMINAL, corners)["constant"])
    assert np.all(moments[:, 0] > 0.0) and np.all(moments[:, 2] <= (moments[:, 0] + moments[:, 1]) * (1.0 + 1e-9))


def test_without_uncertainty_the_inertia_is_nominal():
    table = InertiaUncertainty().draw(NOMINAL, deviates(3))
    np.testing.assert_array_equal(table["constant"], np.stack([NOMINAL] * 3))
    np.testing.assert_array_equal(table, exact_inertia(NOMINAL, 3))


def test_relative_uncertainty_stretches_the_second_moments_of_mass():
    relative = 0.2
    uniform = deviates(4000)
    uniform[:, 3:] = 0.5  # no shear: on a diagonal inertia the stretches stand alone
    nominal = np.diag([10.0, 19.0, 25.0])
    drawn = mass_moment(InertiaUncertainty(relative=relative).draw(nominal, uniform)["constant"])
    ratio = np.diagonal(drawn, axis1=1, axis2=2) / np.diag(mass_moment(nominal))
    np.testing.assert_allclose(ratio, 1.0 + relative * (2.0 * uniform[:, :3] - 1.0), rtol=1e-12)
    assert ratio.min() < 0.81 and ratio.max() > 1.19


def test_every_entry_of_the_inertia_varies_and_is_centred():
    drawn = InertiaUncertainty(relative=0.1).draw(NOMINAL, deviates(4000))["constant"]
    spread = drawn.std(axis=0)
    assert np.all(spread > 0.02)
    np.testing.assert_allclose(drawn.mean(axis=0), NOMINAL, atol=0.1)


def test_more_uncertainty_spreads_more():
    spreads = [
        InertiaUncertainty(relative=relative).draw(NOMINAL, deviates())["constant"].std(axis=0)
        for relative in (0.05, 0.1, 0.3)
    ]
    assert np.all(spreads[0] < spreads[1]) and np.all(spreads[1] < spreads[2])


def test_offset_is_added():
    offset = ((1.0, 0.1, 0.2), (0.1, -2.0, 0.3), (0.2, 0.3, 3.0))
    drawn = InertiaUncertainty(relative=0.1, offset=offset).draw(NOMINAL, deviates())["constant"]
    without = InertiaUncertainty(relative=0.1).draw(NOMINAL, deviates())["constant"]
    np.testing.assert_allclose(drawn - without, np.broadcast_to(offset, drawn.shape), atol=1e-13)


def test_varying_part_is_recorded():
    part = {"amplitude": (1.0, 0.0, 2.0), "frequency": (0.1, 0.2, 0.3), "phase": (0.0, 1.0, -1.0)}
    table = InertiaUncertainty(**part).draw(NOMINAL, deviates(2))
    for name, values in part.items():
        np.testing.assert_array_equal(table[name], [values, values])


def test_number_of_deviates_is_enough():
    uncertainty = InertiaUncertainty(relative=0.1)
    uncertainty.draw(NOMINAL, np.full((2, uncertainty.uniform_count), 0.3))


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"relative": -0.1}, "relative must not be negative"),
        ({"relative": 1.0}, "relative must be below 1"),
        ({"relative": float("nan")}, "relative must be finite"),
        ({"offset": np.eye(2)}, "offset must be 3 x 3"),
        ({"offset": ((0, 1, 0), (0, 0, 0), (0, 0, 0))}, "offset must be symmetric"),
        ({"offset": np.full((3, 3), np.inf)}, "offset must be finite"),
        ({"amplitude": (1.0, 2.0)}, "amplitude must have 3 numbers"),
        ({"frequency": (1.0, 2.0, float("inf"))}, "frequency must be finite"),
        ({"phase": 1.0}, "phase must have 3 numbers"),
    ],
)
def test_rules(fields, message):
    with pytest.raises(ValueError, match=message):
        InertiaUncertainty(**fields)


@pytest.mark.parametrize("fields", [{"offset": -11.0 * np.eye(3)}, {"amplitude": (0.0, 0.0, 25.0)}])
def test_an_inertia_that_may_lose_positive_definiteness_is_refused(fields):
    with pytest.raises(ValueError, match="inertia_uncertainty must keep the inertia positive definite"):
        InertiaUncertainty(**fields).draw(NOMINAL, deviates(2))
