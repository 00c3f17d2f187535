"""Tests of `ftac_gym.task.initial_state`: distributions of attitude, rate and wheel momentum, and their rules."""

import math

import numpy as np
import pytest
from scipy import stats
from scipy.spatial.transform import Rotation

from ftac_gym.task import InitialState
from ftac_gym.utils.serialization import from_plain, to_plain

LIMITS = np.full(4, 12.0)
DEGREE = math.pi / 180.0


def draw(state, count=4000, limits=LIMITS, seed=0):
    wheels = len(limits)
    return state.draw(np.random.default_rng(seed).random((count, state.uniform_count(wheels))), limits)


def angles(attitude):
    return Rotation.from_quat(attitude, scalar_first=True).magnitude()


def assert_uniform_on_sphere(vectors):
    """Archimedes: each component of a uniform unit vector is uniform in [-1, 1]; all axes alike, none correlated."""
    unit = vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
    for column in unit.T:
        assert stats.kstest(column, "uniform", (-1.0, 2.0)).pvalue > 1e-3
    assert np.abs(np.corrcoef(unit.T) - np.eye(3)).max() < 0.08


# --------------------------------------------------------------------------------------------------------- attitude


def test_attitude_is_uniform_over_all_rotations_by_default():
    attitude = draw(InitialState())["attitude"]
    np.testing.assert_allclose(np.linalg.norm(attitude, axis=1), 1.0, atol=1e-14)
    # Haar measure: the angle has density (1 - cos) / pi, any rotated vector is uniform on the sphere.
    assert stats.kstest(angles(attitude), lambda angle: (angle - np.sin(angle)) / np.pi).pvalue > 1e-3
    assert_uniform_on_sphere(Rotation.from_quat(attitude, scalar_first=True).apply([1.0, 0.0, 0.0]))
    assert_uniform_on_sphere(Rotation.from_quat(attitude, scalar_first=True).apply([0.0, 0.0, 1.0]))


def test_angle_interval_bounds_the_distance_from_the_inertial_frame():
    attitude = draw(InitialState(angle=(20.0 * DEGREE, 60.0 * DEGREE)))["attitude"]
    assert stats.kstest(angles(attitude), "uniform", (20.0 * DEGREE, 40.0 * DEGREE)).pvalue > 1e-3
    assert_uniform_on_sphere(attitude[:, 1:])


@pytest.mark.parametrize("angle", [0.0, 1.0, math.pi])
def test_fixed_angle(angle):
    np.testing.assert_allclose(angles(draw(InitialState(angle=angle), 50)["attitude"]), angle, atol=1e-7)


def test_fixed_attitude_wins_and_is_normalised():
    attitude = draw(InitialState(attitude=(0.6, 0.8004, 0.0, 0.0), angle=1.0), 3)["attitude"]
    np.testing.assert_allclose(np.linalg.norm(attitude, axis=1), 1.0, atol=1e-15)
    np.testing.assert_allclose(attitude[:, 1] / attitude[:, 0], 0.8004 / 0.6)


# ------------------------------------------------------------------------------------------------------------- rate


def test_rate_has_uniform_magnitude_and_direction():
    rate = draw(InitialState(max_rate=0.02))["rate"]
    assert stats.kstest(np.linalg.norm(rate, axis=1), "uniform", (0.0, 0.02)).pvalue > 1e-3
    assert_uniform_on_sphere(rate)


def test_an_interval_bounds_the_magnitude_of_the_rate_on_both_sides():
    state = InitialState(max_rate=[0.01, 0.03])
    assert state == InitialState(max_rate=np.array([0.01, 0.03]))
    rate = draw(state)["rate"]
    assert stats.kstest(np.linalg.norm(rate, axis=1), "uniform", (0.01, 0.02)).pvalue > 1e-3
    assert_uniform_on_sphere(rate)
    assert state.largest_rate == 0.03 and from_plain(to_plain(state), "state", InitialState) == state
    np.testing.assert_array_equal(
        draw(InitialState(max_rate=(0.0, 0.02)))["rate"], draw(InitialState(max_rate=0.02))["rate"]
    )


def test_rate_does_not_depend_on_the_attitude():
    drawn = draw(InitialState(max_rate=0.02))
    assert np.abs(np.corrcoef(drawn["rate"].T, drawn["attitude"].T)[:3, 3:]).max() < 0.08


def test_fixed_rate():
    assert np.all(draw(InitialState(rate=(0.1, -0.2, 0.3), max_rate=5.0), 3)["rate"] == (0.1, -0.2, 0.3))
    assert np.all(draw(InitialState(), 3)["rate"] == 0.0)


# --------------------------------------------------------------------------------------------------- wheel momentum


def test_momentum_interval_holds_for_every_wheel_independently():
    momentum = draw(InitialState(wheel_momentum=(-1.0, 3.0)))["wheel_momentum"]
    assert momentum.shape == (4000, 4)
    for column in momentum.T:
        assert stats.kstest(column, "uniform", (-1.0, 4.0)).pvalue > 1e-3
    assert np.abs(np.corrcoef(momentum.T) - np.eye(4)).max() < 0.08


def test_fixed_momentum_for_all_or_per_wheel():
    assert np.all(draw(InitialState(wheel_momentum=2.0), 3)["wheel_momentum"] == 2.0)
    each = (1.0, -2.0, 3.0, -4.0)
    assert np.all(draw(InitialState(fixed_wheel_momentum=each), 3)["wheel_momentum"] == each)


def test_momentum_may_reach_its_limit_but_not_pass_it():
    draw(InitialState(wheel_momentum=12.0), 3)
    with pytest.raises(ValueError, match="wheel_momentum must stay within the limits"):
        draw(InitialState(wheel_momentum=12.1), 3)
    with pytest.raises(ValueError, match=r"^fixed_wheel_momentum must stay within the limits"):
        draw(InitialState(fixed_wheel_momentum=(1.0, 1.0, 1.0, -13.0)), 3)


def test_momentum_without_limits():
    assert np.all(draw(InitialState(wheel_momentum=1e6), 3, np.full(3, np.inf))["wheel_momentum"] == 1e6)


def test_number_of_momenta_must_be_that_of_the_wheels():
    with pytest.raises(ValueError, match="wheel_momentum must have 4 values"):
        draw(InitialState(fixed_wheel_momentum=(1.0, 2.0, 3.0)), 3)


# ------------------------------------------------------------------------------------------------------------ fixed


def test_fixed_start_has_nothing_random():
    state = InitialState.fixed(attitude=np.array([0.5, 0.5, 0.5, 0.5]), rate=[0.1, 0.2, 0.3], wheel_momentum=np.ones(4))
    drawn = draw(state, 5)
    assert np.all(drawn == drawn[0])
    np.testing.assert_array_equal(drawn["attitude"][0], [0.5] * 4)
    np.testing.assert_array_equal(drawn["rate"][0], [0.1, 0.2, 0.3])
    np.testing.assert_array_equal(drawn["wheel_momentum"][0], [1.0] * 4)


@pytest.mark.parametrize("wheels", [1, 2, 3, 4, 6])
def test_fixed_start_takes_one_momentum_per_wheel_for_any_number_of_wheels(wheels):
    momentum = np.linspace(-1.0, 1.0, wheels)
    drawn = draw(InitialState.fixed(wheel_momentum=momentum), 5, np.full(wheels, 12.0))
    np.testing.assert_array_equal(drawn["wheel_momentum"], np.tile(momentum, (5, 1)))


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"attitude": (1.0, 1.0, 0.0, 0.0)}, "attitude must be a unit quaternion"),
        ({"attitude": (0.0, 0.0, 0.0, 0.0)}, "attitude must be a unit quaternion"),
        ({"attitude": (1.0, 0.0, 0.0)}, "attitude must have 4 numbers"),
        ({"attitude": (1.0, 0.0, 0.0, math.nan)}, "attitude must be finite"),
        ({"angle": -0.1}, r"angle must stay within \[0, pi\]"),
        ({"angle": (0.0, 3.2)}, r"angle must stay within \[0, pi\]"),
        ({"angle": (1.0, 0.5)}, "angle must have low <= high"),
        ({"rate": (0.1, 0.2)}, "rate must have 3 numbers"),
        ({"rate": 0.1}, "rate must have 3 numbers"),
        ({"rate": (0.1, 0.2, math.inf)}, "rate must be finite"),
        ({"rate": ("fast", 0.0, 0.0)}, "rate must"),
        ({"max_rate": -0.1}, "max_rate must not be negative"),
        ({"max_rate": (0.2, 0.1)}, "max_rate must have low <= high"),
        ({"wheel_momentum": (2.0, 1.0)}, "wheel_momentum must have low <= high"),
        ({"fixed_wheel_momentum": (1.0, math.nan, 1.0)}, "fixed_wheel_momentum must be finite"),
        ({"wheel_momentum": "full"}, "wheel_momentum must be a number"),
    ],
)
def test_rules(fields, message):
    with pytest.raises(ValueError, match=message):
        InitialState(**fields)
