"""Models: an agent on a base starts as its base, and a critic may observe more than its actor."""

import numpy as np
import pytest
import torch
from helpers.tiny_models import NUM_ENVS, RESIDUAL, model_of

from ftac_gym.agents.agent import Agent
from ftac_gym.agents.interface import Interface
from ftac_gym.training.algorithms import BASE_NOISE, let_actor_learn
from ftac_gym.training.callbacks import Schedule
from ftac_gym.training.hyperparameters import ALGORITHMS


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_a_residual_starts_as_its_base_and_a_direct_agent_does_not(algorithm):
    observation = np.random.default_rng(0).normal(size=(6, 26)).astype(np.float32)
    actions = {}
    for wrappers in (RESIDUAL, ()):
        model, size = model_of(algorithm, Interface(wrappers=wrappers))
        actions[bool(wrappers)], _ = model.predict(observation[:, :size], deterministic=True)
    assert (actions[True] == 0.0).all() and (actions[False] != 0.0).any()


@pytest.mark.parametrize("algorithm", ["sac", "tqc"])
def test_off_policy_agents_begin_with_data_about_their_base(algorithm):
    model, _ = model_of(algorithm, Interface(wrappers=RESIDUAL))
    model.learn(40)
    early = model.replay_buffer.actions[:10].ravel()
    assert 0.5 * BASE_NOISE < early.std() < 1.5 * BASE_NOISE
    direct, _ = model_of(algorithm, Interface())
    direct.learn(40)
    assert direct.replay_buffer.actions[:10].std() > 0.4  # uniform


@pytest.mark.parametrize("algorithm", ["ppo", "recurrent_ppo"])
def test_in_the_warm_up_only_the_critic_learns(algorithm):
    model, _ = model_of(algorithm, Interface(wrappers=RESIDUAL))
    for learning in (False, True):
        before = {name: value.clone() for name, value in model.policy.state_dict().items()}
        let_actor_learn(model, learning)
        model.learn(NUM_ENVS * 8)
        changed = {name for name, value in model.policy.state_dict().items() if (value != before[name]).any()}
        actor = {name for name in before if "policy_net" in name or "action_net" in name or name == "log_std"}
        actor |= {name for name in before if name.startswith("lstm_actor")}
        assert actor and bool(changed & actor) == learning
        assert changed - actor  # the critic


def test_a_critic_that_sees_the_faults_leaves_the_actor_blind_to_them(tmp_path):
    interface = Interface(wrappers=RESIDUAL, critic_sees_faults=True)
    model, size = model_of("ppo", interface)
    model.learn(200)
    whole = model.observation_space.shape[0]
    assert whole > size == 26
    rng = np.random.default_rng(0)
    one = rng.normal(size=(5, whole)).astype(np.float32)
    other = one.copy()
    other[:, size:] = rng.normal(size=(5, whole - size))
    with torch.no_grad():
        actions = [model.predict(item, deterministic=True)[0] for item in (one, other)]
        values = [model.policy.predict_values(torch.as_tensor(item)) for item in (one, other)]
    np.testing.assert_array_equal(*actions)
    assert (values[0] != values[1]).all()
    # In flight the actor has its own part alone, and gives the same action; from disk too.
    agent = Agent.of(model, interface)
    agent.save(tmp_path)
    normalizer = model.get_vec_normalize_env()
    expected, _ = model.predict(normalizer.normalize_obs(one), deterministic=True)
    for flown in (agent, Agent.load(tmp_path)):
        action, _ = flown.predict(one[:, :size])
        np.testing.assert_array_equal(action, expected)


def test_what_does_not_go_together_is_refused():
    with pytest.raises(ValueError, match=r"algo must be one of .*got 'a2c'"):
        model_of("a2c", Interface())
    with pytest.raises(ValueError, match="critic_sees_faults must go with ppo, got 'tqc'"):
        model_of("tqc", Interface(critic_sees_faults=True))


def test_the_severity_rises_evenly():
    schedule = Schedule(1, 1, 1, 0, severity_start=0.2, severity_steps=100)
    assert [schedule.severity(steps) for steps in (0, 50, 100, 1000)] == pytest.approx([0.2, 0.6, 1.0, 1.0])
    assert Schedule(1, 1, 1, 0).severity(0) == 1.0
