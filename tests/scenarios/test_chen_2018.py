"""Chen, Chen, He and Sun 2018: the published numbers reach the plant."""

import math

import gymnasium as gym
import numpy as np
import pytest
from helpers.rigid_spacecraft import flown, integrated

import ftac_gym  # noqa: F401  (registers the environments)
from ftac_gym import scenarios
from ftac_gym.dynamics import Simulator
from ftac_gym.task import Scenario

NAMES = {"chen_2018": False, "chen_2018_rate_torque": True}
PRINTED = scenarios.get("chen_2018")
INERTIA = np.array([[350.0, 3.0, 4.0], [3.0, 270.0, 10.0], [4.0, 10.0, 192.0]])
SIGMA = np.array([-0.3, -0.4, 0.2])


def inertia(time):
    return INERTIA + np.diag([5.0 * math.sin(0.1 * time), 7.0 * math.sin(0.2 * time), 9.0 * math.sin(0.3 * time)])


def inertia_rate(time):
    return np.diag([0.5 * math.cos(0.1 * time), 1.4 * math.cos(0.2 * time), 2.7 * math.cos(0.3 * time)])


def effectiveness(time, probe):
    return np.array(
        [
            0.2 + 0.1 * math.sin(0.2 * math.pi * time) if probe >= 15.0 else 1.0,
            0.2 + 0.1 * math.sin(0.3 * math.pi * time) if probe >= 12.0 else 1.0,
            0.2 + 0.1 * math.sin(0.4 * math.pi * time) if probe >= 10.0 else 1.0,
        ]
    )


def external(time, rate):
    return (rate @ rate + 0.05) * np.array([math.sin(0.8 * time), math.cos(0.5 * time), math.sin(0.3 * time)])


def start():
    square = SIGMA @ SIGMA
    return np.concatenate([[1.0 - square], 2.0 * SIGMA, np.zeros(3)]) / (1.0 + square)


@pytest.mark.parametrize("name", NAMES)
def test_start_and_nominal_spacecraft(name):
    scenario = scenarios.get(name)
    simulator = Simulator(scenario, 1)
    simulator.reset(scenario.draw(0, 1))
    np.testing.assert_allclose(simulator.state.attitude[0], start()[:4], atol=1e-15)
    assert not simulator.state.rate.any()
    np.testing.assert_array_equal(simulator.reference_attitude, [[1.0, 0.0, 0.0, 0.0]])
    assert not simulator.reference_rate.any() and not simulator.reference_acceleration.any()
    wheels = scenario.spacecraft.wheels
    np.testing.assert_array_equal(scenario.spacecraft.inertia_matrix, INERTIA)
    np.testing.assert_array_equal(wheels.axis_matrix, np.eye(3))
    np.testing.assert_array_equal(wheels.torque_limits, 8.0)
    assert np.all(np.isinf(wheels.momentum_limits)) and not wheels.momentum_coupling
    assert scenario.sensors is None and scenario.tumble_rate is None
    assert scenario.control_period == scenario.physics_step == 0.005 and scenario.duration == 60.0


def test_effectiveness_over_time():
    """Sines of the time of the episode, not of the time since the onsets; healthy before."""
    simulator = Simulator(PRINTED.replace(control_period=0.05), 1)
    simulator.reset(PRINTED.draw(0, 1))
    onsets = np.zeros(3)
    for step in range(500):
        time, truth = 0.05 * step, simulator.truth()
        np.testing.assert_allclose(truth.effectiveness[0], effectiveness(time, time + 1e-9), atol=1e-13)
        assert not truth.bias.any()
        onsets = np.where((truth.effectiveness[0] < 1.0) & (onsets == 0.0), time, onsets)
        simulator.step(np.zeros((1, 3)))
    np.testing.assert_allclose(onsets, [15.0, 12.0, 10.0], atol=1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_the_plant_is_that_of_the_paper(name):
    """Through all onsets, with commands beyond the limit; with -J' w in the one scenario and without in the other."""
    scenario = scenarios.get(name).replace(control_period=0.1)  # twenty physics steps as they are
    steps = np.arange(165)[:, None]
    commands = 12.0 * np.sin(0.1 * steps * [0.5, 0.4, 0.6] + [0.0, 1.0, 2.0])

    def wheels(time, command, probe):
        return effectiveness(time, probe) * np.clip(command, -8.0, 8.0)

    def torque(time, rate):
        return external(time, rate) - (inertia_rate(time) @ rate if NAMES[name] else 0.0)

    states, seen = integrated(start(), commands, 0.1, inertia, wheels, torque), flown(scenario, commands)
    np.testing.assert_allclose(seen, states, atol=1e-10)
    assert np.linalg.norm(states[:, 4:], axis=1).max() > 0.1
    other = next(key for key in NAMES if key != name)
    assert np.abs(flown(scenarios.get(other).replace(control_period=0.1), commands) - states).max() > 1e-3


@pytest.mark.parametrize("time", [0.0, 2.0, 7.7, 31.0])
def test_external_torque_and_inertia(time):
    episodes = PRINTED.draw(0, 1)
    steady, harmonics, body = episodes.disturbance[0], episodes.harmonics[0], episodes.inertia[0]
    rate = np.array([0.3, -0.2, 0.4])
    waves = sum(part["sine"] * np.sin(part["frequency"] * time) + part["cosine"] * np.cos(part["frequency"] * time)
                for part in harmonics)  # fmt: skip
    torque = (steady["constant"] + waves) * (rate @ rate + steady["rate_offset"])
    assert steady["rate_scaled"] == 1.0
    np.testing.assert_allclose(torque, external(time, rate), atol=1e-15)
    varying = np.diag(body["amplitude"] * np.sin(body["frequency"] * time + body["phase"]))
    np.testing.assert_allclose(body["constant"] + varying, inertia(time), atol=1e-12)


def test_the_bound_is_that_of_table_1():
    """q/p and b/a as the final factors; the bounds fit sigma(0) and no other choice of its signs."""
    bound = PRINTED.prescribed_bound
    p, q, a, b = (5.0,) * 3, (1.0, 1.0, 4.0), (5.0,) * 3, (4.0, 5.0, 1.0)
    np.testing.assert_allclose(bound.upper, np.divide(q, p), rtol=1e-15)
    np.testing.assert_allclose(bound.lower, np.divide(b, a), rtol=1e-15)
    assert (bound.initial, bound.final, bound.decay, bound.factor_decay) == (0.5, 0.001, 0.1, 5.0)
    final = PRINTED.replace(prescribed_bound={**PRINTED.to_dict()["prescribed_bound"], "initial_factor": None})
    constant = final.prescribed_bound
    assert constant.margin(SIGMA, 0.0).min() > 0.0
    assert (constant.margin(-SIGMA, 0.0) < 0.0).all()
    # The signs (-, -, +) are the only ones that the bounds of Table 1 hold.
    for signs in np.ndindex(2, 2, 2):
        mirrored = np.abs(SIGMA) * (2.0 * np.array(signs) - 1.0)
        assert (constant.margin(mirrored, 0.0).min() > 0.0) == (signs == (0, 0, 1))
    # With delta(0) finite, both are held at the start, but -sigma(0) not for half a second.
    times = np.array([0.0, 0.5])
    assert bound.margin(SIGMA, times).min() > 0.0 and bound.margin(-SIGMA, 0.0).min() > 0.0
    assert bound.margin(-SIGMA, 0.5).min() < 0.0


def test_the_variant_differs_in_nothing_else():
    plain = {name: scenarios.get(name).to_dict() for name in NAMES}
    for name, data in plain.items():
        assert data.pop("name") == name
        assert data["inertia_uncertainty"].pop("rate_torque") == NAMES[name]
        assert Scenario.from_json(scenarios.get(name).to_json()) == scenarios.get(name)
    assert plain["chen_2018"] == plain["chen_2018_rate_torque"]


def test_environments_can_be_made():
    env = gym.make("SpacecraftFTCChen2018-v0")
    assert env.unwrapped.scenario == PRINTED
    observation, _ = env.reset(seed=0)
    assert env.observation_space.contains(observation) and env.action_space.shape == (3,)
    attitude = env.unwrapped.measurement().attitude[0]
    np.testing.assert_allclose(attitude[1:] / (1.0 + attitude[0]), SIGMA, atol=1e-15)
    env.step(np.zeros(3))
    env.close()
    vector = gym.make_vec("SpacecraftFTCChen2018-v0", num_envs=3)
    assert vector.unwrapped.scenario == PRINTED and vector.num_envs == 3
    observations, _ = vector.reset(seed=0)
    assert vector.observation_space.contains(observations)
    vector.step(np.zeros((3, 3)))
    vector.close()
    slow = gym.make("SpacecraftFTCChen2018-v0", scenario="chen_2018_rate_torque")
    assert slow.unwrapped.scenario == scenarios.get("chen_2018_rate_torque")
    slow.close()
