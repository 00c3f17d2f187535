"""What surrounds a policy network: its tier, its wrappers, its memory."""

import gymnasium as gym
import numpy as np
import pytest

from ftac_gym.evaluation.agent import Agent, Interface


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
def test_an_agent_is_of_the_tier_of_all_that_it_knows(tier, wrappers, expected):
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
        ({"hold": 0}, "hold must be a positive integer, got 0"),
        ({"hold": 1.5}, "hold must be a positive integer, got 1.5"),
    ],
)
def test_bad_interfaces(arguments, message):
    with pytest.raises(ValueError, match=message):
        Interface(**arguments)


class Counter:
    """Stands for a recurrent model: its memory counts its decisions since the start, and is its action."""

    observation_space = gym.spaces.Box(-1.0, 1.0, (5,))
    policy = None

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        count = np.zeros((1, len(observation), 1)) if state is None else state[0]
        count = np.where(episode_start[None, :, None], 0.0, count) + 1.0
        return np.repeat(count[0], 4, axis=1), (count, count)


def test_a_recurrent_agent_remembers_its_own_decisions_alone():
    """Craft that hold an action do not think; those whose episode starts forget."""
    agent = Agent(Counter(), None, Interface(hold=2))
    state, start, seen = None, np.array([True, True]), []
    for step in range(7):
        action, state = agent.predict(np.zeros((2, 5)), state, start)
        seen.append(action[:, 0].tolist())
        start = np.array([False, step == 2])  # the second craft starts anew at step 3
    first, second = np.array(seen).T
    assert first.tolist() == [1, 1, 2, 2, 3, 3, 4]
    assert second.tolist() == [1, 1, 2, 1, 1, 2, 2]
