"""Observers against closed forms: what they converge to, how fast, and how much noise they let through."""

import numpy as np
import pytest

from ftac_gym import scenarios
from ftac_gym.attitude import angle_between, quaternion_from_rotation_vector, quaternion_product
from ftac_gym.baselines.memory import Memory
from ftac_gym.baselines.observers.attitude_filter import AttitudeFilter
from ftac_gym.baselines.observers.disturbance_observer import DisturbanceObserver, GyroscopicModel
from ftac_gym.dynamics import Simulator
from ftac_gym.spacecraft.spacecraft import Spacecraft
from ftac_gym.spacecraft.wheel_array import WheelArray
from ftac_gym.task.disturbances import Disturbance
from ftac_gym.task.initial_state import InitialState
from ftac_gym.task.measurement import Measurement

FLAGSHIP = scenarios.get("flagship")
AXES = FLAGSHIP.spacecraft.wheels.axes
TORQUE = np.array([2e-3, -3e-3, 1e-3])  # N m
QUIET = FLAGSHIP.replace(
    faults=None, sensors=None, inertia_uncertainty=None, disturbance=Disturbance(tuple(TORQUE.tolist())),
    initial_state=InitialState.fixed(),
)  # fmt: skip
UNCOUPLED = QUIET.replace(
    spacecraft=Spacecraft(FLAGSHIP.spacecraft.inertia, WheelArray(AXES, 0.2, 12.0, momentum_coupling=False))
)


def observer_of(scenario, count, bandwidth, telemetry=False):
    memory = Memory(count)
    return DisturbanceObserver(scenario, memory, bandwidth, GyroscopicModel(scenario, telemetry)), memory


# ------------------------------------------------------------------------------------------------ disturbance observer


@pytest.mark.parametrize("bandwidth", [0.3, 1.0, 4.0])
@pytest.mark.parametrize(
    ("scenario", "telemetry"), [(UNCOUPLED, False), (QUIET, True)], ids=["ideal torquers", "telemetry"]
)
def test_converges_with_its_time_constant(scenario, telemetry, bandwidth):
    simulator, (observer, _) = Simulator(scenario, 1), observer_of(scenario, 1, bandwidth, telemetry)
    simulator.reset(scenario.draw(0, 1))
    np.testing.assert_array_equal(observer.update(simulator.measurement()), 0.0)
    random = np.random.default_rng(0)
    for step in range(1, 80):
        simulator.step(random.uniform(-0.1, 0.1, (1, 4)))  # known to the observer, so that it must not matter
        estimate = observer.update(simulator.measurement())
        expected = TORQUE * (1.0 - np.exp(-bandwidth * step * scenario.control_period))
        np.testing.assert_allclose(estimate[0], expected, atol=5e-5)


def test_lumps_what_the_model_leaves_out():
    """Without telemetry the gyroscopic torque of a spinning spacecraft is part of the estimate."""
    scenario = QUIET.replace(initial_state=InitialState.fixed(rate=(0.05, 0.05, 0.0), wheel_momentum=1.0))
    estimates = {}
    for telemetry in (False, True):
        simulator, (observer, _) = Simulator(scenario, 1), observer_of(scenario, 1, 20.0, telemetry)
        simulator.reset(scenario.draw(0, 1))
        for _ in range(10):
            estimates[telemetry] = observer.update(simulator.measurement())[0]
            simulator.step(np.zeros((1, 4)))
    np.testing.assert_allclose(estimates[True], TORQUE, atol=2e-4)
    rate, momentum = simulator.state.rate[0], simulator.state.wheel_momentum[0]
    stored = FLAGSHIP.spacecraft.inertia_matrix @ rate + np.array(AXES) @ momentum
    np.testing.assert_allclose(estimates[False], TORQUE - np.cross(rate, stored), atol=1e-2)
    assert np.abs(estimates[False] - TORQUE).max() > 0.05


@pytest.mark.parametrize("coupling", [True, False])
def test_gyroscopic_model(coupling):
    random = np.random.default_rng(0)
    wheels = WheelArray(AXES, 0.2, 12.0, momentum_coupling=coupling)
    scenario = FLAGSHIP.replace(spacecraft=Spacecraft(FLAGSHIP.spacecraft.inertia, wheels))
    rate, momentum = random.normal(size=(5, 3)), random.normal(size=(5, 4))
    stored = rate @ scenario.spacecraft.inertia_matrix + coupling * momentum @ np.array(AXES).T
    known = GyroscopicModel(scenario, telemetry=True).torque(rate, momentum)
    np.testing.assert_allclose(known, np.cross(rate, stored), atol=1e-12)
    blind = GyroscopicModel(scenario, telemetry=False).torque(rate, momentum)
    np.testing.assert_allclose(blind, 0.0 if coupling else np.cross(rate, stored), atol=1e-12)


def test_observer_reset_by_mask():
    observer, memory = observer_of(UNCOUPLED, 3, 1.0)
    simulator = Simulator(UNCOUPLED, 3)
    simulator.reset(UNCOUPLED.draw(0, 3))
    for _ in range(20):
        before = observer.update(simulator.measurement()).copy()
        simulator.step(np.zeros((3, 4)))
    memory.reset(np.array([False, True, False]))
    np.testing.assert_array_equal(observer.disturbance[1], 0.0)
    np.testing.assert_array_equal(observer.disturbance[[0, 2]], before[[0, 2]])
    # The first period after the reset is not balanced against a rate of zero.
    np.testing.assert_array_equal(observer.update(simulator.measurement())[1], 0.0)


# ---------------------------------------------------------------------------------------------------- attitude filter


def still(attitude, rate):
    """Return the measurement of N spacecraft with the given attitude (N, 4) and rate (N, 3)."""
    count = len(attitude)
    identity, three, four = np.tile([1.0, 0, 0, 0], (count, 1)), np.zeros((count, 3)), np.zeros((count, 4))
    return Measurement(np.zeros(count), attitude, rate, four, four, np.ones(count, bool), identity, three, three)


def noisy(attitude, size, random):
    """Turn attitudes by small random rotations."""
    return quaternion_product(attitude, quaternion_from_rotation_vector(random.normal(size=(len(attitude), 3)) * size))


@pytest.mark.parametrize("time_constant", [0.3, 1.0, 5.0])
@pytest.mark.parametrize("rate", [(0.0, 0.0, 0.0), (0.05, -0.1, 0.07)])
def test_filter_reduces_noise_as_theory_says(rate, time_constant):
    """White noise of standard deviation s leaves s sqrt(g / (2 - g)), for the gain g = 1 - exp(-T / time constant)."""
    count, noise, random = 400, 1e-4, np.random.default_rng(0)
    attitude_filter = AttitudeFilter(FLAGSHIP, Memory(count), time_constant)
    period = FLAGSHIP.control_period
    rates = np.tile(rate, (count, 1))
    turn = quaternion_from_rotation_vector(rates * period)
    truth = np.tile([0.5, 0.5, -0.5, 0.5], (count, 1))
    steps = round(6.0 * time_constant / period)
    for _ in range(steps):
        filtered = attitude_filter.update(still(noisy(truth, noise, random), rates))
        error = 2.0 * quaternion_product(truth * [1.0, -1.0, -1.0, -1.0], filtered)[:, 1:]
        truth = quaternion_product(truth, turn)
    gain = 1.0 - np.exp(-period / time_constant)
    expected = noise * np.sqrt(gain / (2.0 - gain))
    assert error.std() == pytest.approx(expected, rel=0.08)
    assert np.abs(error.mean(axis=0)).max() < 4.0 * expected / np.sqrt(count)  # no bias, though it turns
    np.testing.assert_allclose(np.linalg.norm(filtered, axis=1), 1.0, atol=1e-12)


def test_filter_is_exact_for_a_constant_rate():
    attitude_filter = AttitudeFilter(FLAGSHIP, Memory(1), 2.0)
    rate = np.array([[0.1, 0.2, -0.3]])
    truth = np.array([[1.0, 0.0, 0.0, 0.0]])
    for _ in range(200):
        filtered = attitude_filter.update(still(truth, rate))
        assert angle_between(filtered, truth)[0] < 1e-9
        truth = quaternion_product(truth, quaternion_from_rotation_vector(rate * FLAGSHIP.control_period))


def test_filter_does_not_mind_the_sign_of_a_quaternion():
    filters = [AttitudeFilter(FLAGSHIP, Memory(1), 2.0) for _ in range(2)]
    random = np.random.default_rng(0)
    truth, rate = np.array([[0.5, 0.5, 0.5, 0.5]]), np.zeros((1, 3))
    for step in range(20):
        measured = noisy(truth, 1e-3, random)
        first = filters[0].update(still(measured, rate))
        second = filters[1].update(still(measured * (-1.0) ** step, rate))
        assert angle_between(first, second)[0] < 1e-9


def test_filter_forgets_a_wrong_start_with_its_time_constant():
    time_constant, period = 2.0, FLAGSHIP.control_period
    attitude_filter = AttitudeFilter(FLAGSHIP, Memory(1), time_constant)
    wrong, right = quaternion_from_rotation_vector(np.array([[0.01, 0.0, 0.0]])), np.array([[1.0, 0.0, 0.0, 0.0]])
    assert angle_between(attitude_filter.update(still(wrong, np.zeros((1, 3)))), wrong)[0] < 1e-12
    for step in range(1, 60):
        filtered = attitude_filter.update(still(right, np.zeros((1, 3))))
        expected = 0.01 * np.exp(-step * period / time_constant)
        assert angle_between(filtered, right)[0] == pytest.approx(expected, rel=1e-3)


def test_filter_of_time_zero_passes_through():
    attitude_filter, random = AttitudeFilter(FLAGSHIP, Memory(3), 0.0), np.random.default_rng(0)
    for _ in range(4):
        measured = noisy(np.tile([0.5, 0.5, 0.5, 0.5], (3, 1)), 0.1, random)
        np.testing.assert_array_equal(attitude_filter.update(still(measured, np.zeros((3, 3)))), measured)


def test_filter_reset_by_mask_starts_from_the_measurement():
    memory, random = Memory(2), np.random.default_rng(0)
    attitude_filter = AttitudeFilter(FLAGSHIP, memory, 5.0)
    for _ in range(10):
        attitude_filter.update(still(noisy(np.tile([1.0, 0, 0, 0], (2, 1)), 1e-3, random), np.zeros((2, 3))))
    memory.reset(np.array([True, False]))
    elsewhere = np.tile([np.cos(0.05), np.sin(0.05), 0.0, 0.0], (2, 1))
    filtered = attitude_filter.update(still(elsewhere, np.zeros((2, 3))))
    assert angle_between(filtered[0], elsewhere[0]) < 1e-12
    assert angle_between(filtered[1], elsewhere[1]) > 0.09
