"""Measurements of a spacecraft: exact without errors, and with errors of the right size, shape and independence."""

import numpy as np
import pytest
from scipy import stats

from ftac_gym import attitude as att
from ftac_gym import scenarios
from ftac_gym.dynamics import Simulator
from ftac_gym.spacecraft.spacecraft import Spacecraft
from ftac_gym.spacecraft.wheel_array import WheelArray
from ftac_gym.task.scenario import Scenario
from ftac_gym.task.sensors import SensorErrors

PERIOD = 0.1  # s
CRAFT, STEPS = 300, 100


def craft(sensors, **changes):
    fields = {
        "name": "sensing",
        "spacecraft": Spacecraft(np.diag([10.0, 12.0, 14.0]), WheelArray(np.eye(3), 0.2)),
        "sensors": sensors,
        "control_period": PERIOD,
        "physics_step": PERIOD,
    }
    return Scenario(**{**fields, **changes})


def errors_of(scenario, episodes=None, steps=STEPS, command=0.0):
    """Return the errors of attitude (rotation vector, body axes) and of rate, both (T, N, 3), from tick 0 on."""
    episodes = scenario.draw(0, CRAFT) if episodes is None else episodes
    simulator = Simulator(scenario, len(episodes))
    simulator.reset(episodes)
    attitude, rate = [], []
    for step in range(steps + 1):
        if step:
            simulator.step(np.full(simulator.last_command.shape, command))
        measured = simulator.measurement()
        error = att.quaternion_error(measured.attitude, simulator.state.attitude)
        attitude.append(att.rotation_vector_from_quaternion(error))
        rate.append(measured.rate - simulator.state.rate)
    return np.array(attitude), np.array(rate)


def assert_uncorrelated(a, b):
    assert abs(np.corrcoef(a.ravel(), b.ravel())[0, 1]) < 5.0 / np.sqrt(a.size)


def test_without_errors_the_measurement_is_the_truth():
    scenario = scenarios.get("flagship").replace(sensors=None)
    simulator = Simulator(scenario, 5)
    simulator.reset(scenario.draw(0, 5))
    for _ in range(20):
        simulator.step(np.full((5, 4), 0.1))
        measured = simulator.measurement()
        np.testing.assert_array_equal(measured.rate, simulator.state.rate)
        np.testing.assert_allclose(measured.attitude, simulator.state.attitude, rtol=0.0, atol=1e-15)
        np.testing.assert_array_equal(measured.wheel_momentum, simulator.state.wheel_momentum)


def test_noise_is_normal_with_the_given_standard_deviations():
    attitude, rate = errors_of(craft(SensorErrors(attitude_noise=2e-4, rate_noise=3e-5)))
    for errors, deviation in ((attitude, 2e-4), (rate, 3e-5)):
        for axis in range(3):
            sample = errors[:, :, axis].ravel() / deviation
            assert stats.kstest(sample, "norm").pvalue > 1e-3
            assert sample.std() == pytest.approx(1.0, abs=0.02)
            assert abs(sample.mean()) < 0.02


def test_noise_is_independent_between_axes_sensors_times_and_craft():
    attitude, rate = errors_of(craft(SensorErrors(attitude_noise=1e-4, rate_noise=1e-4)))
    channels = np.concatenate([attitude, rate], axis=2)
    correlation = np.corrcoef(channels.reshape(-1, 6).T) - np.eye(6)
    assert np.abs(correlation).max() < 5.0 / np.sqrt(attitude[..., 0].size)
    for errors in (attitude, rate):
        assert_uncorrelated(errors[1:], errors[:-1])
        assert_uncorrelated(errors[:, 1:], errors[:, :-1])


def test_noise_is_there_at_the_very_first_measurement():
    attitude, rate = errors_of(craft(SensorErrors(attitude_noise=1e-4, rate_noise=1e-5)), steps=0)
    assert np.all(attitude != 0.0) and np.all(rate != 0.0)


def test_one_sensor_can_be_noisy_alone():
    attitude, rate = errors_of(craft(SensorErrors(attitude_noise=1e-4)), steps=3)
    assert np.all(rate == 0.0) and np.all(np.abs(attitude) > 0.0)
    attitude, rate = errors_of(craft(SensorErrors(rate_noise=1e-4)), steps=3)
    assert np.all(np.abs(attitude) < 1e-15) and np.all(np.abs(rate) > 0.0)


def test_measured_quaternions_have_unit_norm():
    scenario = craft(SensorErrors(attitude_noise=0.1))
    simulator = Simulator(scenario, 50)
    simulator.reset(scenario.draw(0, 50))
    np.testing.assert_allclose(np.linalg.norm(simulator.measurement().attitude, axis=1), 1.0, atol=1e-15)


def test_noise_does_not_depend_on_what_the_craft_does():
    scenario = craft(SensorErrors(attitude_noise=1e-4, rate_noise=1e-5, gyro_bias_walk=1e-6))
    quiet, busy = errors_of(scenario, command=0.0), errors_of(scenario, command=0.1)
    np.testing.assert_allclose(quiet[0], busy[0], rtol=0.0, atol=1e-13)
    np.testing.assert_allclose(quiet[1], busy[1], rtol=0.0, atol=1e-15)


def test_noise_differs_between_seeds_and_episodes():
    scenario = craft(SensorErrors(rate_noise=1e-5))
    first, other = (errors_of(scenario, scenario.draw(seed, 50), 20)[1] for seed in (0, 1))
    assert len(np.unique(np.concatenate([first, other]))) == 2 * first.size
    again = errors_of(scenario, scenario.draw(0, 80)[30:50], 20)[1]
    np.testing.assert_array_equal(again, first[:, 30:50])


def test_gyro_bias_stays_without_a_walk():
    scenario = craft(SensorErrors(gyro_bias=(-1e-5, 1e-5)))
    _, rate = errors_of(scenario, steps=10)
    np.testing.assert_allclose(rate, np.broadcast_to(rate[0], rate.shape), rtol=0.0, atol=1e-18)
    assert stats.kstest(rate[0].ravel(), "uniform", (-1e-5, 2e-5)).pvalue > 1e-3


def test_gyro_bias_walks_with_the_variance_of_the_elapsed_time():
    walk, bias = 2e-6, 3e-5
    scenario = craft(SensorErrors(gyro_bias=bias, gyro_bias_walk=walk))
    _, rate = errors_of(scenario, scenario.draw(0, 2000))
    np.testing.assert_allclose(rate[0], bias, rtol=1e-12)
    for step in (1, 10, 100):
        sample = (rate[step] - bias) / (walk * np.sqrt(step * PERIOD))
        assert sample.std() == pytest.approx(1.0, abs=0.04)
        assert stats.kstest(sample.ravel(), "norm").pvalue > 1e-3
    increments = np.diff(rate, axis=0)
    assert_uncorrelated(increments[1:], increments[:-1])
    correlation = np.corrcoef(increments.reshape(-1, 3).T) - np.eye(3)
    assert np.abs(correlation).max() < 5.0 / np.sqrt(increments[..., 0].size)


def test_gyro_bias_walk_does_not_depend_on_the_control_period():
    ends = []
    for period in (0.05, 0.2):
        scenario = craft(SensorErrors(gyro_bias_walk=1e-6), control_period=period, physics_step=period)
        ends.append(errors_of(scenario, scenario.draw(0, 2000), round(4.0 / period))[1][-1].std())
    assert ends[0] == pytest.approx(2e-6, rel=0.04) and ends[1] == pytest.approx(2e-6, rel=0.04)


def test_walk_and_noise_are_independent():
    scenario = craft(SensorErrors(attitude_noise=1e-6, gyro_bias_walk=1e-6))
    attitude, rate = errors_of(scenario)
    assert_uncorrelated(np.diff(rate, axis=0), attitude[1:])
