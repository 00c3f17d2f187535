"""Environments of training and evaluation."""

import numpy as np
import pytest
from helpers.untrained_agents import write_agent

from ftac_gym import scenarios
from ftac_gym.agents.agent import Agent
from ftac_gym.agents.interface import Interface
from ftac_gym.evaluation import rollout
from ftac_gym.training.environments import evaluator, training_environment

SHORT = scenarios.get("flagship").replace(duration=3.0)
ID = "SpacecraftFTC-v0"


def test_a_training_flies_its_own_scenario_with_an_observation_for_the_actor():
    interface = Interface(wrappers=(("ObservationHistory", {"steps": 3}),), hold=5, critic_sees_faults=True)
    env, actor = training_environment(ID, SHORT, interface, 4, SHORT)
    assert (env.num_envs, env.hold, env.get_attr("scenario")) == (4, 5, [SHORT] * 4)
    # The truth is behind what the actor sees.
    assert 0 < actor < env.observation_space.shape[0]
    plain, size = training_environment(ID, SHORT, Interface(), 1, SHORT)
    assert (actor, plain.observation_space.shape) == (3 * size, (size,))


def test_a_scenario_with_other_spaces_is_refused():
    with pytest.raises(ValueError, match=r"training-scenario must have the observation space .* of the task, got"):
        training_environment(ID, scenarios.get("cao_2022"), Interface(), 2, SHORT)


def test_episodes_of_which_none_is_feasible_are_refused():
    with pytest.raises(ValueError, match=r"evaluation-episodes must have a feasible one among them; .*, got 4"):
        evaluator(scenarios.get("easy").replace(duration=1.0), 7, 4)


def test_evaluations_are_means_over_the_feasible_ones_of_fixed_episodes(tmp_path):
    write_agent(tmp_path)
    agent = Agent.load(tmp_path)
    task = scenarios.get("flagship_double").replace(duration=60.0)
    found = evaluator(task, 7, 12)(agent)
    episodes = task.draw(7, 12)
    assert 0 < episodes.feasible.sum() < 12
    returns = rollout(task, agent, episodes).reward.sum(axis=0)
    assert found["mean_return"] == pytest.approx(np.mean(returns[episodes.feasible]), rel=1e-12)
    assert found["episodes"] == episodes.feasible.sum()
