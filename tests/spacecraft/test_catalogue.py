"""The catalogue of real wheels: its numbers, and the arrays that are made of them."""

import math

import numpy as np
import pytest

from ftac_gym.spacecraft import catalogue, orthogonal_and_skew, sign_pyramid


@pytest.mark.parametrize("name", catalogue.names())
def test_every_wheel_makes_an_array(name):
    wheel = catalogue.get(name)
    array = wheel.array(orthogonal_and_skew(), lag=0.03)
    assert array.count == 4 and wheel.source
    np.testing.assert_allclose(array.torque_limits, wheel.torque)
    np.testing.assert_allclose(array.momentum_limits, wheel.momentum)
    np.testing.assert_allclose(array.spin_inertias * wheel.speed, wheel.momentum)
    np.testing.assert_allclose(array.lags, 0.03)
    assert (array.friction is None) == (wheel.coulomb is None)
    assert (array.dead_band is None) == (wheel.least_torque is None)


@pytest.mark.parametrize(
    ("name", "torque", "momentum", "rpm"),
    [
        ("rwp015", 0.004, 0.015, 6000),
        ("rwp500", 0.025, 0.5, 6000),
        ("hr12-12", 0.2, 12.0, 6000),
        ("hr16-100", 0.2, 100.0, 6000),
    ],
)
def test_numbers_of_the_data_sheets(name, torque, momentum, rpm):
    wheel = catalogue.get(name)
    assert (wheel.torque, wheel.momentum) == (torque, momentum)
    assert wheel.speed * 60.0 / (2.0 * math.pi) == pytest.approx(rpm)


def test_friction_and_power_of_those_that_publish_it():
    array = catalogue.get("hr12-12").array(sign_pyramid(), power_limit=60.0)
    assert {friction.coulomb for friction in array.frictions} == {5e-4}
    np.testing.assert_array_equal(array.power_limits, 60.0)
    np.testing.assert_array_equal(catalogue.get("rwp500").array(sign_pyramid()).power_limits, 6.0)


def test_an_unknown_wheel_is_refused():
    with pytest.raises(ValueError, match=r"wheel must be one of \['hr12-12'.*got 'hr99'"):
        catalogue.get("hr99")
