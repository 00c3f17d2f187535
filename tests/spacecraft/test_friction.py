"""Tests of `friction`: closed forms, signs, limits, the compiled twin, and the rules for its parameters."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import njit

from ftac_gym.dynamics import stiff_wheel as kernel
from ftac_gym.dynamics.wheel_table import wheel_table
from ftac_gym.spacecraft import Friction, WheelArray

STRIBECK = Friction(coulomb=5e-4, breakaway=8e-4, breakaway_speed=0.1, viscous=2e-6)
SPEEDS = np.concatenate([[0.0], np.logspace(-12, 6, 400)])  # rad/s


@st.composite
def frictions(draw):
    sizes = st.just(0.0) | st.floats(-9.0, 1.0).map(lambda exponent: 10.0**exponent)
    coulomb = draw(sizes)
    speed = 10.0 ** draw(st.floats(-4.0, 3.0))
    return Friction(coulomb, coulomb + draw(sizes), speed, draw(sizes))


# ------------------------------------------------------------------------------------------------------ closed forms


def test_breakaway_speed_has_the_breakaway_torque():
    expected = 8e-4 - 5e-4 + 5e-4 * math.tanh(10.0) + 2e-6 * 0.1
    assert STRIBECK.torque(0.1) == pytest.approx(expected, rel=1e-14)
    assert STRIBECK.dry(0.1) == pytest.approx(8e-4, rel=1e-8)


def test_the_torque_is_the_formula_written_out():
    stribeck_speed, coulomb_speed = math.sqrt(2.0) * 0.1, 0.01
    for speed in (1e-3, 0.02, 0.07, 0.2, 0.5, 3.0):
        expected = math.sqrt(2.0 * math.e) * 3e-4 * math.exp(-((speed / stribeck_speed) ** 2)) * speed / stribeck_speed
        expected += 5e-4 * math.tanh(speed / coulomb_speed) + 2e-6 * speed
        assert STRIBECK.torque(speed) == pytest.approx(expected, rel=1e-14)


def test_the_stribeck_part_peaks_at_the_breakaway_speed():
    pure = Friction(coulomb=0.0, breakaway=1.0, breakaway_speed=0.3)
    speeds = np.linspace(0.0, 2.0, 2001)
    torque = pure.torque(speeds)
    assert speeds[np.argmax(torque)] == pytest.approx(0.3)
    assert torque.max() == pytest.approx(1.0, rel=1e-14)


def test_fast_wheels_have_coulomb_and_viscous_friction():
    fast = np.logspace(0.0, 4.0, 50)  # rad/s
    np.testing.assert_allclose(STRIBECK.torque(fast), 5e-4 + 2e-6 * fast, rtol=1e-12)
    np.testing.assert_allclose(STRIBECK.dry(fast), 5e-4, rtol=1e-12)


def test_slow_wheels_have_linear_friction():
    slope = math.sqrt(2.0 * math.e) * 3e-4 / (math.sqrt(2.0) * 0.1) + 5e-4 / 0.01 + 2e-6
    slow = np.logspace(-9.0, -5.0, 50)
    np.testing.assert_allclose(STRIBECK.torque(slow), slope * slow, rtol=1e-6)


def test_plain_kinds_of_friction():
    np.testing.assert_array_equal(Friction().torque(SPEEDS), 0.0)
    np.testing.assert_array_equal(Friction(viscous=0.3).torque(SPEEDS), 0.3 * SPEEDS)
    np.testing.assert_allclose(Friction(coulomb=2.0).torque(SPEEDS), 2.0 * np.tanh(SPEEDS / 0.01))
    assert Friction(coulomb=2.0).breakaway == 2.0


def test_shapes_of_speeds():
    assert STRIBECK.torque(0.1).shape == () and STRIBECK.torque([0.1, 0.2]).shape == (2,)
    assert STRIBECK.dry(np.ones((2, 3))).shape == (2, 3)


@settings(max_examples=100, deadline=None, derandomize=True)
@given(frictions())
def test_friction_is_odd_and_never_gives_energy(friction):
    torque = friction.torque(SPEEDS)
    assert np.all(np.isfinite(torque))
    np.testing.assert_array_equal(friction.torque(-SPEEDS), -torque)
    assert np.all(torque * SPEEDS >= 0.0)
    assert torque[0] == 0.0
    moving = friction.coulomb + friction.breakaway + friction.viscous > 0.0
    assert moving == bool(np.all(torque[(SPEEDS > 1e-9) & (friction.breakaway_speed > SPEEDS)] > 0.0))
    largest = friction.breakaway + friction.coulomb + friction.viscous * SPEEDS
    assert np.all(torque <= largest * (1.0 + 1e-12))


# ----------------------------------------------------------------------------------------------------- compiled twin


@njit
def compiled(table, momenta, factor):
    drag, slope = np.empty_like(momenta), np.empty_like(momenta)
    for index in range(momenta.size):
        drag[index], slope[index] = kernel.friction(table[0], momenta[index], factor)
    return drag, slope


@settings(max_examples=60, deadline=None, derandomize=True)
@given(frictions(), st.floats(-6.0, 1.0), st.sampled_from([1.0, 7.0]))
def test_the_plant_has_the_same_friction(friction, exponent, factor):
    inertia = 10.0**exponent
    table = wheel_table(WheelArray(np.eye(3)[:, :1], 1.0, spin_inertia=inertia, friction=friction), 0.02)
    speeds = np.concatenate([-SPEEDS, SPEEDS])
    drag, slope = compiled(table, inertia * speeds, factor)
    expected = friction.torque(speeds) + (factor - 1.0) * friction.dry(speeds)
    np.testing.assert_allclose(drag, expected, rtol=1e-12, atol=1e-300)
    # The slope against momentum, by central differences where they have digits.
    step = 1e-5 * friction.breakaway_speed
    at = friction.breakaway_speed * np.linspace(-3.0, 3.0, 61)
    _, slope = compiled(table, inertia * at, factor)
    ends = [friction.torque(at + side) + (factor - 1.0) * friction.dry(at + side) for side in (step, -step)]
    difference = (ends[0] - ends[1]) / (2.0 * step * inertia)
    np.testing.assert_allclose(slope, difference, rtol=1e-5, atol=1e-5 * (np.abs(slope).max() + 1e-300))


# ------------------------------------------------------------------------------------------------------------- rules


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"coulomb": -1e-9}, "coulomb must not be negative"),
        ({"coulomb": math.nan}, "coulomb must be finite"),
        ({"coulomb": "much"}, "coulomb must be a number"),
        ({"breakaway": -1.0}, "breakaway must not be negative"),
        ({"coulomb": 2e-3, "breakaway": 1.9e-3}, r"breakaway must not be below coulomb = 0\.002"),
        ({"breakaway": math.inf}, "breakaway must be finite"),
        ({"breakaway_speed": 0.0}, "breakaway_speed must be positive"),
        ({"breakaway_speed": -0.1}, "breakaway_speed must be positive"),
        ({"viscous": -1e-12}, "viscous must not be negative"),
        ({"viscous": math.inf}, "viscous must be finite"),
        ({"viscous": None}, "viscous must be a number"),
    ],
)
def test_friction_rules(changes, message):
    with pytest.raises(ValueError, match=message):
        Friction(**changes)


def test_friction_is_a_value():
    assert Friction(1e-3, viscous=1) == Friction(np.float64(1e-3), 1e-3, 0.1, 1.0)
    assert hash(Friction(1e-3)) == hash(Friction(1e-3, 1e-3))
    assert isinstance(Friction(1).coulomb, float)
    with pytest.raises(dataclasses.FrozenInstanceError):
        STRIBECK.coulomb = 1.0
