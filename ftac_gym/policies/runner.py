"""Control of N spacecraft by a policy, one control period at a time."""

from collections.abc import Callable
from copy import copy
from typing import Any

import numpy as np
from gymnasium.vector import VectorWrapper

from ftac_gym.baselines import FaultEstimate
from ftac_gym.envs import SpacecraftFTCVectorEnv
from ftac_gym.policies.policy import DeferredBaseline, Policy
from ftac_gym.task.episodes import Episodes
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray


class _Flight(SpacecraftFTCVectorEnv):
    """The environment of a policy that is flown, with a ``DivergenceError`` for one that turns too fast.

    The papers' examples with unlimited wheels are sound under their controllers, not under full torque.
    """

    full_torque = False
    acted: Callable[[], None] | None = None
    """Function to call once the command of a period is known, before the period; None for none."""

    def step(self, actions: Any) -> Any:
        """Step all spacecraft; see the base class."""
        if self.acted is not None:
            self.acted()
        return super().step(actions)


class PolicyRunner:
    """A policy attached to N spacecraft; tumbling does not end their episodes.

    Parameters
    ----------
    scenario
        The task.
    policy
        What acts.
    num_spacecraft
        Number of spacecraft N.
    threads
        Threads of the simulator.

    Raises
    ------
    ValueError
        If the policy does not fit the scenario.
    """

    def __init__(self, scenario: Scenario, policy: Policy, num_spacecraft: int = 1, threads: int = 1) -> None:
        # A baseline is built for an environment: one that flies elsewhere too stays as it is.
        self.policy = copy(policy) if isinstance(policy, DeferredBaseline) else policy
        self.env = _Flight(
            num_envs=num_spacecraft,
            scenario=scenario.replace(tumble_rate=None),
            observation=policy.tier,
            autoreset_mode="Disabled",
            threads=threads,
        )
        """The environment without the policy's wrappers."""
        self._wrapped = self.policy.attach(self.env)
        self._observation: Any = None
        self._state: Any = None
        self._start = np.ones(num_spacecraft, dtype=np.bool_)

    def reset(self, episodes: Episodes) -> None:
        """Start episodes, one for each spacecraft."""
        self._observation, _ = self._wrapped.reset(options={"episodes": episodes})
        self._state, self._start = None, np.ones(len(episodes), dtype=np.bool_)

    @property
    def estimator(self) -> Any:
        """The first source of fault estimates among policy, base and wrappers, the outermost first; None without one.

        It has ``estimate`` and ``information``; see :class:`~ftac_gym.policies.policy.Policy`.
        """
        found, layer = [getattr(self.policy, "estimator", None)], self._wrapped
        while isinstance(layer, VectorWrapper):
            found.append(getattr(getattr(layer, "transform", None), "estimator", None))
            layer = layer.env
        return next((item for item in found if item is not None and item.estimate is not None), None)

    @property
    def estimate(self) -> FaultEstimate | None:
        """The latest estimate of the faults; None for a policy that does not estimate them."""
        return None if self.estimator is None else self.estimator.estimate

    def step(self, acted: Callable[[], None] | None = None) -> FloatArray:
        """Act for one control period and return the rewards (N,).

        Parameters
        ----------
        acted
            Called between command and period: the policy and all estimates have processed the measurement at the start
            of the period.
        """
        self.env.acted = acted
        action, self._state = self.policy.predict(self._observation, self._state, self._start, True)
        self._start = np.zeros_like(self._start)
        self._observation, rewards, *_ = self._wrapped.step(action)
        return np.asarray(rewards)
