"""Flights of a policy through episodes, with their time histories."""

from collections.abc import Callable
from dataclasses import fields
from typing import Any

import numpy as np

from ftac_gym import scenarios
from ftac_gym.baselines import FaultEstimate
from ftac_gym.evaluation.metrics import Rollout
from ftac_gym.evaluation.threads import one_torch_thread
from ftac_gym.policies import PolicyRunner, check_task, policy_label, resolve
from ftac_gym.scenarios import ScenarioLike
from ftac_gym.task.episodes import Episodes
from ftac_gym.task.fitting import fitted
from ftac_gym.utils.parameters import FloatArray, broken

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
    estimates: bool = False,
) -> Rollout:
    """Run a policy through episodes, all of them side by side, to their full length.

    PyTorch, if a policy uses it, has one thread meanwhile: :func:`~ftac_gym.evaluation.threads.one_torch_thread`.

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
    estimates
        Whether to record the policy's estimates of the faults.

    Raises
    ------
    ValueError
        If a name is unknown, or the policy or the episodes do not fit the scenario. If estimates are to be recorded
        and the policy has none.
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
    log = _EstimateLog(runner, steps, policy_label(policy)) if estimates else None
    with one_torch_thread():
        for step in range(steps + 1):
            for name, values in _truth(runner).items():
                histories[name][step] = values
            if recorder is not None:
                recorder(step, runner)
            if step < steps:
                rewards[step] = runner.step(log)
                command[step] = simulator.last_command
    return Rollout(
        scenario=task,
        episodes=drawn,
        time=np.arange(steps + 1, dtype=np.float64) * task.control_period,
        command=command,
        applied_torque=-np.diff(histories["wheel_momentum"], axis=0) / task.control_period,
        reward=rewards,
        estimates=None if log is None else log.recorded,
        **histories,
    )


class _EstimateLog:
    """Estimates of a runner's policy in T control periods, one more with each call.

    Parameters
    ----------
    runner
        The runner.
    steps
        Number of control periods T.
    name
        Name of the policy in messages.
    """

    def __init__(self, runner: PolicyRunner, steps: int, name: str) -> None:
        self._runner, self._steps, self._name, self._calls = runner, steps, name, 0
        self._parts: dict[str, Any] = {}

    def __call__(self) -> None:
        """Record the estimates; a ValueError if there are none."""
        estimate = self._runner.estimate
        if estimate is None:
            raise broken("policy", "must estimate faults where estimates are recorded", self._name)
        if not self._calls:
            simulator = self._runner.env.batch.simulator
            estimate.check(*simulator.last_command.shape)
            given = {item.name: getattr(estimate, item.name) for item in fields(FaultEstimate)}
            known = {name: np.asarray(values) for name, values in given.items() if values is not None}
            self._parts = {name: np.empty((self._steps, *row.shape), row.dtype) for name, row in known.items()}
        for name, rows in self._parts.items():
            rows[self._calls] = getattr(estimate, name)
        self._calls += 1

    @property
    def recorded(self) -> FaultEstimate:
        """The estimates, (T, N, ...); the parts are the same in every period."""
        return FaultEstimate(**self._parts)


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
