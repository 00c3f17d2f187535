"""Functions and objects with predict, with the observation, hold, normaliser and wrappers that they are made for."""

import pickle

import gymnasium as gym
import numpy as np
import pytest
from gymnasium import spaces
from helpers.parity import EPISODES, SHORT, assert_scored_alike, flown_by
from stable_baselines3 import PPO

from ftac_gym.agents.agent import Agent
from ftac_gym.agents.interface import Interface
from ftac_gym.agents.normalizer import Normalizer
from ftac_gym.evaluation import evaluate, rollout
from ftac_gym.evaluation.batches import FlightError
from ftac_gym.policies import ExternalPolicy, resolve

GAINS = np.random.default_rng(0).normal(size=(31, 4))


def act(observation):
    """Policy of one spacecraft in any tier."""
    return np.tanh(observation @ GAINS[: observation.shape[-1]])


class Alone:
    """The same with a predict of the observation alone."""

    def predict(self, observation):
        return act(observation), None


class Standard:
    """The same with Stable-Baselines3's predict."""

    def predict(self, observation, state=None, episode_start=None, deterministic=False):
        assert deterministic and observation.ndim == 2
        return act(observation), state


def test_all_forms_fly_as_a_loop_of_the_user_does():
    expected = flown_by(act)
    for source in (act, Alone(), Standard(), ExternalPolicy(act), ExternalPolicy(Alone())):
        assert_scored_alike(source, *expected)


def test_one_spacecraft_at_a_time_unless_batched():
    shapes = []

    def seen(observation):
        shapes.append(observation.shape)
        return act(observation)

    for batched in (False, True):
        rollout(SHORT.replace(duration=0.1, loop_delay=0.0), ExternalPolicy(seen, batched=batched), EPISODES)
    assert shapes == [(22,)] * 3 + [(3, 22)]


def test_tier_and_hold():
    expected = flown_by(act, "telemetry", hold=7)
    policy = ExternalPolicy(act, observation="telemetry", hold=7)
    assert (policy.tier, policy.information, policy.interface.hold) == ("telemetry", "telemetry", 7)
    assert_scored_alike(policy, *expected)
    assert_scored_alike(pickle.loads(pickle.dumps(policy)), *expected)
    told = ExternalPolicy(act, wrappers=[("FaultEstimateObservation", {"source": "truth"})])
    assert told.information == "oracle"


def test_normaliser_and_wrappers():
    mean, variance = np.linspace(-0.5, 0.5, 44), np.linspace(0.5, 2.0, 44)
    normalizer = Normalizer(mean, variance, 3.0, 1e-8, 10.0)
    seen = []

    def first(observation):
        seen.append(observation)
        return act(observation[:22])

    policy = ExternalPolicy(first, normalizer=normalizer, wrappers=[("ObservationHistory", {"steps": 2})])
    rollout(SHORT.replace(duration=0.1, loop_delay=0.0), policy, EPISODES[:1])
    env = gym.make("SpacecraftFTC-v0", duration=3.0)
    raw, _ = env.reset(options={"episodes": EPISODES[:1]})
    (given,) = seen
    np.testing.assert_array_equal(given, normalizer.normalize(np.tile(raw, 2)[None])[0])


def test_an_error_names_policy_and_episode():
    def failing(observation):
        raise KeyError("torque")

    with pytest.raises(FlightError, match=r"^failing in flagship: episode 0: KeyError: 'torque'$"):
        evaluate(SHORT, failing, EPISODES)


@pytest.mark.parametrize("size", [1, 9])
def test_the_normaliser_must_fit(size):
    normalizer = Normalizer(np.zeros(size), np.ones(size), 10.0, 1e-8, 1.0)
    model = PPO("MlpPolicy", gym.make("SpacecraftFTC-v0"), device="cpu")
    for policy in (ExternalPolicy(act, normalizer=normalizer), Agent(model.policy, normalizer, Interface())):
        with pytest.raises(ValueError, match=rf"normalizer must be of observations of 22 entries, .*, got {size}"):
            rollout(SHORT, policy, EPISODES)


def test_a_tuple_of_numbers_is_an_action():
    expected = rollout(SHORT, lambda observation: np.array([0.1, 0.2, 0.3, 0.4]), EPISODES)
    found = rollout(SHORT, lambda observation: (0.1, 0.2, 0.3, 0.4), EPISODES)
    np.testing.assert_array_equal(found.command, expected.command)


def test_predict_with_a_state_must_return_one():
    class Stateless(Standard):
        def predict(self, observation, state=None, episode_start=None, deterministic=True):
            return super().predict(observation, state, episode_start, deterministic)[0]

    # Of two spacecraft, the actions alone could be taken for actions and a state.
    with pytest.raises(ValueError, match="policy must return actions and state from predict"):
        rollout(SHORT, Stateless(), EPISODES[:2])


def test_known_spaces_must_fit():
    class Sized(Standard):
        observation_space = spaces.Box(-1.0, 1.0, (9,))

    with pytest.raises(ValueError, match=r"policy must have the observation space \(22,\), .*got \(9,\)"):
        rollout(SHORT, Sized())
    policy = PPO("MlpPolicy", gym.make("SpacecraftFTC-v0"), device="cpu").policy
    assert rollout(SHORT.replace(duration=0.1, loop_delay=0.0), policy).command.shape == (1, 1, 4)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("text",), "policy must be a function or an object with predict, got 'text'"),
        ((type("Odd", (), {"predict": lambda self, a, b: a})(),), r"policy must have predict\(observation\), or .*got"),
        ((act, "everything"), "observation must be one of"),
        ((act, "attitude", 0), "hold must be a positive integer, got 0"),
        ((act, "attitude", 1, 3.0), "normalizer must be a Normalizer or None"),
        ((act, "attitude", 1, None, [("Unknown", {})]), "wrappers must be among"),
        ((act, "attitude", 1, None, (), 1), "batched must be"),
    ],
)
def test_what_is_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        ExternalPolicy(*arguments)


def test_a_class_is_no_policy():
    with pytest.raises(ValueError, match="policy must be a name, a path"):
        resolve(Standard)
