"""Environments of training and evaluation."""

import numpy as np
import pytest
from helpers.untrained_agents import write_agent

from ftac_gym import scenarios
from ftac_gym.agents.agent import Agent
from ftac_gym.agents.interface import Interface
from ftac_gym.evaluation import rollout
from ftac_gym.evaluation.episodes import judging_episodes
from ftac_gym.task.objective import RewardWeights
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


@pytest.mark.parametrize(
    ("task", "count", "message"),
    [
        (scenarios.get("easy").replace(duration=1.0), 4, r"scenario must have more feasible episodes: 0 of \d+ drawn"),
        (scenarios.get("flagship"), 501, r"feasible must be within \[1, 500\], got 501"),
    ],
)
def test_too_few_feasible_episodes_are_refused(task, count, message):
    with pytest.raises(ValueError, match=f"^evaluation-episodes: {message}"):
        evaluator(task, count, task.reward)


@pytest.mark.parametrize("changes", [{}, {"duration": 45.0}], ids=["frozen", "drawn"])
def test_evaluations_are_means_over_the_feasible_episodes_of_the_validation(changes, tmp_path):
    write_agent(tmp_path)
    agent = Agent.load(tmp_path)
    task = scenarios.get("flagship_double").replace(**changes)
    reward = RewardWeights(on_target=2.0)
    found = evaluator(task, 4, reward)(agent)
    episodes = judging_episodes(task, 4, "validation")
    assert episodes.feasible.sum() == 4 and (not changes or len(episodes) > 4)
    returns = rollout(task.replace(reward=reward), agent, episodes).reward.sum(axis=0)
    assert found["mean_return"] == pytest.approx(np.mean(returns[episodes.feasible]), rel=1e-12)
    assert found["episodes"] == 4
    test = judging_episodes(task, 4)
    assert not (episodes.key[:1] == test.key).all(axis=1).any()
