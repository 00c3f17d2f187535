"""Ma, Wang and Wang 2023: the published numbers reach the plant."""

import math

import gymnasium as gym
import numpy as np
import pytest
from helpers.hybrid_laws import RateTarget
from helpers.rigid_spacecraft import flown, integrated

from ftac_gym import scenarios
from ftac_gym.attitude import rotation_matrix
from ftac_gym.dynamics import Simulator

FAULTY, UNWINDING = scenarios.get("ma_2023_faulty"), scenarios.get("ma_2023_unwinding")
BOTH = pytest.mark.parametrize("scenario", [FAULTY, UNWINDING], ids=["faulty", "unwinding"])
INERTIA = np.array([[22.0, 1.2, 0.9], [1.2, 19.0, 1.4], [0.9, 1.4, 18.0]])  # kg m^2
RATE = [0.06, -0.04, 0.05]  # rad/s
VECTOR = [0.3, -0.2, -0.3]
STARTS = {"ma_2023_faulty": math.sqrt(0.78), "ma_2023_unwinding": -math.sqrt(0.78)}


def effectiveness(time):
    """diag of Gamma, section 5.1."""
    return np.array(
        [0.5 + 0.01 * math.sin(10 * time), 0.5 + 0.02 * math.cos(20 * time), 0.5 + 0.03 * math.sin(30 * time)]
    )


def external(time, _):
    return np.array([0.1 * math.sin(time), 0.2 * math.sin(1.2 * time), 0.3 * math.sin(1.5 * time)])


def started(scenario):
    simulator = Simulator(scenario, 1)
    simulator.reset(scenario.draw(0, 1))
    return simulator


@BOTH
def test_start_and_nominal_spacecraft(scenario):
    state = started(scenario).state
    np.testing.assert_allclose(state.attitude[0], [STARTS[scenario.name], *VECTOR], rtol=0.0, atol=1e-15)
    assert abs(np.linalg.norm(state.attitude[0]) - 1.0) < 1e-15  # 0.8832 is not a unit quaternion
    assert abs(state.attitude[0, 0]) == pytest.approx(0.8832, abs=5e-5)
    np.testing.assert_array_equal(state.rate[0], RATE)
    spacecraft = scenario.spacecraft
    np.testing.assert_array_equal(spacecraft.inertia_matrix, INERTIA)
    np.testing.assert_array_equal(spacecraft.wheels.axis_matrix, np.eye(3))
    np.testing.assert_array_equal(spacecraft.wheels.torque_limits, 10.0)
    assert not np.isfinite(spacecraft.wheels.momentum_limits).any() and not spacecraft.wheels.momentum_coupling
    assert scenario.inertia_uncertainty is None and scenario.sensors is None
    assert scenario.control_period == scenario.physics_step == 0.01 and scenario.duration == 60.0


def test_the_second_start_is_the_inverse_rotation_of_the_first():
    first, second = (started(scenario).state.attitude[0] for scenario in (FAULTY, UNWINDING))
    np.testing.assert_allclose(rotation_matrix(second), rotation_matrix(first).T, atol=1e-15)
    assert np.abs(rotation_matrix(second) - rotation_matrix(first)).max() > 0.5  # and not the same attitude


@BOTH
def test_the_reference_turns_as_printed(scenario):
    """At a few moments of the whole episode; q_d from Eq. (7), integrated by SciPy, in its first ten seconds."""
    simulator, f = started(scenario), math.pi / 100.0
    target = RateTarget((0.05, 0.05, 0.05), (f, 2.0 * f, 3.0 * f))
    np.testing.assert_array_equal(simulator.reference_attitude, [[1.0, 0.0, 0.0, 0.0]])
    for step in range(5801):
        if step % 400 == 0:
            time = 0.01 * step
            rate = [0.05 * math.sin(factor * f * time) for factor in (1, 2, 3)]
            change = [0.05 * factor * f * math.cos(factor * f * time) for factor in (1, 2, 3)]
            np.testing.assert_allclose(simulator.reference_rate[0], rate, rtol=0.0, atol=1e-14)
            np.testing.assert_allclose(simulator.reference_acceleration[0], change, rtol=0.0, atol=1e-14)
            if time <= 10.0:
                np.testing.assert_allclose(simulator.reference_attitude[0], target.body(time)[0], rtol=0.0, atol=1e-11)
        simulator.step(np.zeros((1, 3)))


@BOTH
def test_effectiveness_over_time(scenario):
    simulator = started(scenario)
    for step in range(300):
        truth = simulator.truth()
        expected = effectiveness(0.01 * step) if scenario is FAULTY else np.ones(3)
        np.testing.assert_allclose(truth.effectiveness[0], expected, atol=1e-14)
        assert not truth.bias.any()
        simulator.step(np.zeros((1, 3)))


@BOTH
def test_the_plant_is_that_of_the_paper(scenario):
    """J w' = -w x J w + Gamma sat(u) + d, with commands beyond the limit."""
    steps = np.arange(200)[:, None]
    commands = 16.0 * np.sin(0.01 * steps * [2.1, 1.4, 1.7] + [0.0, 1.0, 2.0])
    assert 0.1 < (np.abs(commands) > 10.0).mean() < 0.9

    def wheels(time, command, probe):
        share = effectiveness(time) if scenario is FAULTY else 1.0
        return share * np.clip(command, -10.0, 10.0)

    start = [STARTS[scenario.name], *VECTOR, *RATE]
    states = integrated(start, commands, 0.01, lambda _: INERTIA, wheels, external)
    np.testing.assert_allclose(flown(scenario, commands), states, rtol=0.0, atol=1e-8)
    assert np.linalg.norm(states[:, 4:], axis=1).max() > 0.3


@pytest.mark.parametrize("time", [0.0, 2.0, 7.7, 31.0])
@BOTH
def test_external_torque(scenario, time):
    episodes = scenario.draw(0, 1)
    torque = episodes.disturbance[0]["constant"] + sum(
        part["sine"] * np.sin(part["frequency"] * time) + part["cosine"] * np.cos(part["frequency"] * time)
        for part in episodes.harmonics[0]
    )
    np.testing.assert_allclose(torque, external(time, None), rtol=0.0, atol=1e-16)
    assert episodes.disturbance[0]["rate_scaled"] == 0.0


def test_it_is_an_environment():
    env = gym.make("SpacecraftFTCMa2023-v0")
    observation, _ = env.reset(seed=0)
    assert env.observation_space.contains(observation) and env.action_space.shape == (3,)
    observation, reward, *_ = env.step(np.zeros(3, dtype=env.action_space.dtype))
    assert env.observation_space.contains(observation) and np.isfinite(reward)
    env.close()


def test_it_is_a_vector_environment():
    envs = gym.make_vec("SpacecraftFTCMa2023-v0", num_envs=3)
    observations, _ = envs.reset(seed=0)
    assert envs.observation_space.contains(observations) and len(observations) == 3
    observations, rewards, *_ = envs.step(np.zeros(envs.action_space.shape, dtype=envs.action_space.dtype))
    assert envs.observation_space.contains(observations) and np.isfinite(rewards).all()
    envs.close()
