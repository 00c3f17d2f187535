"""The Shen-class controller: within its limit whatever happens, never pushing along its own sliding variable."""

import numpy as np
import pytest
from helpers.observed import task

from ftac_gym import baselines, scenarios
from ftac_gym.attitude import angle_between, random_quaternion_from_uniforms
from ftac_gym.dynamics import Simulator
from ftac_gym.spacecraft.spacecraft import Spacecraft
from ftac_gym.spacecraft.wheel_array import WheelArray
from ftac_gym.task.measurement import Measurement

SHEN = scenarios.get("shen_2019")
AXES = SHEN.spacecraft.wheels.axis_matrix
LIMIT = 0.2  # N m


def states(count, size, seed=0, attitude=None):
    """Return a measurement of random attitudes, rates and last commands; the reference is the identity."""
    random = np.random.default_rng(seed)
    if attitude is None:
        attitude = random_quaternion_from_uniforms(random.random((count, 3)))
    identity, three, four = np.tile([1.0, 0, 0, 0], (count, 1)), np.zeros((count, 3)), np.zeros((count, 4))
    command = random.uniform(-LIMIT, LIMIT, (count, 4))
    rate = size * random.normal(size=(count, 3))
    return Measurement(np.zeros(count), attitude, rate, four, command, np.ones(count, bool), identity, three, three)


def fly(scenario, count, duration, **gains):
    simulator, law = Simulator(scenario, count), baselines.make("shen_class", scenario, count, **gains)
    simulator.reset(scenario.draw(0, count))
    errors, commands, bounds = [], [], []
    for _ in range(round(duration / scenario.control_period)):
        commands.append(law.act(simulator.measurement()))
        bounds.append(law.memory["torque_bound"].copy())
        simulator.step(commands[-1])
        errors.append(np.degrees(angle_between(simulator.state.attitude, simulator.reference_attitude)))
    return np.array(errors), np.array(commands), np.array(bounds)


@pytest.mark.parametrize("size", [1e-6, 1e-3, 0.1, 10.0])
@pytest.mark.parametrize("monitor_gain", [0.0, 5.0, 500.0])
def test_the_torque_opposes_the_surface_and_keeps_its_limit(monitor_gain, size):
    """u = -(u_max / e0) D^+ sat(S): |u| <= u_max, D u = -gain S, and the gain is never negative."""
    law = baselines.make("shen_class", SHEN, 50, monitor_gain=monitor_gain, monitor_threshold=0.0)
    largest = LIMIT / np.linalg.norm(np.linalg.pinv(AXES), 2)
    for step in range(5):
        measurement = states(50, size, step)
        variable, command = law.sliding_variable(measurement), law.act(measurement)
        assert (np.linalg.norm(command, axis=1) <= LIMIT * (1.0 + 1e-12)).all()
        torque = command @ AXES.T
        gain = -(torque * variable).sum(axis=1) / (variable**2).sum(axis=1)
        assert (gain >= 0.0).all()
        np.testing.assert_allclose(torque, -gain[:, None] * variable, atol=1e-12)
        assert (np.linalg.norm(torque, axis=1) <= largest * (1.0 + 1e-12)).all()


def test_sliding_variable_and_first_command_follow_the_formulas():
    random = np.random.default_rng(1)
    vector = 1e-4 * random.normal(size=(6, 3))
    attitude = np.column_stack([np.sqrt(1.0 - (vector**2).sum(axis=1)), vector])
    measurement = states(6, 1e-4, attitude=attitude)
    law = baselines.make("shen_class", SHEN, 6, monitor_threshold=1.0)
    variable = measurement.rate + 0.2 * np.arctan(1.8 * vector)
    np.testing.assert_allclose(law.sliding_variable(measurement), variable, atol=1e-15)
    torque = law.act(measurement) @ AXES.T
    np.testing.assert_allclose(torque, -100.0 * variable, rtol=1e-9)  # eta = k while h^ and f^ are zero
    speed = np.linalg.norm(measurement.rate, axis=1, keepdims=True)
    growth, length = 1.0 + speed + speed**2, np.linalg.norm(variable, axis=1, keepdims=True)
    expected = 0.1 * 0.1 * growth * length**2 / (length + 0.01 / growth)
    np.testing.assert_allclose(law.memory["torque_bound"], expected, rtol=1e-12)
    torque = law.act(states(6, 1e-4, attitude=attitude)) @ AXES.T
    eta = 100.0 + expected * growth / (length + 0.01 / growth)
    np.testing.assert_allclose(torque, -eta * variable, rtol=1e-6)


def test_the_bound_forgets_and_stays_positive():
    law, measurement = baselines.make("shen_class", SHEN, 4, forgetting=0.5), states(4, 0.05)
    for _ in range(50):
        law.act(measurement)
    high = law.memory["torque_bound"].copy()
    still = states(4, 0.0, attitude=np.tile([1.0, 0, 0, 0], (4, 1)))
    law.act(still)
    np.testing.assert_allclose(law.memory["torque_bound"], high * (1.0 - 0.05), rtol=1e-12)
    assert (high > 0.0).all()
    np.testing.assert_array_equal(law.act(still), 0.0)


def test_nothing_but_the_monitor_needs_the_inertia():
    other = SHEN.replace(spacecraft=Spacecraft(np.diag([30.0, 31.0, 32.0]), SHEN.spacecraft.wheels))
    for monitor_gain, same in ((0.0, True), (5.0, False)):
        gains = {"monitor_gain": monitor_gain, "monitor_threshold": 0.0}
        laws = [baselines.make("shen_class", scenario, 5, **gains) for scenario in (SHEN, other)]
        equal = []
        for step in range(4):
            measurement = states(5, 1e-4, step, attitude=np.tile([1.0, 0, 0, 0], (5, 1)))
            commands = [law.act(measurement) for law in laws]
            equal.append(np.array_equal(*commands))
        assert all(equal) == same


def test_the_monitor_speaks_above_its_threshold_only():
    """One sample after a jump of the rate that the model does not explain."""
    attitude = np.tile([1.0, 0, 0, 0], (1, 1))
    quiet, jump = states(1, 0.0, attitude=attitude), 3e-3
    zero = np.zeros((1, 4))
    quiet = Measurement(**{**vars(quiet), "last_command": zero, "command_in_effect": zero})
    jumped = Measurement(**{**vars(quiet), "rate": np.array([[jump, 0.0, 0.0]])})
    commands = {}
    for threshold in (0.9 * jump, 1.1 * jump):
        law = baselines.make("shen_class", SHEN, monitor_threshold=threshold, adaptation=0.0, gain=1.0)
        law.act(quiet)
        commands[threshold] = law.act(jumped) @ AXES.T
    np.testing.assert_allclose(commands[1.1 * jump], [[-jump, 0.0, 0.0]], atol=1e-12)
    # f^ = L (w - w^), along S: eta = k + S'f^ / (|S|^2 + e1^2)
    eta = 1.0 + jump * 5.0 * jump / (jump**2 + 0.1**2)
    np.testing.assert_allclose(commands[0.9 * jump], [[-eta * jump, 0.0, 0.0]], rtol=1e-4)


def test_settles_its_own_scenario():
    errors, commands, bounds = fly(SHEN, 2, 200.0)
    assert errors[0].min() > 60.0
    assert errors[800:].max() < 1.0  # 80 s on, with losses, biases and noise
    assert (np.linalg.norm(commands, axis=2) <= LIMIT * (1.0 + 1e-12)).all()
    assert (bounds >= 0.0).all()


@pytest.mark.parametrize(
    ("gains", "message"),
    [
        ({"surface_gain": 0.0}, "surface_gain must be positive"),
        ({"surface_steepness": -1.0}, "surface_steepness must be positive"),
        ({"gain": 0.0}, "gain must be positive"),
        ({"regularisation": 0.0}, "regularisation must be positive"),
        ({"smoothing": 0.0}, "smoothing must be positive"),
        ({"forgetting": -1.0}, "forgetting must not be negative"),
        ({"adaptation": -1.0}, "adaptation must not be negative"),
        ({"monitor_gain": -1.0}, "monitor_gain must not be negative"),
        ({"monitor_threshold": -1.0}, "monitor_threshold must not be negative"),
    ],
)
def test_bad_gains(gains, message):
    with pytest.raises(ValueError, match=f"^shen_class: {message}"):
        baselines.make("shen_class", SHEN, **gains)


def test_every_wheel_needs_a_torque_limit():
    unlimited = task(3, 0.1, None, spacecraft=Spacecraft(np.eye(3), WheelArray(np.eye(3), None)))
    with pytest.raises(ValueError, match=r"^shen_class: torque_limit must be finite for every wheel"):
        baselines.make("shen_class", unlimited)
