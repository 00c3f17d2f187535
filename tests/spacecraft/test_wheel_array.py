"""Tests of `wheel_array`: the data of real wheels, their rules, derived arrays, and the way through JSON."""

import dataclasses
import math

import numpy as np
import pytest

from ftac_gym.dynamics.wheel_table import wheel_table
from ftac_gym.spacecraft import Friction, Spacecraft, WheelArray
from ftac_gym.task import Scenario

FRICTION = Friction(coulomb=5e-4, breakaway=8e-4, viscous=1e-6)


def orthogonal(**changes):
    return WheelArray(**{"axes": np.eye(3), "torque_limit": 0.5, "spin_inertia": 0.02, **changes})


# ----------------------------------------------------------------------------------------------------- derived arrays


def test_every_effect_is_off_by_default():
    wheels = WheelArray(np.eye(3), 0.5)
    for name in ("momentum_limits", "spin_inertias", "power_limits"):
        assert np.all(np.isposinf(getattr(wheels, name))) and getattr(wheels, name).shape == (3,)
    for name in ("lags", "dead_bands"):
        np.testing.assert_array_equal(getattr(wheels, name), np.zeros(3))
    assert wheels.frictions == (None, None, None)


def test_one_value_holds_for_all_wheels():
    wheels = orthogonal(lag=0.03, dead_band=1e-5, power_limit=20, friction=FRICTION)
    np.testing.assert_array_equal(wheels.lags, [0.03] * 3)
    np.testing.assert_array_equal(wheels.dead_bands, [1e-5] * 3)
    np.testing.assert_array_equal(wheels.power_limits, [20.0] * 3)
    np.testing.assert_array_equal(wheels.spin_inertias, [0.02] * 3)
    assert wheels.frictions == (FRICTION,) * 3


def test_values_per_wheel():
    wheels = orthogonal(
        spin_inertia=(0.01, 0.02, 0.03), lag=[0.1, 0.2, 0.3], power_limit=np.arange(1.0, 4.0),
        friction=[None, FRICTION, Friction(viscous=1.0)],
    )  # fmt: skip
    np.testing.assert_array_equal(wheels.spin_inertias, [0.01, 0.02, 0.03])
    np.testing.assert_array_equal(wheels.lags, [0.1, 0.2, 0.3])
    np.testing.assert_array_equal(wheels.power_limits, [1.0, 2.0, 3.0])
    assert wheels.frictions == (None, FRICTION, Friction(viscous=1.0))


def test_the_speed_limit_limits_the_momentum():
    np.testing.assert_allclose(orthogonal(speed_limit=600.0).momentum_limits, 12.0)
    both = orthogonal(speed_limit=(100.0, 600.0, 600.0), momentum_limit=(5.0, 5.0, 20.0))
    np.testing.assert_allclose(both.momentum_limits, [2.0, 5.0, 12.0])


def test_arrays_lists_and_tuples_make_equal_wheels():
    one = orthogonal(lag=[0.1] * 3, friction=[FRICTION] * 3)
    other = orthogonal(lag=np.full(3, 0.1), friction=FRICTION, spin_inertia=(0.02,) * 3)
    assert one == other and hash(one) == hash(other)
    assert one != orthogonal(lag=0.1)
    with pytest.raises(dataclasses.FrozenInstanceError):
        one.lag = 0.2
    assert dataclasses.replace(one, lag=None).friction == one.friction


def test_only_bare_wheels_take_the_short_way_through_the_plant():
    assert np.all(wheel_table(orthogonal(momentum_limit=1.0, speed_limit=30.0), 0.02)["ideal"] == 1.0)
    for effect in ({"lag": 0.1}, {"dead_band": 1e-3}, {"power_limit": 5.0}, {"friction": Friction()}):
        assert np.all(wheel_table(orthogonal(**effect), 0.02)["ideal"] == 0.0)
    mixed = wheel_table(orthogonal(friction=(None, FRICTION, None)), 0.02)
    np.testing.assert_array_equal(mixed["ideal"], [1.0, 0.0, 1.0])


@pytest.mark.parametrize("viscous", [0.0, 1e-3, 1.0, 1e3, 1e6])
@pytest.mark.parametrize("lag", [1e-9, 1e-4, 0.03, 10.0, 1e6])
@pytest.mark.parametrize("step", [1e-3, 0.02, 1.0])
def test_weights_of_the_forcing_are_those_of_the_integral(viscous, lag, step):
    # However stiff: the weights integrate constants, lines and parabolas exactly, and nothing overflows.
    wheels = WheelArray(np.eye(3)[:, :1], 0.5, spin_inertia=0.02, friction=Friction(viscous=viscous), lag=lag)
    record = wheel_table(wheels, step)[0]
    rate, fade = viscous / 0.02, 1.0 / lag
    # In pieces, so that layers at both ends are resolved.
    edges = np.unique(np.concatenate([[0.0, 1.0], np.logspace(-14, -0.01, 150), 1.0 - np.logspace(-14, -0.01, 150)]))
    nodes, weights = np.polynomial.legendre.leggauss(8)
    x = (edges[:-1, None] + np.diff(edges)[:, None] * 0.5 * (nodes + 1.0)).ravel()
    weights = (0.5 * np.diff(edges)[:, None] * weights).ravel() * step
    for name, exponent in (("forcing", 0.0), ("lag_forcing", fade)):
        kernel = weights * np.exp(-exponent * step * x - rate * step * (1.0 - x))
        for power in range(3):
            points = np.array([0.0, 0.5, 1.0]) ** power
            assert record[name] @ points == pytest.approx(kernel @ x**power, rel=1e-9, abs=1e-13 * kernel.sum())
    assert record["keep"] == pytest.approx(math.exp(-rate * step))
    assert np.all(np.isfinite(record["forcing"])) and np.all(np.isfinite(record["lag_forcing"]))


# ------------------------------------------------------------------------------------------------------------- rules


@pytest.mark.parametrize("name", ["spin_inertia", "speed_limit", "lag", "dead_band", "power_limit"])
def test_values_must_be_positive_and_finite_one_per_wheel(name):
    for value, rule in (
        (0.0, rf"{name}\[0\] must be positive"),
        (-1.0, rf"{name}\[0\] must be positive"),
        ((1.0, 2.0, -3.0), rf"{name}\[2\] must be positive"),
        (math.nan, f"{name} must be finite"),
        (math.inf, f"{name} must be finite"),
        ((1.0, 2.0), f"{name} must have 3 numbers"),
        ((1.0,) * 4, f"{name} must have 3 numbers"),
        (((1.0, 2.0, 3.0),), f"{name} must have 3 numbers"),
        ("fast", f"{name} must have 3 numbers"),
    ):
        with pytest.raises(ValueError, match=rule):
            orthogonal(**{name: value})


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"friction": 1e-3}, "friction must be a Friction, one per wheel, or None"),
        ({"friction": (FRICTION, FRICTION)}, "friction must have 3 entries, one per wheel, got 2"),
        ({"friction": (FRICTION,) * 4}, "friction must have 3 entries, one per wheel, got 4"),
        ({"friction": (FRICTION, 1e-3, None)}, r"friction\[1\] must be a Friction or None"),
        ({"spin_inertia": None, "friction": FRICTION}, "friction needs spin_inertia"),
        ({"spin_inertia": None, "speed_limit": 600.0}, "speed_limit needs spin_inertia"),
        ({"spin_inertia": None, "power_limit": 5.0}, "power_limit needs spin_inertia"),
    ],
)
def test_wheel_rules(changes, message):
    with pytest.raises(ValueError, match=message):
        orthogonal(**changes)


def test_lag_and_dead_band_need_no_spin_inertia():
    assert orthogonal(spin_inertia=None, lag=0.1, dead_band=1e-3).spin_inertia is None


# -------------------------------------------------------------------------------------------------------------- JSON


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"friction": FRICTION, "lag": 0.03, "dead_band": 1e-5, "power_limit": 60.0, "speed_limit": 628.3},
        {"friction": (None, FRICTION, Friction(viscous=0.1)), "lag": (0.1, 0.2, 0.3), "spin_inertia": (1e-5, 1.0, 2.0)},
        {"spin_inertia": None, "momentum_limit": 1.0, "momentum_coupling": False},
    ],
)
def test_real_wheels_survive_json(changes):
    scenario = Scenario(name="real", spacecraft=Spacecraft(np.diag([10.0, 12.0, 14.0]), orthogonal(**changes)))
    rebuilt = Scenario.from_json(scenario.to_json())
    assert rebuilt == scenario and rebuilt.to_json() == scenario.to_json()
    assert rebuilt.spacecraft.wheels == orthogonal(**changes)
    assert rebuilt.draw(1, 3).digest() == scenario.draw(1, 3).digest()


def test_json_of_real_wheels_is_checked():
    data = Scenario(name="real", spacecraft=Spacecraft(np.eye(3), orthogonal(friction=FRICTION))).to_dict()
    data["spacecraft"]["wheels"]["friction"][1]["coulomb"] = -1.0
    with pytest.raises(ValueError, match="coulomb must not be negative"):
        Scenario.from_dict(data)
    data["spacecraft"]["wheels"]["friction"][1] = {"type": "Friction", "stiction": 1.0}
    with pytest.raises(ValueError, match="Friction has no field 'stiction'"):
        Scenario.from_dict(data)
