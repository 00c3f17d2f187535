"""Actors of TorchRL and tensordict."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from ftac_gym.agents.normalizer import Normalizer
from ftac_gym.policies.external import ExternalPolicy
from ftac_gym.utils.parameters import require


def is_tensordict_module(policy: Any) -> bool:
    """Tell whether an object is a module of tensordict, such as every actor of TorchRL; nothing is imported."""
    library = sys.modules.get("tensordict.nn")
    return library is not None and isinstance(policy, library.TensorDictModuleBase)


def from_torchrl(
    actor: Any,
    observation: str = "attitude",
    hold: int = 1,
    normalizer: Normalizer | None = None,
    wrappers: Sequence[Any] = (),
    key: str = "observation",
) -> ExternalPolicy:
    """Return an actor of TorchRL as a policy: a ``ProbabilisticActor`` or any ``TensorDictModule``.

    It acts as under ``set_exploration_type(ExplorationType.DETERMINISTIC)``, without gradients. For an actor in a file,
    name a function that builds it and loads its weights: ``"module:function()"``.

    Parameters
    ----------
    actor
        The actor, from ``key`` to ``"action"``. Transforms of its environment, such as ``ObservationNorm``, are no
        part of it: put them before it with ``TensorDictSequential``, or give their numbers as ``normalizer``.
    observation
        Information tier on which it was trained.
    hold
        Control periods for which every action was held.
    normalizer
        Standardisation of the observations.
    wrappers
        Name in :mod:`ftac_gym.wrappers` and arguments of each wrapper of the training, the innermost first.
    key
        Name of the observation among the actor's inputs.

    Raises
    ------
    ValueError
        If the actor is no module of tensordict, takes other inputs, such as the memory of a recurrent network, or has
        no action.
    """
    require(is_tensordict_module(actor), "actor", "must be a TensorDictModule", actor)
    require(list(actor.in_keys) == [key], "actor", f"must take {key!r} alone: its in_keys", list(actor.in_keys))
    require("action" in actor.out_keys, "actor", "must write 'action': its out_keys", list(actor.out_keys))
    return ExternalPolicy(_Actor(actor, key), observation, hold, normalizer, wrappers, batched=True)


class _Actor:
    """An actor as a function of arrays."""

    def __init__(self, actor: Any, key: str) -> None:
        self._actor, self._key = actor, key

    def __call__(self, observations: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """Return the actions (N, k) for observations (N, size)."""
        import torch
        from tensordict import TensorDict
        from tensordict.nn import InteractionType, set_interaction_type

        device = next((item.device for item in self._actor.parameters()), torch.device("cpu"))
        given = torch.as_tensor(np.asarray(observations, dtype=np.float32), device=device)
        with torch.no_grad(), set_interaction_type(InteractionType.DETERMINISTIC):
            answer = self._actor(TensorDict({self._key: given}, batch_size=[len(given)]))
        return np.asarray(answer["action"].cpu())
