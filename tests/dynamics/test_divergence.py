"""Divergence of the plant: an error in place of numbers that are not those of a body."""

import pickle

import gymnasium as gym
import numpy as np
import pytest
from helpers.flexible_spacecraft import flexible_scenario, random_appendages

import ftac_gym
from ftac_gym import scenarios
from ftac_gym.dynamics import DivergenceError, Simulator
from ftac_gym.envs import SpacecraftFTCVectorEnv
from ftac_gym.faults import FaultSchedule, StarTrackerOutage
from ftac_gym.spacecraft import Spacecraft, WheelArray
from ftac_gym.task import Scenario, SensorErrors

FLAGSHIP = scenarios.get("flagship")
SPINNING = Scenario(name="spinning", spacecraft=Spacecraft(np.eye(3), WheelArray(np.eye(3), 1.0)))
"""A body that its wheels, which have no momentum limit, can spin up without end."""


def started(scenario=FLAGSHIP, count=5):
    simulator = Simulator(scenario, count)
    simulator.reset(scenario.draw(0, count))
    return simulator


def step(simulator):
    simulator.step(np.zeros_like(simulator.last_command))


def fly(env, action, steps):
    for _ in range(steps):
        observation, reward, *_ = env.step(action)
        assert np.isfinite(observation).all() and np.isfinite(reward).all()


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize(
    ("name", "said"),
    [("rate", "rate"), ("attitude", "attitude"), ("wheel_momentum", "(wheel_momentum|rate)"), ("motor_torque", None)],
)
def test_the_error_names_spacecraft_time_and_quantity(name, said, value):
    simulator = started()
    for _ in range(123):
        step(simulator)
    getattr(simulator.state, name)[3, 1] = value
    if said is None:  # Of an ideal wheel: without meaning.
        step(simulator)
        return
    message = rf"^{said} must stay finite, got (nan|-?inf) on spacecraft 3 at 12\.4 s; "
    with pytest.raises(DivergenceError, match=message) as caught:
        step(simulator)
    assert caught.value.spacecraft == (3,)
    assert len(str(caught.value)) < 300 and "\n" not in str(caught.value)


@pytest.mark.parametrize("sensors", [FLAGSHIP.sensors, SensorErrors(attitude_noise=1e-5), None])
def test_an_attitude_that_no_star_tracker_sees(sensors):
    outage = FaultSchedule((StarTrackerOutage(onset=0.0, duration=60.0),))
    simulator = started(FLAGSHIP.replace(sensors=sensors, faults=outage))
    step(simulator)
    simulator.state.attitude[2, 0] = np.nan
    with pytest.raises(DivergenceError, match=r"^attitude must stay finite, got nan on spacecraft 2 at 0\.2 s; "):
        step(simulator)


@pytest.mark.parametrize("name", ["modal_displacement", "modal_rate"])
def test_modes_are_named_as_the_cause(name):
    simulator = started(flexible_scenario(random_appendages(2)))
    getattr(simulator.state, name)[1, 0] = np.nan
    with pytest.raises(DivergenceError, match=r"^modal_\w+ must stay finite, got nan on spacecraft 1 at 0\.1 s"):
        step(simulator)


def test_a_rate_too_fast_for_the_step_is_an_error_although_it_is_finite():
    simulator = started()
    simulator.state.rate[2] = 300.0, 0.0, 0.0
    simulator.state.rate[4] = 0.0, 60.0, 0.0
    with pytest.raises(DivergenceError, match=r"^rate must stay below 50 rad/s .* on spacecraft 2 and 1 more at 0\.1"):
        step(simulator)


def test_an_infinite_measurement_is_named():
    simulator = started()
    simulator._episodes.sensors["angle_random_walk"][1] = np.inf
    with pytest.raises(DivergenceError, match=r"^measured_rate must stay finite, got -?(inf|nan) on spacecraft 1 at"):
        step(simulator)


def test_a_policy_that_pushes_without_end_meets_the_error_in_every_environment():
    single = gym.make("SpacecraftFTC-v0", scenario=SPINNING)
    vector = gym.make_vec("SpacecraftFTC-v0", num_envs=2, scenario=SPINNING)
    for env, action in ((single, np.ones(3)), (vector, np.ones((2, 3)))):
        env.reset(seed=0)
        with pytest.raises(ftac_gym.DivergenceError, match="rate must stay below 50 rad/s"):
            fly(env, action, SPINNING.horizon)


@pytest.mark.parametrize("tier", ["attitude", "telemetry", "oracle"])
def test_a_reset_frees_the_spacecraft_and_the_others_go_on_as_if_nothing_had_been(tier):
    """The corrected one flies its next episode, the others the rest of theirs: to the bit."""
    envs = [SpacecraftFTCVectorEnv(3, observation=tier, autoreset_mode="Disabled") for _ in range(2)]
    sick, sound = envs
    rng = np.random.default_rng(0)
    for env in envs:
        env.reset(seed=7)
    for index in range(30):
        action = rng.uniform(-1.0, 1.0, (3, 4))
        if index == 10:
            sick.batch.simulator.state.rate[1] = np.nan
            with pytest.raises(DivergenceError, match="on spacecraft 1 at"):
                sick.step(action)
            with pytest.raises(DivergenceError, match="on spacecraft 1 at"):
                sick.step(action)
            for _ in range(2):
                sound.step(action)
            mask = {"reset_mask": np.array([False, True, False])}
            first, second = (env.reset(options=mask)[0] for env in envs)
            np.testing.assert_array_equal(first[1], second[1])
        first, second = (env.step(action) for env in envs)
        for one, other in zip(first[:4], second[:4], strict=True):
            np.testing.assert_array_equal(one, other)


def test_the_error_survives_a_process():
    simulator = started()
    simulator.state.rate[0] = np.nan
    with pytest.raises(DivergenceError) as caught:
        step(simulator)
    copy = pickle.loads(pickle.dumps(caught.value))
    assert str(copy) == str(caught.value) and copy.spacecraft == (0,)
