"""Environments that agents are trained and evaluated in."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import gymnasium as gym

from ftac_gym.agents.agent import Agent
from ftac_gym.agents.interface import Interface
from ftac_gym.evaluation.episodes import judging_episodes
from ftac_gym.evaluation.metrics import counted
from ftac_gym.evaluation.rollout import rollout
from ftac_gym.task.objective import RewardWeights
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import require
from ftac_gym.wrappers import SB3VecEnv


def training_environment(
    env_id: str, scenario: Scenario, interface: Interface, count: int, task: Scenario
) -> tuple[SB3VecEnv, int]:
    """Return the vector environment of a training, and the number of entries of its observation for the actor.

    Parameters
    ----------
    env_id
        Environment id.
    scenario
        Scenario to train on.
    interface
        Interface of the network.
    count
        Spacecraft in parallel.
    task
        The task on which the agent is judged.

    Raises
    ------
    ValueError
        If the scenario gives other spaces than the task.
    """
    arguments: dict[str, Any] = {"observation": interface.observation, "scenario": scenario}
    native = gym.make_vec(env_id, num_envs=count, autoreset_mode="SameStep", **arguments)
    single = interface.wrap(gym.make(env_id, **arguments))
    # Training and task may differ in the scenario, but not in the spaces of the agent.
    judged = interface.wrap(gym.make(env_id, observation=interface.observation, scenario=task))
    for part in ("observation_space", "action_space"):
        given, required = getattr(single, part).shape, getattr(judged, part).shape
        rule = f"must have the {part.replace('_', ' ')} {required} of the task"
        require(given == required, "training-scenario", rule, given)
    return SB3VecEnv(interface.wrap_for_training(native), interface.hold), single.observation_space.shape[0]


def evaluator(task: Scenario, feasible: int, reward: RewardWeights) -> Callable[[Agent], Mapping[str, float]]:
    """Return a function that flies an agent through validation episodes; its metrics are over the feasible ones.

    Parameters
    ----------
    task
        The task, with its own reward.
    feasible
        Number of feasible episodes; see :func:`~ftac_gym.evaluation.episodes.judging_episodes`.
    reward
        Weights of the reward of the training.

    Raises
    ------
    ValueError
        If the task has fewer feasible episodes.
    """
    try:
        episodes = judging_episodes(task, feasible, "validation")
    except ValueError as error:
        raise ValueError(f"evaluation-episodes: {error}") from None
    rewarded = task.replace(reward=reward)

    def evaluate(agent: Agent) -> dict[str, float]:
        metrics = rollout(rewarded, agent, episodes).feasible_metrics()
        return {"mean_return": float(metrics["return"].mean()), **counted(metrics)}

    return evaluate
