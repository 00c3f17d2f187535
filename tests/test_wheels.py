"""The wheel array as data: what it accepts, what it derives, and what it refuses."""

import math

import numpy as np
import pytest

from ftac_gym import layouts, scenarios
from ftac_gym.friction import Friction
from ftac_gym.scenario import Scenario
from ftac_gym.spacecraft import Spacecraft
from ftac_gym.wheels import WheelArray

AXES = layouts.sign_pyramid()
FULL = {
    "torque_limit": 0.2,
    "momentum_limit": 12.0,
    "spin_inertia": 0.02,
    "speed_limit": 500.0,
    "friction": Friction(5e-4),
    "lag": 0.03,
    "dead_band": 1e-5,
    "power_limit": 60.0,
}


def test_effects_are_off_unless_given():
    wheels = WheelArray(AXES, 0.2)
    assert np.isinf(wheels.momentum_limits).all() and np.isinf(wheels.power_limits).all()
    assert not wheels.lags.any() and not wheels.dead_bands.any()
    assert np.isinf(wheels.spin_inertias).all() and wheels.frictions == (None,) * 4


def test_one_number_is_for_all_wheels_and_a_sequence_for_each():
    one, each = WheelArray(AXES, **FULL), WheelArray(AXES, **{**FULL, "lag": (0.01, 0.02, 0.03, 0.04)})
    assert one.count == 4 and one.friction == (Friction(5e-4),) * 4
    np.testing.assert_array_equal(one.lags, 0.03)
    np.testing.assert_array_equal(each.lags, [0.01, 0.02, 0.03, 0.04])


def test_friction_can_differ_or_be_missing_wheel_by_wheel():
    friction = (None, Friction(1e-3), None, Friction(2e-3, viscous=1e-6))
    assert WheelArray(AXES, **{**FULL, "friction": friction}).frictions == friction


def test_the_speed_limit_is_a_momentum_limit_too():
    np.testing.assert_allclose(WheelArray(AXES, **FULL).momentum_limits, 10.0)
    np.testing.assert_allclose(WheelArray(AXES, **{**FULL, "speed_limit": 700.0}).momentum_limits, 12.0)
    np.testing.assert_allclose(WheelArray(AXES, **{**FULL, "momentum_limit": None}).momentum_limits, 10.0)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        *(({name: -1.0}, rf"{name}\[0\] must be positive, got -1\.0") for name in FULL if name != "friction"),
        *(({name: 0.0}, rf"{name}\[0\] must be positive") for name in FULL if name != "friction"),
        *(({name: (1.0, 1.0)}, f"{name} must have 4 numbers") for name in FULL if name != "friction"),
        ({"lag": (0.01, 0.02, math.nan, 0.04)}, "lag must be finite"),
        ({"lag": "slow"}, "lag must have 4 numbers"),
        ({"friction": (Friction(),) * 3}, "friction must have 4 entries, one per wheel, got 3"),
        ({"friction": (Friction(), None, 0.1, None)}, r"friction\[2\] must be a Friction or None, got 0\.1"),
        ({"friction": 5e-4}, "friction must be a Friction, one per wheel, or None, got 0.0005"),
        ({"spin_inertia": None, "speed_limit": None, "power_limit": None}, "friction needs spin_inertia"),
        ({"spin_inertia": None, "speed_limit": None, "friction": None}, "power_limit needs spin_inertia"),
        ({"spin_inertia": None, "power_limit": None, "friction": None}, "speed_limit needs spin_inertia"),
        ({"axes": np.eye(3)[:, :2] * 2.0}, "axes must have columns of unit length"),
    ],
)
def test_rules(changes, message):
    with pytest.raises(ValueError, match=message):
        WheelArray(**{"axes": AXES, **FULL, **changes})


@pytest.mark.parametrize("friction", [None, Friction(1e-3), (None, Friction(1e-3), None, None)])
def test_json_keeps_every_effect(friction):
    wheels = WheelArray(AXES, **{**FULL, "friction": friction})
    scenario = scenarios.get("flagship").replace(spacecraft=Spacecraft(np.diag([10.0, 12.0, 14.0]), wheels))
    assert Scenario.from_json(scenario.to_json()).spacecraft.wheels == wheels
