"""Use of the wheels against histories made by hand."""

import dataclasses

import numpy as np
import pytest
from helpers.histories import FLAGSHIP, LIMIT, STEPS, WHEELS, history, one

from ftac_gym.evaluation import episode_metrics
from ftac_gym.spacecraft import Spacecraft, WheelArray


def test_energy_chatter_and_saturation():
    torque = np.zeros((STEPS, 1, WHEELS))
    torque[:50, 0, 1], torque[:, 0, 3] = 0.1, -0.2
    assert one("energy", torque=torque) == pytest.approx(5.0 * 0.01 + 10.0 * 0.04)
    command = np.zeros((STEPS, 1, WHEELS))
    command[::2, 0, 0] = 0.05  # up and down at every step
    command[40:, 0, 2] = -LIMIT  # one step, and then at the limit
    assert one("chatter", command=command) == pytest.approx((99 * 0.05 + LIMIT) / 10.0)
    assert one("saturation", command=command) == pytest.approx(0.6 / WHEELS)
    assert one("saturation", command=np.full((STEPS, 1, WHEELS), 0.99 * LIMIT)) == 0.0


def test_momentum_headroom_is_that_of_the_fullest_wheel_at_the_worst_moment():
    limit = FLAGSHIP.spacecraft.wheels.momentum_limits[0]
    momentum = np.zeros((STEPS + 1, 1, WHEELS))
    momentum[30, 0, 2], momentum[40, 0, 1], momentum[-1, 0, 3] = 0.5 * limit, -0.7 * limit, 0.2 * limit
    assert one("momentum_headroom", momentum=momentum) == pytest.approx(0.3)
    assert one("final_headroom", momentum=momentum) == pytest.approx(0.8)
    assert one("momentum_headroom") == 1.0


@pytest.mark.parametrize(("limits", "headroom"), [(None, np.nan), ((2.0, 4.0, 8.0, 8.0), 0.25)])
def test_wheels_without_a_momentum_limit_have_no_headroom(limits, headroom):
    wheels = FLAGSHIP.spacecraft.wheels
    made = history(momentum=np.array([1.5, 2.0, 0.0, 0.0]))
    other = WheelArray(wheels.axes, wheels.torque_limit, limits)
    scenario = made.scenario.replace(spacecraft=Spacecraft(FLAGSHIP.spacecraft.inertia, other))
    metrics = episode_metrics(dataclasses.replace(made, scenario=scenario))
    for name in ("momentum_headroom", "final_headroom"):
        np.testing.assert_equal(metrics[name], [headroom])
