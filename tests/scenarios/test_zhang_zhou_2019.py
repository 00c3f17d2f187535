"""Zhang and Zhou 2019: the printed numbers reach the plant, and the references need what the docstrings say."""

import math

import numpy as np
import pytest
from helpers.laws import Target
from helpers.rigid_spacecraft import flown, integrated

from ftac_gym import scenarios
from ftac_gym.dynamics import Simulator
from ftac_gym.reproduction.inverse_dynamics import peak_wheel_torque
from ftac_gym.task import Scenario

NAMES = [
    "zhang_zhou_2019",
    "zhang_zhou_2019_2nm",
    "zhang_zhou_2019_feasible",
    "zhang_zhou_2019_stabilisation",
]
PRINTED = scenarios.get("zhang_zhou_2019")
INERTIA = np.array([[30.0, 5.3, 6.4], [5.3, 27.0, 10.0], [6.4, 10.0, 19.0]])
AXES = np.array([[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1.0], [0.0, 0.0, 1.0, 1.0]]) / [1.0, 1.0, 1.0, math.sqrt(3.0)]
SIGMA, RATE = np.array([-0.8, 0.3, 0.5]), np.array([0.5, -0.6, 0.4])


def inertia(time):
    return INERTIA + np.diag([np.sin(0.1 * time), 2.0 * np.sin(0.2 * time), np.sin(0.3 * time)])


def external(time, rate):
    return 0.1 * np.array([np.sin(time) + 1.0, 3.0 * np.sin(time) + 1.0, 5.0 * np.sin(time) + 1.0])


def wheels(time, command, probe):
    tau = np.clip(command, -5.0, 5.0)
    if probe >= 10.0:
        tau = tau * [0.5, 1.0, 1.0, 1.0] + [0.0, 0.06, 0.0, 0.0]
    return AXES @ tau


@pytest.mark.parametrize("name", NAMES)
def test_nominal_spacecraft_and_timing(name):
    scenario = scenarios.get(name)
    spacecraft = scenario.spacecraft
    np.testing.assert_array_equal(spacecraft.inertia_matrix, INERTIA)
    np.testing.assert_allclose(spacecraft.wheels.axis_matrix, AXES, atol=1e-15)
    np.testing.assert_array_equal(spacecraft.wheels.torque_limits, 2.0 if name.endswith("2nm") else 5.0)
    assert not spacecraft.wheels.momentum_coupling and np.all(np.isinf(spacecraft.wheels.momentum_limits))
    assert scenario.sensors is None and scenario.tumble_rate is None
    assert scenario.control_period == scenario.physics_step == 0.01 and scenario.duration == 60.0


def test_no_body_has_this_inertia():
    moments = np.linalg.eigvalsh(INERTIA)
    np.testing.assert_allclose(moments, [11.9, 24.0, 40.2], atol=0.05)
    assert moments[2] - moments[0] - moments[1] == pytest.approx(4.3, abs=0.05)


def test_start():
    simulator = Simulator(PRINTED, 1)
    simulator.reset(PRINTED.draw(0, 1))
    attitude = simulator.state.attitude[0]
    np.testing.assert_allclose(attitude[1:] / (1.0 + attitude[0]), SIGMA, atol=1e-14)
    np.testing.assert_array_equal(simulator.state.rate[0], RATE)
    assert 2.0 * math.degrees(math.acos(abs(attitude[0]))) == pytest.approx(178.84, abs=0.01)


@pytest.mark.parametrize("name", NAMES)
def test_effectiveness_and_bias_over_time(name):
    scenario = scenarios.get(name)
    simulator = Simulator(scenario, 1)
    simulator.reset(scenario.draw(0, 1))
    seen = {}
    for _ in range(1200):
        seen[round(float(simulator.time[0]), 2)] = simulator.truth()
        simulator.step(np.zeros((1, 4)))
    for time in (0.0, 5.0, 9.98, 9.99):
        np.testing.assert_array_equal(seen[time].effectiveness, 1.0)
        np.testing.assert_array_equal(seen[time].bias, 0.0)
    for time in (10.0, 10.01, 11.5):
        np.testing.assert_array_equal(seen[time].effectiveness[0], [0.5, 1.0, 1.0, 1.0])
        np.testing.assert_array_equal(seen[time].bias[0], [0.0, 0.06, 0.0, 0.0])


def test_the_plant_is_that_of_the_paper():
    """Through the faults at 10 s, with commands beyond the limit."""
    steps = np.arange(1300)[:, None]
    commands = 6.0 * np.sin(0.01 * steps * [1.3, 0.9, 1.7, 0.7] + [0.0, 1.0, 2.0, 3.0])
    square = SIGMA @ SIGMA
    start = np.concatenate([[1.0 - square], 2.0 * SIGMA, (1.0 + square) * RATE]) / (1.0 + square)
    states = integrated(start, commands, 0.01, inertia, wheels, external)
    np.testing.assert_allclose(flown(PRINTED, commands), states, atol=1e-8)


@pytest.mark.parametrize(("name", "slowing"), [("zhang_zhou_2019", 1.0), ("zhang_zhou_2019_2nm", 1.0),
                                               ("zhang_zhou_2019_feasible", 0.2)])  # fmt: skip
def test_reference(name, slowing):
    scenario = scenarios.get(name)
    target = Target((0.3, 0.1, 0.2), np.array([1.0, 2.0, 1.0]) * slowing)
    simulator = Simulator(scenario, 1)
    simulator.reset(scenario.draw(0, 1))
    fastest = 0.0
    for step in range(800):
        attitude, rate, acceleration = target.body(0.01 * step)
        np.testing.assert_allclose(simulator.reference_attitude[0], attitude, atol=1e-13)
        np.testing.assert_allclose(simulator.reference_rate[0], rate, atol=1e-13)
        np.testing.assert_allclose(simulator.reference_acceleration[0], acceleration, atol=1e-12)
        fastest = max(fastest, np.linalg.norm(rate))
        simulator.step(np.zeros((1, 4)))
    assert fastest == pytest.approx(1.65 * slowing, rel=1e-3)


def test_stabilisation_is_at_rest():
    scenario = scenarios.get("zhang_zhou_2019_stabilisation")
    simulator = Simulator(scenario, 1)
    simulator.reset(scenario.draw(0, 1))
    for _ in range(100):
        np.testing.assert_array_equal(simulator.reference_attitude, [[1.0, 0.0, 0.0, 0.0]])
        assert not simulator.reference_rate.any() and not simulator.reference_acceleration.any()
        simulator.step(np.zeros((1, 4)))


@pytest.mark.parametrize(
    ("name", "minimax", "pseudo_inverse"),
    [
        ("zhang_zhou_2019", (32.5, 32.6, 47.7), (35.4, 35.5, 50.8)),
        ("zhang_zhou_2019_feasible", (1.30, 1.31, 1.92), (1.42, 1.43, 2.03)),
    ],
)
def test_needed_torque(name, minimax, pseudo_inverse):
    """The reference alone, with the external torque, and with the faults too: what the docstrings say."""
    scenario = scenarios.get(name)
    for allocation, expected in (("minimax", minimax), ("pseudo_inverse", pseudo_inverse)):
        for (disturbance, faults), peak in zip(((False, False), (True, False), (True, True)), expected, strict=True):
            needed = peak_wheel_torque(scenario, allocation, disturbance, faults)
            assert needed == pytest.approx(peak, abs=0.051 if peak > 10.0 else 0.0051)


def test_the_variants_differ_in_nothing_else():
    fields = ("spacecraft", "reference", "name")
    shared = [{key: value for key, value in scenarios.get(name).to_dict().items() if key not in fields}
              for name in NAMES]  # fmt: skip
    assert all(part == shared[0] for part in shared)
    assert [scenarios.get(name).reference == PRINTED.reference for name in NAMES] == [True, True, False, False]
    for name in NAMES:
        assert Scenario.from_json(scenarios.get(name).to_json()) == scenarios.get(name)
