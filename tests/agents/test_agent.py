"""Interface, action hold and storage of an agent."""

import json
from dataclasses import asdict

import gymnasium as gym
import numpy as np
import pytest
from helpers.custom_baseline import CustomBaseline, CustomTelemetry
from stable_baselines3 import PPO
from stable_baselines3.common.vec_env import DummyVecEnv

from ftac_gym import scenarios
from ftac_gym.agents.agent import Agent
from ftac_gym.agents.interface import Interface
from ftac_gym.evaluation import rollout
from ftac_gym.training.algorithms import start_as_base


@pytest.mark.parametrize(
    ("tier", "wrappers", "expected"),
    [
        ("attitude", [], "attitude"),
        ("telemetry", [["ObservationHistory", {"steps": 2}]], "telemetry"),
        ("attitude", [["FaultEstimateObservation", {"source": "asmo"}]], "attitude"),
        ("attitude", [["FaultEstimateObservation", {"source": "dob"}]], "attitude"),
        ("attitude", [["FaultEstimateObservation", {"source": "tachometer"}]], "telemetry"),
        ("telemetry", [["FaultEstimateObservation", {"source": "truth"}]], "oracle"),
        ("attitude", [["ResidualPolicy", {"base": "nftsm_telemetry", "faults": "tachometer"}]], "telemetry"),
        ("attitude", [["ResidualPolicy", {"base": "pd_dob", "telemetry": True}]], "telemetry"),
    ],
)
def test_the_information_tier_counts_all_inputs(tier, wrappers, expected):
    interface = Interface(tier, wrappers)
    assert interface.information == expected
    assert Agent(None, None, interface).information == expected and Agent(None, None, interface).tier == tier


def test_wrappers_go_around_in_their_order():
    interface = Interface(
        wrappers=[
            ["FaultEstimateObservation", {"source": "dob"}],
            ["ResidualPolicy", {"base": "pd"}],
            ["ObservationHistory", {"steps": 3}],
        ]
    )
    env = gym.make("SpacecraftFTC-v0")
    wrapped = interface.wrap(env)
    assert wrapped.observation_space.shape == (3 * (22 + 3 + 4),)
    observation, _ = wrapped.reset(seed=0)
    plain, _ = gym.make("SpacecraftFTC-v0").reset(seed=0)
    np.testing.assert_array_equal(observation[:22], plain)
    told = Interface(wrappers=interface.wrappers, critic_sees_faults=True)
    size = told.wrap_for_training(gym.make("SpacecraftFTC-v0")).observation_space.shape[0]
    assert size > 87 and told.wrap(gym.make("SpacecraftFTC-v0")).observation_space.shape == (87,)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"wrappers": [["TimeLimit", {}]]}, r"wrappers must be among \[.*'ResidualPolicy'\], got 'TimeLimit'"),
        ({"wrappers": [["ObservationHistory", {"a": 1}]]}, "arguments must be among .*'steps', 'stride'.*, got 'a'"),
        (
            {"wrappers": [["ObservationHistory", {"steps": 1e9}]]},
            "steps must be a whole number, 1 or more, got 1000",
        ),
        ({"wrappers": [["ObservationHistory", {"stride": 10**9}]]}, "steps times stride must not exceed 10000"),
        ({"wrappers": [["ResidualPolicy", {"rate_gain": 1e308}]]}, "rate_gain must be within 1e.12 of zero, got 1e"),
        ({"wrappers": [["ResidualPolicy", {"rate_gain": "2"}]]}, "rate_gain must be a number, got '2'"),
        ({"wrappers": [["ResidualPolicy", {"authority": 3.0}]]}, "authority must be above 0 and at most 2, got 3.0"),
        (
            {"wrappers": [["ResidualPolicy", {"base": "nftsm_observer", "observer": {"b": 1}}]]},
            "observer must have gains among .* got 'b'",
        ),
        ({"wrappers": [["GainScheduling", {"base": "pd", "b": 1}]]}, "arguments must be among .*'ranges'.*, got 'b'"),
        (
            {"wrappers": [["GainScheduling", {"ranges": {"rate_gain": [1, 1e300]}}]]},
            r"ranges.rate_gain\[1\] must be",
        ),
        ({"wrappers": [["FaultEstimateObservation", {"source": "asmo", "c": 1}]]}, "arguments must be among .*'c'"),
        (
            {"wrappers": [["FaultEstimateObservation", {"source": "dob", "bandwidth": 1e300}]]},
            "bandwidth must be within",
        ),
        ({"wrappers": [["FaultEstimateObservation", {"source": print}]]}, "source must be a number, text, true"),
        ({"hold": 0}, "hold must be a positive integer, got 0"),
        ({"hold": 1.5}, "hold must be a positive integer, got 1.5"),
    ],
)
def test_bad_interfaces(arguments, message):
    with pytest.raises(ValueError, match=message):
        Interface(**arguments)


class Counter:
    """Stands for a recurrent network: its memory counts its decisions since the start, and is its action."""

    observation_space = gym.spaces.Box(-1.0, 1.0, (5,))

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        count = np.zeros((1, len(observation), 1)) if state is None else state[0]
        count = np.where(episode_start[None, :, None], 0.0, count) + 1.0
        return np.repeat(count[0], 4, axis=1), (count, count)


def test_the_memory_of_a_recurrent_agent_changes_with_its_decisions_only():
    """Spacecraft that hold an action do not think; those whose episode starts forget."""
    agent = Agent(Counter(), None, Interface(hold=2))
    state, start, seen = None, np.array([True, True]), []
    for step in range(7):
        action, state = agent.predict(np.zeros((2, 5)), state, start)
        seen.append(action[:, 0].tolist())
        start = np.array([False, step == 2])  # the second spacecraft starts anew at step 3
    first, second = np.array(seen).T
    assert first.tolist() == [1, 1, 2, 2, 3, 3, 4]
    assert second.tolist() == [1, 1, 2, 1, 1, 2, 2]


@pytest.mark.parametrize("wrapper", ["ResidualPolicy", "GainScheduling"])
def test_a_custom_base_is_stored_as_text(wrapper):
    interface = Interface(wrappers=[[wrapper, {"base": CustomBaseline}]])
    assert interface.bases == ("helpers.custom_baseline:CustomBaseline",)
    assert Interface(**json.loads(json.dumps(asdict(interface)))) == interface
    assert Interface(wrappers=[["ResidualPolicy", {}], ["ObservationHistory", {}]]).bases == ("pd_dob",)


def test_the_tier_of_a_custom_base_counts():
    assert Interface(wrappers=[["ResidualPolicy", {"base": CustomBaseline}]]).information == "attitude"
    assert Interface(wrappers=[["ResidualPolicy", {"base": CustomTelemetry}]]).information == "telemetry"


def test_a_base_that_cannot_be_imported_is_refused():
    class Local(CustomBaseline):
        pass

    with pytest.raises(ValueError, match=r"baseline must be a class that can be imported, .* got .*Local"):
        Interface(wrappers=[["ResidualPolicy", {"base": Local}]])


def test_an_agent_on_a_custom_base_flies_again_and_has_no_fingerprint(tmp_path):
    for name, base in (("own", CustomBaseline), ("known", "pd")):
        interface = Interface(wrappers=[["ResidualPolicy", {"base": base}]])
        env = DummyVecEnv([lambda interface=interface: interface.wrap(gym.make("SpacecraftFTC-v0", duration=5.0))])
        model = PPO("MlpPolicy", env, device="cpu")
        start_as_base(model)
        Agent.of(model, interface).save(tmp_path / name)
    agent = Agent.load(tmp_path / "own")
    assert agent.fingerprint is None and Agent.load(tmp_path / "known").fingerprint is not None
    task = scenarios.get("flagship").replace(duration=5.0)
    flown, alone = (rollout(task, policy, seed=1, count=2) for policy in (agent, CustomBaseline))
    np.testing.assert_array_equal(flown.attitude, alone.attitude)
