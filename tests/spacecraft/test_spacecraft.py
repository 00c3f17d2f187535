"""Tests of `spacecraft`: geometry of the wheel array, limits, and the rules for inertia and wheels."""

import dataclasses
import math

import numpy as np
import pytest

from ftac_gym.spacecraft import Spacecraft, WheelArray

IDENTITY = np.eye(3)
INERTIA = ((10.0, 1.2, 0.5), (1.2, 19.0, 1.5), (0.5, 1.5, 25.0))


def orthogonal(**changes):
    return WheelArray(**{"axes": IDENTITY, "torque_limit": 0.5, **changes})


# ----------------------------------------------------------------------------------------------------------- wheels


def test_sign_pyramid_has_unit_axes_spread_evenly():
    axes = WheelArray.sign_pyramid(0.2, 12.0).axis_matrix
    assert axes.shape == (3, 4)
    np.testing.assert_allclose(np.linalg.norm(axes, axis=0), 1.0, rtol=1e-15)
    np.testing.assert_allclose(axes @ axes.T, 4.0 / 3.0 * IDENTITY, atol=1e-15)
    np.testing.assert_allclose(axes[2], 1.0 / math.sqrt(3.0))
    assert len({tuple(signs) for signs in np.sign(axes[:2]).T}) == 4


@pytest.mark.parametrize("lost", range(4))
def test_sign_pyramid_spans_space_without_any_one_wheel(lost):
    remaining = np.delete(WheelArray.sign_pyramid(0.2, 12.0).axis_matrix, lost, axis=1)
    assert np.linalg.svd(remaining, compute_uv=False)[-1] > 0.5


def test_one_limit_holds_for_all_wheels():
    wheels = WheelArray.sign_pyramid(0.2, 12.0)
    np.testing.assert_array_equal(wheels.torque_limits, [0.2] * 4)
    np.testing.assert_array_equal(wheels.momentum_limits, [12.0] * 4)
    assert wheels.count == 4 and wheels.momentum_coupling


def test_limits_per_wheel():
    wheels = orthogonal(torque_limit=[0.1, 0.2, 0.3], momentum_limit=np.array([1.0, 2.0, 3.0]))
    np.testing.assert_array_equal(wheels.torque_limits, [0.1, 0.2, 0.3])
    np.testing.assert_array_equal(wheels.momentum_limits, [1.0, 2.0, 3.0])


def test_no_limit_is_infinite():
    wheels = orthogonal(torque_limit=None)
    assert np.all(np.isposinf(wheels.torque_limits)) and np.all(np.isposinf(wheels.momentum_limits))


def test_arrays_and_tuples_make_equal_wheels():
    assert orthogonal() == orthogonal(axes=((1, 0, 0), (0, 1, 0), (0, 0, 1)), torque_limit=(0.5, 0.5, 0.5))
    assert hash(orthogonal()) == hash(orthogonal(torque_limit=[0.5] * 3))
    assert orthogonal() != orthogonal(torque_limit=0.4)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"axes": np.eye(4)}, "axes must be 3 x m"),
        ({"axes": np.zeros((3, 0))}, "axes must be 3 x m"),
        ({"axes": (1.0, 0.0, 0.0)}, "axes must be 3 x m"),
        ({"axes": 2.0 * IDENTITY}, "axes must have columns of unit length"),
        ({"axes": IDENTITY * np.array([1.0, np.nan, 1.0])}, "axes must be finite"),
        ({"axes": np.diag([1.0, 1.0, np.inf])}, "axes must be finite"),
        ({"torque_limit": 0.0}, r"torque_limit\[0\] must be positive"),
        ({"torque_limit": (0.1, -0.2, 0.1)}, r"torque_limit\[1\] must be positive"),
        ({"torque_limit": (0.1, 0.2)}, "torque_limit must have 3 numbers"),
        ({"torque_limit": math.nan}, "torque_limit must be finite"),
        ({"torque_limit": math.inf}, "torque_limit must be finite"),
        ({"momentum_limit": 0}, r"momentum_limit\[0\] must be positive"),
        ({"momentum_limit": (1.0, 1.0, -1.0)}, r"momentum_limit\[2\] must be positive"),
        ({"momentum_limit": (1.0,) * 4}, "momentum_limit must have 3 numbers"),
    ],
)
def test_wheel_rules(changes, message):
    with pytest.raises(ValueError, match=message):
        orthogonal(**changes)


# ------------------------------------------------------------------------------------------------------- spacecraft


def test_inertia_is_kept_exactly():
    np.testing.assert_array_equal(Spacecraft(INERTIA, orthogonal()).inertia_matrix, INERTIA)
    assert Spacecraft(INERTIA, orthogonal()) == Spacecraft(np.array(INERTIA), orthogonal())


@pytest.mark.parametrize(
    ("inertia", "message"),
    [
        (np.eye(2), "inertia must be 3 x 3"),
        ((1.0, 2.0, 3.0), "inertia must be 3 x 3"),
        (np.diag([1.0, 1.0, np.nan]), "inertia must be finite"),
        (((2.0, 0.1, 0.0), (0.2, 2.0, 0.0), (0.0, 0.0, 2.0)), "inertia must be symmetric"),
        (np.diag([1.0, 1.0, 0.0]), "inertia must be positive definite"),
        (np.diag([1.0, 1.0, -1.0]), "inertia must be positive definite"),
        (((1.0, 2.0, 0.0), (2.0, 1.0, 0.0), (0.0, 0.0, 1.0)), "inertia must be positive definite"),
        (np.diag([1.0, 1.0, 2.01]), "inertia must satisfy the triangle inequality"),
    ],
)
def test_inertia_rules(inertia, message):
    with pytest.raises(ValueError, match=message):
        Spacecraft(inertia, orthogonal())


def test_triangle_inequality_looks_at_the_principal_moments():
    # The diagonal alone would pass: 1.2 < 1.2 + 0.4. The principal moments are 0.3, 0.4 and 2.1.
    tilted = ((1.2, 0.0, 0.9), (0.0, 0.4, 0.0), (0.9, 0.0, 1.2))
    with pytest.raises(ValueError, match="triangle inequality"):
        Spacecraft(tilted, orthogonal())


def test_a_plane_body_is_physical():
    assert Spacecraft(np.diag([1.0, 2.0, 3.0]), orthogonal()).inertia_matrix[2, 2] == 3.0


def test_unphysical_inertia_can_be_allowed_but_must_stay_positive():
    assert Spacecraft(np.diag([1.0, 1.0, 5.0]), orthogonal(), allow_unphysical_inertia=True).allow_unphysical_inertia
    with pytest.raises(ValueError, match="positive definite"):
        Spacecraft(np.diag([1.0, 1.0, -5.0]), orthogonal(), allow_unphysical_inertia=True)


def test_parameters_cannot_be_changed():
    spacecraft = Spacecraft(INERTIA, orthogonal())
    with pytest.raises(dataclasses.FrozenInstanceError):
        spacecraft.inertia = IDENTITY
    spacecraft.inertia_matrix[0, 0] = 99.0
    assert spacecraft.inertia_matrix[0, 0] == 10.0
    with pytest.raises(dataclasses.FrozenInstanceError):
        spacecraft.wheels.torque_limit = 1.0


def test_wheels_must_be_a_wheel_array():
    with pytest.raises(ValueError, match="wheels must be a WheelArray"):
        Spacecraft(INERTIA, None)
