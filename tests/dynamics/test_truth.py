"""The truth about the faults is given on request only, by every kind of environment."""

import gymnasium as gym
import numpy as np
import pytest
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env import DummyVecEnv, VecNormalize

from ftac_gym import baselines, scenarios
from ftac_gym.baselines import Baseline, as_action, measurement_of, registry
from ftac_gym.dynamics import Simulator
from ftac_gym.envs import SpacecraftFTCEnv, SpacecraftFTCVectorEnv
from ftac_gym.faults import FaultEffect, fault_effect
from ftac_gym.wrappers import ResidualPolicy, SB3VecEnv

SEVERE = scenarios.get("flagship_severe")
UNSEEN = scenarios.get("flagship_unseen")
KINDS = ("single", "wrapped", "native", "wrapped native", "SB3VecEnv", "DummyVecEnv", "VecNormalize")
CRAFT, SEED = 3, 7  # the first spacecraft has a bias from 6.4 s on


class Oracle(Baseline):
    """Undoes the bias that it is told of; without a disturbance, the body then does not move."""

    information = "oracle"

    def act(self, measurement):
        truth = measurement.truth
        gives = np.where(truth.effectiveness > 0.0, truth.effectiveness, np.inf)
        limits = self.scenario.spacecraft.wheels.torque_limits
        return np.clip(-truth.bias / gives, -limits, limits)


@pytest.fixture
def oracle(monkeypatch):
    monkeypatch.setitem(registry.ENTRIES, "tiny_oracle", registry.Entry(Oracle))
    return "tiny_oracle"


def build(kind):
    """Return an environment, and how many spacecraft it has."""
    settings = {"scenario": "flagship_severe"}
    if kind == "single":
        return SpacecraftFTCEnv(**settings), 1
    if kind == "wrapped":
        return gym.make("SpacecraftFTC-v0", **settings), 1
    if kind == "native":
        return SpacecraftFTCVectorEnv(CRAFT, **settings), CRAFT
    if kind == "wrapped native":
        env = gym.make_vec("SpacecraftFTC-v0", num_envs=CRAFT, **settings)
        return gym.wrappers.vector.RecordEpisodeStatistics(env), CRAFT
    if kind == "SB3VecEnv":
        return SB3VecEnv(SpacecraftFTCVectorEnv(CRAFT, autoreset_mode="SameStep", **settings)), CRAFT
    vector = DummyVecEnv([lambda: Monitor(SpacecraftFTCEnv(**settings))] * CRAFT)
    return (VecNormalize(vector, norm_obs=False, norm_reward=False) if kind == "VecNormalize" else vector), CRAFT


def start(env, seed):
    """Reset an environment, in the way of its library."""
    if hasattr(env, "step_async"):
        env.seed(seed)
        return env.reset()
    return env.reset(seed=seed)[0]


def assert_effects(effect, expected):
    assert isinstance(effect, FaultEffect)
    for name in FaultEffect._fields:
        np.testing.assert_array_equal(getattr(effect, name), getattr(expected, name), err_msg=name, strict=True)


@pytest.mark.parametrize("scenario", [SEVERE, UNSEEN], ids=lambda scenario: scenario.name)
def test_the_truth_is_what_the_fault_tables_say(scenario):
    simulator, random = Simulator(scenario, 20), np.random.default_rng(0)
    simulator.reset(scenario.draw(0, 20))
    drawn, wheels = scenario.draw(0, 20).drawn_faults, scenario.spacecraft.wheels
    struck = np.zeros(20, dtype=bool)
    for _ in range(850):
        measurement, state = simulator.measurement(truth=True), simulator.state
        expected = fault_effect(drawn, simulator.time, wheels, state.wheel_momentum, state.wheel_torque)
        assert_effects(measurement.truth, expected)
        assert_effects(simulator.truth(), expected)
        struck |= (expected.effectiveness < 1.0).any(axis=1) | (expected.bias != 0.0).any(axis=1)
        struck |= (expected.delay > 0).any(axis=1) | expected.star_tracker_out
        simulator.step(random.uniform(-0.2, 0.2, (20, 4)))
    assert struck.sum() > 10


def test_nothing_else_changes_when_the_truth_is_asked_for():
    simulator = Simulator(SEVERE, 5)
    simulator.reset(SEVERE.draw(0, 5))
    plain, told = simulator.measurement(), simulator.measurement(truth=True)
    assert plain.truth is None and len(told) == 5
    for name, array in vars(plain).items():
        if name != "truth":
            np.testing.assert_array_equal(getattr(told, name), array)
    for part in told.truth:
        part[...] = 1
    assert_effects(simulator.truth(), simulator.measurement(truth=True).truth)


@pytest.mark.parametrize("kind", KINDS)
def test_through_environments(kind):
    env, craft = build(kind)
    start(env, SEED)
    # Single environments of a vector have seeds of their own.
    simulators = [Simulator(SEVERE, 1) for _ in range(craft)]
    for number, single in enumerate(simulators):
        single.reset(SEVERE.draw(SEED + number, 1))
    action = np.full((craft, 4), 0.01)
    stable_baselines, batched = hasattr(env, "step_async"), craft > 1
    changed = False
    for _ in range(200):
        measurement = measurement_of(env, truth=True)
        expected = FaultEffect(*map(np.concatenate, zip(*(single.truth() for single in simulators), strict=True)))
        assert_effects(measurement.truth, expected)
        assert measurement_of(env).truth is None and len(measurement) == craft
        changed |= bool((expected.effectiveness < 1.0).any() or expected.bias.any())
        for single in simulators:
            single.step(action[:1] * SEVERE.spacecraft.wheels.torque_limits)
        env.step(action if stable_baselines or batched else action[0])
    assert changed


@pytest.mark.parametrize("kind", KINDS)
def test_an_oracle_is_told_as_a_policy(kind, oracle):
    env, craft = build(kind)
    observation = start(env, SEED)
    policy = baselines.make(oracle, SEVERE, craft).as_policy(env)
    reference = Oracle(SEVERE, craft)
    limits, pushed = SEVERE.spacecraft.wheels.torque_limits, False
    for _ in range(200):
        action, _ = policy.predict(observation)
        expected = as_action(reference.act(measurement_of(env, truth=True)), limits)
        np.testing.assert_array_equal(np.atleast_2d(action), expected)
        pushed |= bool(np.any(action != 0.0))
        observation = env.step(action)[0]
    assert pushed


def test_other_baselines_are_not_told(monkeypatch):
    class Curious(baselines.baseline_class("pd")):
        def act(self, measurement):
            assert measurement.truth is None
            return super().act(measurement)

    env = SpacecraftFTCVectorEnv(CRAFT, scenario="flagship_severe")
    observation, _ = env.reset(seed=0)
    policy = Curious(SEVERE, CRAFT).as_policy(env)
    for _ in range(20):
        observation, *_ = env.step(policy.predict(observation)[0])
    monkeypatch.setitem(registry.ENTRIES, "curious", registry.Entry(Curious))
    wrapped = ResidualPolicy(SpacecraftFTCEnv(scenario="flagship_severe"), base="curious")
    wrapped.reset(seed=0)
    for _ in range(20):
        wrapped.step(np.zeros(4))


@pytest.mark.parametrize("build_env", [SpacecraftFTCEnv, lambda: SpacecraftFTCVectorEnv(CRAFT)],
                         ids=["single", "vector"])  # fmt: skip
def test_a_residual_policy_refuses_an_oracle(build_env, oracle):
    with pytest.raises(ValueError, match=r"base must not be an oracle: .*, got 'tiny_oracle'"):
        ResidualPolicy(build_env(), base=oracle)
