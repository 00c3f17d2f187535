"""The tachometer: it reads off what each wheel does beyond its command, and laws on it come close to an oracle."""

import numpy as np
import pytest

from ftac_gym import baselines, scenarios
from ftac_gym.baselines import observers
from ftac_gym.baselines.memory import Memory
from ftac_gym.dynamics import Simulator
from ftac_gym.evaluation import rollout
from ftac_gym.faults import Bias, FaultSchedule, LossOfEffectiveness
from ftac_gym.policies import DeferredBaseline
from ftac_gym.task.initial_state import InitialState

QUIET = scenarios.get("flagship").replace(
    sensors=None, inertia_uncertainty=None, disturbance=None, initial_state=InitialState.fixed(), duration=10.0
)
BIAS, WEAK = 0.03, 0.4  # N m, share


def estimates(faults, bandwidth, command, delay, steps=60):
    """Return the estimates (steps, m) under a constant command that takes effect after a loop delay."""
    scenario = QUIET.replace(faults=FaultSchedule(faults), loop_delay=delay)
    simulator = Simulator(scenario, 1)
    simulator.reset(scenario.draw(0, 1))
    observer = observers.make("tachometer", scenario, Memory(1), bandwidth=bandwidth * (0.1 + delay))
    found = []
    for _ in range(steps):
        measurement = simulator.measurement()
        found.append(observer.update(measurement, measurement.command_in_effect, 0.1).bias[0])
        simulator.step(command)
    return np.array(found)


@pytest.mark.parametrize("bandwidth", [1.0, 10.0])
@pytest.mark.parametrize("late", [0, 1, 3])
def test_it_converges_to_what_each_wheel_does_uncommanded_with_its_time_constant(bandwidth, late):
    """A bias acts at once, and the loss of effectiveness with the first command that takes effect."""
    command = np.array([[0.02, -0.01, 0.015, -0.02]])
    faults = (Bias(wheel=1, onset=0.0, constant=BIAS), LossOfEffectiveness(wheel=2, onset=0.0, effectiveness=WEAK))
    found = estimates(faults, bandwidth, command, 0.1 * late)
    periods = np.arange(len(found))[:, None] - late * np.array([0, 0, 1, 0])
    shares = 1.0 - np.exp(-bandwidth * 0.1 * np.maximum(periods, 0))
    np.testing.assert_allclose(found, shares * [0.0, BIAS, (WEAK - 1.0) * command[0, 2], 0.0], atol=1e-9)


def test_a_law_with_it_says_that_it_needs_telemetry():
    for name in ("nftsm_telemetry", "predefined_time_telemetry"):
        assert baselines.make(name, QUIET).information == "telemetry"
    assert baselines.make("nftsm_observer", QUIET).information == "attitude"


def test_it_takes_a_bias_away_that_pushes_the_blind_law_off():
    scenario = QUIET.replace(faults=FaultSchedule((Bias(wheel=0, onset=1.0, constant=0.05),)), duration=40.0)
    episodes = scenario.draw(0, 1)
    gains = {"rate_gain": 0.4, "reaching_linear": 0.1}
    blind, told, oracle = (
        rollout(scenario, DeferredBaseline(name, **gains), episodes).metrics()["final_error"][0]
        for name in ("nftsm", "nftsm_telemetry", "nftsm_oracle")
    )
    assert told < 0.05 * blind and told == pytest.approx(oracle, abs=1e-4)


def test_bad_bandwidth():
    with pytest.raises(ValueError, match="bandwidth must be positive, got 0"):
        observers.make("tachometer", QUIET, Memory(1), bandwidth=0.0)
