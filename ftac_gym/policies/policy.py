"""The interface of everything that acts, and baselines that wait for their environment."""

import json
from pathlib import Path
from typing import Any, Protocol

from gymnasium.vector import VectorEnv

from ftac_gym import baselines
from ftac_gym.baselines import tuned
from ftac_gym.baselines.custom import label
from ftac_gym.envs import SpacecraftFTCVectorEnv
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray

TUNED = " tuned"
"""Suffix of a baseline's name that selects its tuned gains."""


def named_gains(text: str) -> tuple[str, str | None]:
    """Return name and gains of a text: ``"NAME tuned"`` or ``"NAME FILE.json"`` for a baseline, else text and None."""
    name, _, gains = text.partition(" ")
    named = baselines.is_baseline(name) and (gains == TUNED.strip() or tuned.is_file(gains))
    return (name, gains) if named else (text, None)


class Policy(Protocol):
    """Anything that acts on N spacecraft, once it is attached to their environment.

    One that estimates faults has an attribute ``estimator`` besides: an object with ``estimate``, the latest
    :class:`~ftac_gym.baselines.FaultEstimate` or None, and ``information``, the tier of the inputs of the estimate.
    """

    @property
    def tier(self) -> str:
        """Information tier of its observation."""

    def attach(self, env: SpacecraftFTCVectorEnv) -> VectorEnv[Any, Any, Any]:
        """Return the environment with the wrappers that the policy needs."""

    def predict(self, observation: Any, state: Any, episode_start: Any, deterministic: bool) -> tuple[Any, Any]:
        """Return actions and state for observations, as Stable-Baselines3 does."""


class DeferredBaseline:
    """A baseline with its gains, built when it is attached to an environment.

    Parameters
    ----------
    name
        Name of a baseline, a subclass of :class:`~ftac_gym.baselines.Baseline`, or its path as ``"module:Class"``.
    gains
        ``"default"``, ``"tuned"`` or a file, as for :func:`ftac_gym.baselines.make`; custom classes have default gains
        only.
    **changes
        Gains that differ from these.

    Raises
    ------
    ValueError
        If the name is unknown or the baseline has no such gains.
    """

    tier = "attitude"
    baseline: baselines.Baseline
    """Baseline for the environment, from :meth:`attach` on."""

    def __init__(self, name: baselines.BaselineLike, gains: str = "default", **changes: Any) -> None:
        self.name, self.gains = name, gains
        # The name of tuned gains does not identify their values, so they are read once, here.
        self._gains = baselines.chosen(name, gains, changes)
        known = name in baselines.names()
        self.fingerprint = json.dumps([name, self._gains], sort_keys=True) if known else None
        """Equal for equal policies: stored results are found by it. None for custom classes."""

    @property
    def estimator(self) -> baselines.Baseline:
        """The source of its fault estimates: the baseline, once it is attached."""
        return self.baseline

    def attach(self, env: SpacecraftFTCVectorEnv) -> VectorEnv[Any, Any, Any]:
        """Build the baseline for the spacecraft of an environment, which is returned unchanged."""
        self.baseline = baselines.build(self.name, env.scenario, env.num_envs, **self._gains)
        self._policy = baselines.BaselinePolicy(self.baseline, env)
        return env

    def check_period(self, scenario: Scenario) -> None:
        """Warn if the control period of a scenario is too long for the gains.

        Warns
        -----
        SampledInstability
            Once for each set of gains and scenario.
        """
        baselines.make(self.name, scenario, **self._gains)

    def predict(
        self, observation: Any, state: Any = None, episode_start: Any = None, deterministic: bool = True
    ) -> tuple[FloatArray, None]:
        """Return the actions (N, wheels); the policy must be attached."""
        return self._policy.predict(observation, state, episode_start, deterministic)


def check_task(policy: Policy, scenario: Scenario) -> None:
    """Let a policy that is bound to a task refuse another one.

    Raises
    ------
    ValueError
        If the policy has a method ``check_task``, and it refuses the scenario.
    """
    check = getattr(policy, "check_task", None)
    if check is not None:
        check(scenario)


def policy_label(policy: Any) -> str:
    """Return the name of a policy in messages and tables: its text, its own name, or that of its class."""
    if isinstance(policy, (str, Path)):
        return str(policy)
    if isinstance(policy, DeferredBaseline):
        return label(policy.name) + ("" if policy.gains == "default" else f" {policy.gains}")
    name = getattr(policy, "__name__", None) or getattr(policy, "name", None)
    return name if isinstance(name, str) else type(policy).__name__
