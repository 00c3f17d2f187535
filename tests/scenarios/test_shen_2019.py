"""Shen et al. 2019: the published numbers reach the plant, and a controller flies the case."""

import math

import numpy as np
import pytest

from ftac_gym import scenarios
from ftac_gym.dynamics import Simulator
from ftac_gym.evaluation import rollout
from ftac_gym.faults import fault_effect

SCENARIO = scenarios.get("shen_2019")


def test_start_timing_and_plant():
    simulator = Simulator(SCENARIO, 1)
    simulator.reset(SCENARIO.draw(0, 1))
    np.testing.assert_allclose(simulator.state.attitude[0], [math.sqrt(0.5), -0.5, 0.3, -0.4], atol=1e-15)
    assert not simulator.state.rate.any()
    assert SCENARIO.control_period == 0.1 and SCENARIO.duration == 200.0
    np.testing.assert_array_equal(SCENARIO.spacecraft.inertia_matrix, [[10, 1.2, 0.5], [1.2, 19, 1.5], [0.5, 1.5, 25]])
    np.testing.assert_allclose(np.abs(SCENARIO.spacecraft.wheels.axis_matrix), 1.0 / math.sqrt(3.0))
    np.testing.assert_array_equal(SCENARIO.spacecraft.wheels.torque_limits, 0.2)


@pytest.mark.parametrize(
    ("time", "effectiveness", "bias"),
    [
        (4.9, (1.0, 1.0, 1.0, 1.0), (0.0, 0.0, 0.0, 0.0)),
        (5.0, (0.4, 0.8, 1.0, 1.0), (0.0, 0.0, 0.0, 0.0)),
        (100.0, (0.4, 0.8, 1.0, 1.0), (0.0, -0.03, -0.06, 0.0)),
    ],
)
def test_faults_at_their_times(time, effectiveness, bias):
    episodes = SCENARIO.draw(0, 1)
    zero = np.zeros((1, 4))
    effect = fault_effect(episodes.drawn_faults, np.array([time]), SCENARIO.spacecraft.wheels, zero, zero)
    np.testing.assert_allclose(effect.effectiveness[0], effectiveness)
    np.testing.assert_allclose(effect.bias[0], bias)


def test_disturbance_is_the_sine_of_the_paper():
    episodes = SCENARIO.draw(0, 1)
    assert not episodes.disturbance["constant"].any() and not episodes.harmonics["cosine"].any()
    np.testing.assert_allclose(episodes.harmonics["sine"][0, 0], 0.005)
    assert episodes.harmonics["frequency"][0, 0] == 1.0


def test_sensors_are_as_bad_as_the_paper_says():
    sensors = SCENARIO.draw(0, 1).sensors[0]
    assert math.degrees(sensors["attitude_noise"]) == pytest.approx(0.005)
    assert math.degrees(sensors["rate_noise"]) == pytest.approx(5e-4)
    np.testing.assert_allclose(np.degrees(sensors["gyro_bias"]) * 3600.0, 1.0)
    assert math.degrees(np.linalg.norm(sensors["gyro_misalignment"])) == pytest.approx(0.1)


def test_it_can_be_flown():
    episodes = SCENARIO.draw(0, 3)
    assert episodes.feasible.all()
    history = rollout(SCENARIO, "pd_dob", episodes)
    before, after = history.attitude_error[900:1000], history.attitude_error[-200:]
    assert np.degrees(before.max()) < 0.05 and np.degrees(after.max()) < 0.05
    assert np.degrees(history.attitude_error[1000:1100].max()) > np.degrees(before.max())  # the biases act
