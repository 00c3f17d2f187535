"""Allocation to wheels of estimated effectiveness."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from ftac_gym.baselines.components.allocation import EffectivenessAllocation
from ftac_gym.spacecraft.layouts import orthogonal_and_skew

INERTIA = np.array([[30.0, 5.3, 6.4], [5.3, 27.0, 10.0], [6.4, 10.0, 19.0]])  # kg m^2
SEEDS, POWER, SMALLEST = st.integers(0, 2**32 - 1), st.floats(0.0, 3.0), st.floats(0.02, 0.5)


def layout(seed, count):
    """Random axes that span space well, a generator, and torques (5, 3)."""
    random = np.random.default_rng(seed)
    axes = random.normal(size=(3, count))
    axes /= np.linalg.norm(axes, axis=0)
    assume(np.linalg.svd(axes, compute_uv=False)[2] > 0.1)
    return axes, random, random.normal(size=(5, 3))


@settings(max_examples=60, deadline=None)
@given(seed=SEEDS, count=st.integers(3, 6), power=POWER, smallest=SMALLEST)
def test_the_body_gets_the_torque_that_was_asked_for(seed, count, power, smallest):
    axes, random, torque = layout(seed, count)
    effectiveness = random.uniform(smallest, 1.0, (5, count))
    command = EffectivenessAllocation(axes, power, smallest)(torque, effectiveness)
    np.testing.assert_allclose((effectiveness * command) @ axes.T, torque, rtol=1e-8, atol=1e-8)


@settings(max_examples=40, deadline=None)
@given(seed=SEEDS, count=st.integers(3, 6))
def test_power_one_is_the_pseudo_inverse(seed, count):
    axes, random, torque = layout(seed, count)
    effectiveness = random.uniform(0.05, 1.0, (5, count))
    command = EffectivenessAllocation(axes, 1.0)(torque, effectiveness)
    for row in range(5):
        expected = np.linalg.pinv(axes @ np.diag(effectiveness[row])) @ torque[row]
        np.testing.assert_allclose(command[row], expected, rtol=1e-8, atol=1e-8)


@settings(max_examples=40, deadline=None)
@given(seed=SEEDS)
def test_power_two_is_the_allocation_of_zhang_and_zhou(seed):
    axes, random = np.array(orthogonal_and_skew()), np.random.default_rng(seed)
    torque, effectiveness = random.normal(size=(5, 3)), random.uniform(0.05, 1.0, (5, 4))
    command = EffectivenessAllocation(axes, 2.0)(torque, effectiveness)
    inverse = np.linalg.inv(INERTIA)
    for row in range(5):
        weak = np.diag(effectiveness[row])
        matrix = inverse @ axes @ weak @ weak @ weak @ axes.T
        expected = weak @ weak @ axes.T @ np.linalg.inv(matrix) @ inverse @ torque[row]
        np.testing.assert_allclose(command[row], expected, rtol=1e-8, atol=1e-8)


@settings(max_examples=30, deadline=None)
@given(seed=SEEDS, count=st.integers(3, 6), power=POWER)
def test_healthy_wheels_get_the_least_squares(seed, count, power):
    axes, _, torque = layout(seed, count)
    allocation = EffectivenessAllocation(axes, power)
    expected = torque @ np.linalg.pinv(axes).T
    np.testing.assert_allclose(allocation(torque, None), expected, rtol=1e-8, atol=1e-9)
    np.testing.assert_allclose(allocation(torque, np.ones((5, count))), expected, rtol=1e-8, atol=1e-8)


def test_weak_wheels_are_spared_the_more_the_higher_the_power():
    axes, torque = np.array(orthogonal_and_skew()), np.array([[0.0, 0.0, 1.0]])
    weak = np.array([[1.0, 1.0, 0.3, 1.0]])
    commands = [abs(EffectivenessAllocation(axes, power)(torque, weak)[0, 2]) for power in (0.0, 1.0, 2.0, 4.0)]
    assert commands == sorted(commands, reverse=True)


@settings(max_examples=40, deadline=None)
@given(seed=SEEDS, power=POWER, dead=st.integers(1, 4))
def test_dead_wheels_never_make_it_singular(seed, power, dead):
    axes, random = np.array(orthogonal_and_skew()), np.random.default_rng(seed)
    torque, effectiveness = random.normal(size=(5, 3)), np.ones((5, 4))
    effectiveness[:, random.permutation(4)[:dead]] = 0.0
    command = EffectivenessAllocation(axes, power)(torque, effectiveness)
    assert np.isfinite(command).all()
    # What the wheels would give if the dead ones were as good as they are counted.
    np.testing.assert_allclose((np.maximum(effectiveness, 0.05) * command) @ axes.T, torque, rtol=1e-7, atol=1e-7)


@pytest.mark.parametrize(
    ("axes", "changes", "message"),
    [
        (np.eye(3)[:, :2], {}, "axes must span three dimensions"),
        (np.eye(3), {"power": -1.0}, "power must not be negative, got -1.0"),
        (np.eye(3), {"smallest": 0.0}, r"smallest must lie within \(0, 1\], got 0.0"),
        (np.eye(3), {"smallest": 1.1}, r"smallest must lie within \(0, 1\], got 1.1"),
    ],
)
def test_bad_parameters(axes, changes, message):
    with pytest.raises(ValueError, match=message):
        EffectivenessAllocation(axes, **{"power": 1.0, **changes})
