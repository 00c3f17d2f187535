"""Flights of a policy through episodes, with their time histories."""

from collections.abc import Callable
from typing import Any

import numpy as np

from ftac_gym import scenarios
from ftac_gym.evaluation.metrics import Rollout
from ftac_gym.policies import PolicyRunner, check_task, resolve
from ftac_gym.scenarios import ScenarioLike
from ftac_gym.task.episodes import Episodes
from ftac_gym.task.fitting import fitted
from ftac_gym.utils.parameters import FloatArray

Recorder = Callable[[int, PolicyRunner], None]
"""A function of the number of a control period and the runner."""


def rollout(
    scenario: ScenarioLike,
    policy: Any,
    episodes: Episodes | None = None,
    seed: int = 0,
    count: int = 1,
    threads: int = 1,
    recorder: Recorder | None = None,
) -> Rollout:
    """Run a policy through episodes, all of them side by side, to their full length.

    Parameters
    ----------
    scenario
        The scenario, or what :func:`ftac_gym.scenarios.resolve` takes: its name, a file, a function, data.
    policy
        See :func:`~ftac_gym.policies.resolve`.
    episodes
        The episodes, which :func:`~ftac_gym.task.fitting.fitted` checks and labels for the scenario; None draws
        ``count`` of them from ``seed``.
    seed, count
        What to draw if no episodes are given.
    threads
        Threads of the simulator.
    recorder
        Called with k and the runner at the start of control period k = 0, ..., T - 1, before the policy acts, and with
        T at the end. The runner holds the policy, with its estimates of the period before, and the simulator.

    Raises
    ------
    ValueError
        If a name is unknown, or the policy or the episodes do not fit the scenario.
    """
    task = scenarios.resolve(scenario)
    drawn = task.draw(seed, count) if episodes is None else fitted(episodes, task)
    resolved = resolve(policy, task.name)
    check_task(resolved, task)
    runner = PolicyRunner(task, resolved, len(drawn), threads)
    runner.reset(drawn)
    simulator, steps = runner.env.batch.simulator, task.horizon
    histories = {name: np.empty((steps + 1, *values.shape)) for name, values in _truth(runner).items()}
    rewards = np.empty((steps, len(drawn)))
    command = np.empty((steps, len(drawn), task.spacecraft.wheels.count))
    for step in range(steps + 1):
        for name, values in _truth(runner).items():
            histories[name][step] = values
        if recorder is not None:
            recorder(step, runner)
        if step < steps:
            rewards[step] = runner.step()
            command[step] = simulator.last_command
    return Rollout(
        scenario=task,
        episodes=drawn,
        time=np.arange(steps + 1, dtype=np.float64) * task.control_period,
        command=command,
        applied_torque=-np.diff(histories["wheel_momentum"], axis=0) / task.control_period,
        reward=rewards,
        **histories,
    )


def _truth(runner: PolicyRunner) -> dict[str, FloatArray]:
    """Return the histories' values at the present moment, the spacecraft on the first axis."""
    simulator, reward = runner.env.batch.simulator, runner.env.batch.reward
    state = simulator.state
    return {
        "attitude_error": reward.attitude_error,
        "rate_error": reward.rate_error,
        "attitude": state.attitude,
        "reference_attitude": simulator.reference_attitude,
        "rate": state.rate,
        "wheel_momentum": state.wheel_momentum,
        "modal_displacement": state.modal_displacement,
        "modal_rate": state.modal_rate,
    }
