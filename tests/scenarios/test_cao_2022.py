"""Cao, Gong and Han 2022: the published numbers reach the plant."""

import math

import numpy as np
import pytest
from helpers.rigid_spacecraft import flown, integrated

from ftac_gym import scenarios
from ftac_gym.dynamics import Simulator

SCENARIO = scenarios.get("cao_2022")
INERTIA = np.diag([36.0, 17.0, 26.0])


def effectiveness(time, probe):
    return np.array(
        [
            0.8 if probe >= 5.0 else 1.0,
            0.6 if probe >= 8.0 else 1.0,
            0.4 + 0.05 * math.cos(0.25 * time) if probe >= 10.0 else 1.0,
        ]
    )


def external(time, rate):
    waves = np.array([math.sin(0.8 * time), math.cos(0.5 * time), math.cos(0.3 * time)])
    return 0.01 * (rate @ rate + 0.05) * waves


def test_start_and_nominal_spacecraft():
    simulator = Simulator(SCENARIO, 1)
    simulator.reset(SCENARIO.draw(0, 1))
    attitude = simulator.state.attitude[0]
    np.testing.assert_allclose(attitude[1:] / (1.0 + attitude[0]), [0.3, -0.2, 0.2], atol=1e-15)
    assert not simulator.state.rate.any()
    np.testing.assert_array_equal(simulator.reference_attitude, [[1.0, 0.0, 0.0, 0.0]])
    assert not simulator.reference_rate.any() and not simulator.reference_acceleration.any()
    np.testing.assert_array_equal(SCENARIO.spacecraft.inertia_matrix, INERTIA)
    np.testing.assert_array_equal(SCENARIO.spacecraft.wheels.axis_matrix, np.eye(3))
    np.testing.assert_array_equal(SCENARIO.spacecraft.wheels.torque_limits, 20.0)
    assert not SCENARIO.spacecraft.wheels.momentum_coupling
    assert SCENARIO.inertia_uncertainty is None and SCENARIO.sensors is None
    assert SCENARIO.control_period == SCENARIO.physics_step == 0.01 and SCENARIO.duration == 40.0


def test_effectiveness_over_time():
    """The varying one is a cosine of the time of the episode, not of the time since its onset."""
    simulator = Simulator(SCENARIO, 1)
    simulator.reset(SCENARIO.draw(0, 1))
    for step in range(3000):
        time, truth = 0.01 * step, simulator.truth()
        np.testing.assert_allclose(truth.effectiveness[0], effectiveness(time, time + 1e-9), atol=1e-14)
        assert not truth.bias.any()
        simulator.step(np.zeros((1, 3)))


def test_the_plant_is_that_of_the_paper():
    """Through all three onsets, with commands beyond the limit."""
    steps = np.arange(1300)[:, None]
    commands = 25.0 * np.sin(0.01 * steps * [2.1, 1.4, 1.7] + [0.0, 1.0, 2.0])
    square = 0.17
    start = np.array([1.0 - square, 0.6, -0.4, 0.4, 0.0, 0.0, 0.0]) / (1.0 + square)

    def wheels(time, command, probe):
        return effectiveness(time, probe) * np.clip(command, -20.0, 20.0)

    states = integrated(start, commands, 0.01, lambda _: INERTIA, wheels, external)
    np.testing.assert_allclose(flown(SCENARIO, commands), states, atol=1e-8)
    assert np.linalg.norm(states[:, 4:], axis=1).max() > 1.0  # the part that grows with the rate is felt


@pytest.mark.parametrize("time", [0.0, 2.0, 7.7, 31.0])
def test_external_torque(time):
    steady, harmonics = SCENARIO.draw(0, 1).disturbance[0], SCENARIO.draw(0, 1).harmonics[0]
    rate = np.array([0.3, -0.2, 0.4])
    waves = sum(part["sine"] * np.sin(part["frequency"] * time) + part["cosine"] * np.cos(part["frequency"] * time)
                for part in harmonics)  # fmt: skip
    torque = (steady["constant"] + waves) * (rate @ rate + steady["rate_offset"])
    assert steady["rate_scaled"] == 1.0
    np.testing.assert_allclose(torque, external(time, rate), atol=1e-17)
