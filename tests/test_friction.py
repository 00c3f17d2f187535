"""Bearing friction: closed forms, dissipation, and refused parameters."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ftac_gym.friction import Friction

STRIBECK = Friction(coulomb=5e-4, breakaway=9e-4, breakaway_speed=0.3, viscous=1e-6)


@st.composite
def frictions(draw):
    coulomb = draw(st.floats(0.0, 1e2))
    return Friction(
        coulomb, coulomb + draw(st.floats(0.0, 1e2)), draw(st.floats(1e-3, 1e3)), draw(st.floats(0.0, 1.0))
    )  # fmt: skip


@settings(max_examples=200, deadline=None, derandomize=True)
@given(frictions(), st.floats(-1e4, 1e4))
def test_friction_never_gives_power(friction, speed):
    assert friction.torque(speed) * speed >= 0.0
    assert friction.dry(speed) * speed >= 0.0
    assert friction.torque(-speed) == -friction.torque(speed)


def test_breakaway_is_the_peak_of_dry_friction():
    # sqrt(2 e) exp(-1/2) / sqrt 2 = 1 at the breakaway speed, where tanh(10) has reached one to 4e-9.
    assert STRIBECK.dry(0.3) == pytest.approx(9e-4, rel=1e-8)
    speeds = np.linspace(0.0, 3.0, 3001)
    assert STRIBECK.dry(speeds).max() == pytest.approx(9e-4, rel=1e-3)


def test_far_from_rest_friction_is_coulomb_plus_viscous():
    np.testing.assert_allclose(STRIBECK.torque([3.0, 600.0]), [5e-4 + 3e-6, 5e-4 + 6e-4], rtol=1e-12)
    np.testing.assert_allclose(STRIBECK.torque(-600.0), -5e-4 - 6e-4, rtol=1e-12)


def test_slope_at_rest():
    slope = math.sqrt(2.0 * math.e) * 4e-4 / (math.sqrt(2.0) * 0.3) + 5e-4 / 0.03 + 1e-6
    assert (STRIBECK.torque(1e-9) - STRIBECK.torque(-1e-9)) / 2e-9 == pytest.approx(slope, rel=1e-9)


def test_shapes_and_defaults():
    assert STRIBECK.torque(np.zeros((2, 3))).shape == (2, 3) and not STRIBECK.torque(np.zeros(3)).any()
    assert Friction(1e-3).breakaway == 1e-3 and Friction(1e-3).stribeck == 0.0
    assert Friction().torque(5.0) == 0.0


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"coulomb": -1e-4}, "coulomb must not be negative, got -0.0001"),
        ({"coulomb": math.nan}, "coulomb must be finite"),
        ({"coulomb": "rough"}, "coulomb must be a number"),
        ({"coulomb": 1e-3, "breakaway": 9e-4}, "breakaway must not be below coulomb = 0.001"),
        ({"breakaway": -1.0}, "breakaway must not be negative"),
        ({"breakaway_speed": 0.0}, "breakaway_speed must be positive"),
        ({"viscous": -1e-9}, "viscous must not be negative"),
        ({"viscous": math.inf}, "viscous must be finite"),
    ],
)
def test_rules(fields, message):
    with pytest.raises(ValueError, match=message):
        Friction(**fields)
