"""Policies from outside of the package: functions, and objects with ``predict``."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium.vector import VectorEnv

from ftac_gym.agents.interface import Interface, wrapper_pairs
from ftac_gym.agents.normalizer import Normalizer
from ftac_gym.baselines import FaultEstimate
from ftac_gym.envs import SpacecraftFTCVectorEnv
from ftac_gym.utils.parameters import broken, flag, require
from ftac_gym.wrappers.action_hold import held_decision

Decision = Callable[[npt.NDArray[Any], Any, Any, bool], tuple[Any, Any]]
"""Function of observations (N, size), state, starts (N,) and determinism to actions (N, k) and the next state."""


class ExternalPolicy:
    """A function or an object with ``predict`` as a policy, with the observation and the hold that it is made for.

    Parameters
    ----------
    source
        One of

        - an object whose ``predict(observation, state=, episode_start=, deterministic=)`` is that of
          Stable-Baselines3: observations (N, size) to actions (N, k) and the next state;
        - an object whose ``predict(observation)`` takes the observation alone;
        - a function of the observation.

        The last two take the observation (size,) of one spacecraft and return its action (k,). Calls for different
        spacecraft alternate, so that they must not remember anything from one call to the next.
    observation
        Information tier; by default ``source.tier`` if there is one, else ``"attitude"``.
    hold
        Control periods for which every action is held.
    normalizer
        Standardisation of the observations, :meth:`Normalizer.of <ftac_gym.agents.normalizer.Normalizer.of>` a
        ``VecNormalize`` for example; None for raw ones.
    wrappers
        Name in :mod:`ftac_gym.wrappers` and arguments of each wrapper, the innermost first.
    batched
        Whether a function, or a ``predict`` of the observation alone, takes all observations (N, size) at once and
        returns all actions (N, k).

    Raises
    ------
    ValueError
        If the source is neither, its ``predict`` has other parameters, or a value is refused.
    """

    fingerprint = None

    def __init__(
        self,
        source: Any,
        observation: str | None = None,
        hold: int = 1,
        normalizer: Normalizer | None = None,
        wrappers: Sequence[Any] = (),
        batched: bool = False,
    ) -> None:
        tier = getattr(source, "tier", "attitude") if observation is None else observation
        self.interface = Interface(tier, wrapper_pairs(wrappers), hold)
        standard = normalizer is None or isinstance(normalizer, Normalizer)
        require(standard, "normalizer", "must be a Normalizer or None: Normalizer.of(vec_normalize)", normalizer)
        self.normalizer = normalizer
        self.source = source
        self._batched = flag(batched, "batched")
        self._standard = _checked(source)

    @property
    def tier(self) -> str:
        """Information tier of its observation."""
        return self.interface.observation

    @property
    def information(self) -> str:
        """Information tier of its inputs, with those of wrappers and bases."""
        return self.interface.information

    @property
    def estimator(self) -> ExternalPolicy:
        """The source of its fault estimates: itself."""
        return self

    @property
    def estimate(self) -> FaultEstimate | None:
        """The latest ``estimate`` of the source, a :class:`~ftac_gym.baselines.FaultEstimate`; None without one."""
        found = getattr(self.source, "estimate", None)
        rule = "must be a FaultEstimate or None, not a method"
        require(found is None or isinstance(found, FaultEstimate), "estimate of the policy", rule, found)
        return found

    def attach(self, env: SpacecraftFTCVectorEnv) -> VectorEnv[Any, Any, Any]:
        """Wrap a vector environment for this policy.

        Raises
        ------
        ValueError
            If the source has an ``observation_space`` or ``action_space`` of another shape.
        """
        wrapped = self.interface.wrap(env)
        for part in ("observation_space", "action_space"):
            known = getattr(getattr(self.source, part, None), "shape", None)
            given = getattr(wrapped, f"single_{part}").shape
            rule = f"must have the {part.replace('_', ' ')} {given}, as {env.scenario.name} in the {self.tier} tier"
            require(known in (None, given), "policy", rule, known)
        if self.normalizer is not None:
            self.normalizer.check_size(wrapped.single_observation_space.shape[0])
        return wrapped

    def predict(
        self, observation: Any, state: Any = None, episode_start: Any = None, deterministic: bool = True
    ) -> tuple[Any, Any]:
        """Return the actions (N, k) for raw observations (N, size), and the state, as Stable-Baselines3 does.

        The state holds the control periods until the next decision, the action held, and the state of the source.
        """
        count = len(observation)
        start = np.zeros(count, dtype=np.bool_) if episode_start is None else np.asarray(episode_start, dtype=np.bool_)

        def decide(memory: Any) -> tuple[Any, Any]:
            given = observation if self.normalizer is None else self.normalizer.normalize(observation)
            if self._standard:
                answer = self.source.predict(given, state=memory, episode_start=start, deterministic=deterministic)
                pair = isinstance(answer, tuple) and len(answer) == 2
                require(pair, "policy", "must return actions and state from predict", answer)
                return answer
            act = getattr(self.source, "predict", self.source)
            if self._batched:
                return _action(act(given)), None
            return np.stack([_action(act(row)) for row in given]), None

        return held_decision(decide, self.interface.hold, state, start)


def _action(answer: Any) -> npt.NDArray[Any]:
    """Return the action of an answer, which may be an action, or an action and a state that is not needed."""
    stated = isinstance(answer, tuple) and len(answer) > 0 and np.ndim(answer[0]) > 0
    return np.asarray(answer[0] if stated else answer)


def _checked(source: Any) -> bool:
    """Tell whether a source has Stable-Baselines3's ``predict``; raise a ValueError if it cannot act at all."""
    predict = getattr(source, "predict", None)
    if predict is None:
        require(callable(source), "policy", "must be a function or an object with predict", source)
        return False
    rule = "must have predict(observation), or predict(observation, state=, episode_start=, deterministic=)"
    try:
        parameters = inspect.signature(predict)
    except (TypeError, ValueError):
        raise broken("policy", rule, predict) from None
    if _takes(parameters, state=None, episode_start=None, deterministic=True):
        return True
    require(_takes(parameters), "policy", rule, f"predict{parameters}")
    return False


def _takes(parameters: inspect.Signature, **keywords: Any) -> bool:
    try:
        parameters.bind(None, **keywords)
    except TypeError:
        return False
    return True
