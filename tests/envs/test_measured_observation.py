"""Observations and rewards with sensors by data sheet: policies get what is measured, rewards are of the truth."""

import numpy as np
import pytest

from ftac_gym import scenarios
from ftac_gym.envs import SpacecraftFTCEnv, SpacecraftFTCVectorEnv
from ftac_gym.envs.observation import BOUND
from ftac_gym.task import Gyro, ModalTelemetry, SensorSuite, StarTracker, WheelTelemetry

NOISY = SensorSuite(
    star_tracker=StarTracker(rate=5.0, latency=0.15, cross_noise=6.0, boresight_noise=40.0),
    gyro=Gyro(angle_random_walk=0.01, bias=(-1.0, 1.0)), wheels=WheelTelemetry(noise=0.01, quantum=0.005),
    modes=ModalTelemetry(displacement_noise=1e-3, rate_noise=1e-3),
)  # fmt: skip
FLEXIBLE = scenarios.get("flexible").replace(sensors=NOISY)


@pytest.fixture(scope="module")
def flown():
    """The environment, its observation and its measurement after a few steps."""
    env = SpacecraftFTCVectorEnv(6, scenario=FLEXIBLE, observation="telemetry")
    env.reset(seed=0)
    for _ in range(7):
        observation = env.step(np.full((6, 4), 0.1, dtype=np.float32))[0]
    return env, observation, env.measurement()


def test_the_observed_wheel_momentum_is_the_measured_one(flown):
    env, observation, measured = flown
    limits = FLEXIBLE.spacecraft.wheels.momentum_limits
    seen = observation[:, env.observation_slices["wheel_momentum"]]
    np.testing.assert_allclose(seen, measured.wheel_momentum / limits, rtol=1e-6)
    true = env.batch.simulator.state.wheel_momentum
    assert np.abs(measured.wheel_momentum - true).max() > 1e-3
    steps = measured.wheel_momentum / 0.005
    np.testing.assert_allclose(steps, np.round(steps), rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("name", ["modal_displacement", "modal_rate"])
def test_the_observed_modes_are_the_measured_ones(flown, name):
    env, observation, measured = flown
    scale = dict(zip(("modal_displacement", "modal_rate"), env.batch.observer._modal_scales, strict=True))[name]
    seen = observation[:, env.observation_slices[name]]
    expected = np.clip(getattr(measured, name) / scale, -BOUND, BOUND)
    np.testing.assert_allclose(seen, expected, rtol=1e-6)
    assert not np.array_equal(getattr(measured, name), getattr(env.batch.simulator.state, name))


def test_rewards_and_errors_do_not_see_the_noise():
    quiet, noisy = (
        SpacecraftFTCEnv(FLEXIBLE.replace(sensors=sensors), observation="telemetry") for sensors in (None, NOISY)
    )
    for env in (quiet, noisy):
        env.reset(seed=3)
    for _ in range(10):
        (first, *judged), (second, *noted) = (env.step(np.full(4, 0.2)) for env in (quiet, noisy))
        assert judged[0] == noted[0] and not np.array_equal(first, second)
        assert judged[3]["attitude_error"] == noted[3]["attitude_error"]


def test_one_environment_observes_as_several_do():
    several = SpacecraftFTCVectorEnv(3, scenario=FLEXIBLE, observation="telemetry")
    singles = [SpacecraftFTCEnv(FLEXIBLE, observation="telemetry") for _ in range(3)]
    together, _ = several.reset(seed=5)
    alone = [env.reset(seed=5 + index)[0] for index, env in enumerate(singles)]
    np.testing.assert_array_equal(together, alone)
    action = np.random.default_rng(0).uniform(-0.3, 0.3, (12, 3, 4)).astype(np.float32)
    for commands in action:
        together = several.step(commands)[0]
        alone = [env.step(command)[0] for env, command in zip(singles, commands, strict=True)]
        np.testing.assert_array_equal(together, alone)
