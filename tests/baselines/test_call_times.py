"""Baselines that are called at other times than once per control period: refused, or without any effect."""

import pickle

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.wrappers import MaxAndSkipObservation, RescaleAction
from helpers.custom_baseline import CustomBaseline
from stable_baselines3.common.vec_env import DummyVecEnv

from ftac_gym import baselines, scenarios
from ftac_gym.dynamics import Simulator
from ftac_gym.envs import SpacecraftFTCEnv, SpacecraftFTCVectorEnv
from ftac_gym.wrappers import (
    ActionHold,
    FaultEstimateObservation,
    GainScheduling,
    ObservationHistory,
    ResidualPolicy,
    SB3VecEnv,
)

TASK = scenarios.get("flagship").replace(duration=6.0)
LATE = r"since the last call of \w+ must be its control period, 0\.1 s: .*, got 0\.4 s for spacecraft 0"


def single():
    return SpacecraftFTCEnv(scenario=TASK)


def skipping(kind):
    """Return an environment that steps four control periods at a time."""
    if kind == "ActionHold":
        return ActionHold(single(), 4)
    if kind == "MaxAndSkipObservation":
        return MaxAndSkipObservation(single(), 4)
    return SB3VecEnv(SpacecraftFTCVectorEnv(3, scenario=TASK, autoreset_mode="SameStep"), hold=4)


@pytest.mark.parametrize("base", ["pd", "pd_dob", CustomBaseline])
@pytest.mark.parametrize("kind", ["ActionHold", "MaxAndSkipObservation", "SB3VecEnv"])
def test_a_baseline_outside_of_what_holds_its_actions_is_refused(kind, base):
    env = skipping(kind)
    policy = baselines.make(base, TASK, getattr(env, "num_envs", 1)).as_policy(env)
    observation = env.reset() if kind == "SB3VecEnv" else env.reset(seed=0)[0]
    observation, *_ = env.step(policy.predict(observation)[0])
    with pytest.raises(ValueError, match=LATE) as error:
        policy.predict(observation)
    assert "\n" not in str(error.value) and len(str(error.value)) <= 500


@pytest.mark.parametrize("wrap", [ResidualPolicy, ObservationHistory, lambda env: FaultEstimateObservation(env, "dob")])
def test_a_wrapper_outside_of_what_skips_steps_is_refused(wrap):
    env = wrap(MaxAndSkipObservation(single(), 4))
    env.reset(seed=0)
    with pytest.raises(ValueError, match=LATE):
        env.step(np.zeros(4))
    with pytest.raises(ValueError, match="must not hold its actions yet"):
        wrap(ActionHold(single(), 4))


def test_the_base_of_a_residual_runs_once_per_control_period_inside_of_a_hold():
    held, plain = ActionHold(ResidualPolicy(single()), 4), single()
    policy = baselines.make("pd_dob", TASK).as_policy(plain)
    observation, expected = held.reset(seed=3)[0], plain.reset(seed=3)[0]
    for _ in range(10):
        for _ in range(4):
            expected, *_ = plain.step(policy.predict(expected)[0])
        observation, *_ = held.step(np.zeros(4))
        np.testing.assert_array_equal(observation[: len(expected)], expected)


@pytest.mark.parametrize("kind", ["too seldom", "too often", "back", "without a reset"])
def test_act_is_refused_at_other_times_too(kind):
    law, simulator = baselines.make("pd_dob", TASK, 2), Simulator(TASK, 2)
    simulator.reset(TASK.draw(0, 2))
    past = [simulator.measurement()]
    for _ in range(3):
        simulator.step(law.act(past[-1]))
        past.append(simulator.measurement())
    if kind == "too seldom":
        simulator.step(np.zeros((2, 4)))
        wrong, elapsed = simulator.measurement(), "0.2"
    elif kind == "too often":
        fine = Simulator(TASK.replace(control_period=0.02), 2)
        fine.reset(TASK.replace(control_period=0.02).draw(0, 2))
        law.reset()
        law.act(fine.measurement())
        fine.step(np.zeros((2, 4)))
        wrong, elapsed = fine.measurement(), "0.02"
    elif kind == "back":
        wrong, elapsed = past[0], "-0.2"
    else:
        simulator.reset(TASK.draw(1, 2))
        wrong, elapsed = simulator.measurement(), "-0.2"
    with pytest.raises(ValueError, match=rf"its control period, 0\.1 s: .*, got {elapsed} s for spacecraft 0"):
        law.act(wrong)
    law.reset()
    assert np.isfinite(law.act(wrong)).all()


@pytest.mark.parametrize("name", ["pd_dob", "nftsm_observer"])
def test_a_second_call_at_the_same_time_changes_nothing(name):
    flights = []
    for calls in (1, 3):
        env = SpacecraftFTCVectorEnv(2, scenario=TASK)
        policy = baselines.make(name, TASK, 2).as_policy(env)
        observation, _ = env.reset(seed=0)
        flight = []
        for _ in range(70):  # into the next episode
            actions = [policy.predict(observation)[0] for _ in range(calls)]
            np.testing.assert_array_equal(actions[0], actions[-1])
            observation, *_ = env.step(actions[0])
            flight.append(observation)
        flights.append(flight)
    np.testing.assert_array_equal(*flights)


def test_spacecraft_that_are_reset_alone():
    """Those that wait in Disabled mode hold their command, whatever is asked meanwhile."""
    env, twin = (SpacecraftFTCVectorEnv(2, scenario=TASK, autoreset_mode="Disabled") for _ in range(2))
    policies = [baselines.make("pd_dob", TASK, 2).as_policy(item) for item in (env, twin)]
    observation, expected = env.reset(seed=0)[0], twin.reset(seed=0)[0]
    for _ in range(5):
        observation, *_ = env.step(policies[0].predict(observation)[0])
        expected, *_ = twin.step(policies[1].predict(expected)[0])
    held, _ = policies[0].predict(observation)
    observation, _ = env.reset(options={"reset_mask": np.array([True, False])})
    np.testing.assert_array_equal(policies[0].predict(observation)[0][1], held[1])
    for _ in range(5):
        observation, *_ = env.step(policies[0].predict(observation)[0])
        expected, *_ = twin.step(policies[1].predict(expected)[0])
        np.testing.assert_array_equal(observation[1], expected[1])


def test_a_flight_goes_on_after_pickling():
    env = single()
    policy = baselines.make("pd_dob", TASK).as_policy(env)
    observation, _ = env.reset(seed=1)
    for _ in range(5):
        observation, *_ = env.step(policy.predict(observation)[0])
    again = pickle.loads(pickle.dumps(policy))
    other = observation
    for _ in range(5):
        observation, *_ = env.step(policy.predict(observation)[0])
        other, *_ = again.env.step(again.predict(other)[0])
        np.testing.assert_array_equal(observation, other)


def test_a_measurement_of_another_number_of_spacecraft():
    simulator = Simulator(TASK, 3)
    simulator.reset(TASK.draw(0, 3))
    for count in (1, 2):
        with pytest.raises(ValueError, match=f"measurement must be of {count} spacecraft, got 3"):
            baselines.make("pd", TASK, count).act(simulator.measurement())


# ------------------------------------------------------------------------------------------------------- environments


def test_one_baseline_in_two_environments():
    law, first, second = baselines.make("pd_dob", TASK), single(), single()
    policies = [law.as_policy(env) for env in (first, second)]
    seen = [env.reset(seed=seed)[0] for seed, env in enumerate((first, second))]
    first.step(policies[0].predict(seen[0])[0])
    second.step(policies[1].predict(seen[1])[0])  # its episode starts: it takes the baseline over
    with pytest.raises(ValueError, match="must serve one environment at a time: build another one for"):
        policies[0].predict(seen[0])
    observation, _ = first.reset()  # and back, one after the other
    for _ in range(3):
        observation, *_ = first.step(policies[0].predict(observation)[0])


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"control_period": 0.2}, r"another control_period \(0\.1 and 0\.2 s\)$"),
        ({"spacecraft": scenarios.get("flexible").spacecraft}, "another .*appendages"),
        ({"scenario": "zhang_zhou_2019_stabilisation"}, r"'flagship' with another inertia, axes, .*control_period"),
        ({"scenario": "flagship_tracking"}, r"kind of reference \(moving or at rest\)$"),
        ({"num_envs": 2}, "num_spacecraft must be that of the environment, 2, got 1"),
    ],
)
def test_an_environment_for_which_it_was_not_built(changes, message):
    several = "num_envs" in changes
    env = (SpacecraftFTCVectorEnv if several else SpacecraftFTCEnv)(**{"scenario": TASK, "faults": None, **changes})
    with pytest.raises(ValueError, match=message) as error:
        baselines.make("pd", TASK).as_policy(env)
    assert len(str(error.value)) <= 500


@pytest.mark.parametrize(
    "wrap",
    [
        lambda: RescaleAction(single(), np.float32(-2.0), np.float32(2.0)),
        lambda: RescaleAction(single(), np.float32(0.0), np.float32(1.0)),
        lambda: ResidualPolicy(single()),
        lambda: ObservationHistory(ResidualPolicy(single())),
        lambda: GainScheduling(single()),
        lambda: DummyVecEnv([lambda: ResidualPolicy(single())]),
        lambda: ResidualPolicy(SpacecraftFTCVectorEnv(1, scenario=TASK)),
        lambda: SB3VecEnv(ResidualPolicy(SpacecraftFTCVectorEnv(1, scenario=TASK, autoreset_mode="SameStep"))),
    ],
)
def test_wrappers_that_change_what_an_action_means_are_refused(wrap):
    with pytest.raises(ValueError, match=r"env must take commands to the wheels: .*, got ") as error:
        baselines.make("pd", TASK).as_policy(wrap())
    assert "\n" not in str(error.value) and len(str(error.value)) <= 500
    baselines.make("pd", TASK).as_policy(RescaleAction(ObservationHistory(single()), *np.float32([-1.0, 1.0])))


def test_what_no_baseline_is_built_from_may_differ():
    env = gym.make("SpacecraftFTC-v0", scenario="flagship_hardware", faults=None, disturbance=None, duration=3.0)
    task = env.unwrapped.scenario
    nominal = task.replace(faults=TASK.faults, sensors=None, inertia_uncertainty=None, duration=60.0)
    policy = baselines.make("pd", nominal).as_policy(env)
    observation, _ = env.reset(seed=0)
    env.step(policy.predict(observation)[0])


@pytest.mark.parametrize("take", [lambda law: ResidualPolicy(single(), law), lambda law: baselines.make(law, TASK)])
def test_an_object_in_the_place_of_a_name(take):
    rule = "baseline must be a name or a class that derives from Baseline, not an object of one, got <"
    with pytest.raises(ValueError, match=rule):
        take(baselines.make("pd", TASK))
