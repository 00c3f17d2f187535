"""Networks as data: every kind acts from disk as in memory, and what is code is refused."""

import json

import numpy as np
import pytest
from helpers.networks import MODELS, SIZE, Spaces, every_model, model_of, observations
from sb3_contrib import RecurrentPPO
from stable_baselines3 import DQN
from stable_baselines3.common.policies import ActorCriticPolicy
from stable_baselines3.common.torch_layers import FlattenExtractor
from stable_baselines3.common.vec_env import DummyVecEnv, VecNormalize
from torch import nn

from ftac_gym.agents import storage
from ftac_gym.agents.agent import Agent
from ftac_gym.agents.export import export


def flown(agent, periods=3):
    """Return the actions of an agent in some control periods, with the memory of a recurrent one."""
    state, start, actions = None, np.ones(50, dtype=bool), []
    for _ in range(periods):
        action, state = agent.predict(observations(agent.observation_size), state, start)
        actions.append(action)
        start = np.zeros(50, dtype=bool)
    return np.array(actions)


@every_model
def test_a_stored_agent_acts_bit_for_bit(name, tmp_path):
    agent = Agent.of(model_of(**MODELS[name]))
    agent.save(tmp_path)
    loaded = Agent.load(tmp_path)
    actions = flown(agent)
    assert len(np.unique(actions)) > 10
    np.testing.assert_array_equal(flown(loaded), actions)
    for part in ("observation_space", "action_space"):
        assert getattr(loaded.policy, part) == getattr(agent.policy, part)
    for key, values in agent.policy.state_dict().items():
        np.testing.assert_array_equal(loaded.policy.state_dict()[key], values)


@every_model
def test_stable_baselines_loads_an_export_and_acts_alike(name, tmp_path):
    model = model_of(**MODELS[name])
    Agent.of(model).save(tmp_path / "agent")
    agent = Agent.load(tmp_path / "agent")
    export(agent, tmp_path / "export")
    loaded = type(model).load(tmp_path / "export" / "model.zip", device="cpu")
    normalizer = VecNormalize.load(str(tmp_path / "export" / "vecnormalize.pkl"), DummyVecEnv([Spaces]))
    padded = np.pad(observations(agent.observation_size), ((0, 0), (0, SIZE - agent.observation_size)))
    actions, _ = loaded.predict(normalizer.normalize_obs(padded), deterministic=True)
    np.testing.assert_array_equal(actions, flown(agent, 1)[0])
    assert not normalizer.training and normalizer.obs_rms.count == 12.5


class OwnActivation(nn.Tanh):
    pass


class OwnExtractor(FlattenExtractor):
    pass


class OwnPolicy(ActorCriticPolicy):
    pass


def diverged():
    model = model_of()
    model.policy.log_std.data[0] = np.nan
    return model


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: model_of(arguments={"net_arch": [4], "activation_fn": OwnActivation}), "activation_fn must be one of"),
        (lambda: model_of(arguments={"features_extractor_class": OwnExtractor}), "features_extractor_class must"),
        (lambda: model_of(policy=OwnPolicy), r"policy must be one of .*OwnPolicy"),
        (
            lambda: model_of(RecurrentPPO, "MlpLstmPolicy", {"lstm_kwargs": {"bias": False}}),
            "lstm_kwargs must be empty; .*'bias'",
        ),
        (lambda: DQN("MlpPolicy", "CartPole-v1", buffer_size=10, device="cpu"), r"policy must be one of .*DQNPolicy"),
    ],
)  # fmt: skip
def test_networks_with_code_of_their_own_are_refused(make, message, tmp_path):
    with pytest.raises(ValueError, match=message) as caught:
        Agent.of(make()).save(tmp_path)
    assert "keep such a model as Stable-Baselines3's own zip" in str(caught.value)
    assert not list(tmp_path.iterdir())


def test_weights_that_are_not_finite_are_refused(tmp_path):
    with pytest.raises(ValueError, match=r"log_std must be finite, got array\(\[nan\]"):
        Agent.of(diverged()).save(tmp_path)


def forged(folder, change):
    """Change the card of an agent, and its digest with it."""
    card = json.loads((folder / "card.json").read_text())
    change(card)
    card["digest"] = storage._digest(card)
    (folder / "card.json").write_text(json.dumps(card))


LARGE = 10**7  # a network that no memory holds


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"net_arch": [LARGE, LARGE]}, "arguments must be of a network that has these weights"),
        ({"net_arch": [1] * 1000}, "arguments must be of a network that has these weights"),
        ({"net_arch": [6]}, r"policy_net.0.weight must be \(6, 6\) of float32, got '\(5, 6\) of float32'"),
        ({"net_arch": [5, 5]}, "weights must be"),
        ({"net_arch": [True]}, "net_arch must be a whole number, 1 or more, got True"),
        ({"net_arch": {"pi": [5], "qf": [5], "vf": [5]}}, 'net_arch must have "pi", and "vf" or "qf"'),
        ({"use_sde": 1}, "use_sde must be true or false, got 1"),
        ({"activation_fn": "Linear"}, "activation_fn must be one of .*'Linear'"),
        ({"squash_output": True}, "squash_output=True is only available"),
        ({"actor_size": 3}, "arguments must be those of"),
    ],
)
def test_arguments_that_do_not_fit_the_weights_are_refused(change, message, tmp_path):
    Agent.of(model_of()).save(tmp_path)
    forged(tmp_path, lambda card: card["network"]["arguments"].update(change))
    with pytest.raises(ValueError, match=rf"card.json cannot be read: .*{message}"):
        Agent.load(tmp_path)
