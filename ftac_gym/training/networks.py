"""Policy whose critic observes more than its actor."""

from __future__ import annotations

from typing import Any

import torch
from stable_baselines3.common.policies import ActorCriticPolicy
from stable_baselines3.common.torch_layers import MlpExtractor
from torch import nn

from ftac_gym.utils.parameters import require


class _TwoViews(MlpExtractor):
    """Hidden layers of an actor with the first entries of the observation, and of a critic with all."""

    def __init__(
        self, features: int, actor_size: int, layers: dict[str, list[int]], activation: type[nn.Module]
    ) -> None:
        super().__init__(actor_size, {"pi": layers["pi"], "vf": []}, activation)
        critic = MlpExtractor(features, {"pi": [], "vf": layers["vf"]}, activation)
        self.value_net, self.latent_dim_vf = critic.value_net, critic.latent_dim_vf
        self._actor_size = actor_size

    def forward_actor(self, features: torch.Tensor) -> torch.Tensor:
        """Return the features of the actor, from its part of the observation."""
        return super().forward_actor(features[:, : self._actor_size])


class PrivilegedCriticPolicy(ActorCriticPolicy):
    """PPO's policy for asymmetric information: the first entries of the observation for the actor, all for the critic.

    The critic is needed in training alone, where the truth about the faults is available and improves its estimates.
    The actor does not depend on the truth, which is not available in flight (Pinto et al. 2018, asymmetric
    actor-critic). The policy can be named in a file of hyperparameters, as all of Stable-Baselines3's.

    Parameters
    ----------
    *args, **kwargs
        Those of Stable-Baselines3's ``ActorCriticPolicy``; ``net_arch`` must be a dict with "pi" and "vf".
    actor_size
        Number of entries for the actor.

    Raises
    ------
    ValueError
        If the observation has fewer entries, or ``net_arch`` is no dict with "pi" and "vf".
    """

    def __init__(self, *args: Any, actor_size: int, **kwargs: Any) -> None:
        self.actor_size = actor_size
        super().__init__(*args, **kwargs)

    def _build_mlp_extractor(self) -> None:
        fits = 0 < self.actor_size <= self.features_dim
        require(fits, "actor_size", f"must be within 1 and the observation's {self.features_dim}", self.actor_size)
        layers = self.net_arch
        apart = isinstance(layers, dict) and set(layers) == {"pi", "vf"}
        require(apart, "net_arch", 'must be a dict with "pi" and "vf"', layers)
        assert isinstance(layers, dict)
        extractor = _TwoViews(self.features_dim, self.actor_size, layers, self.activation_fn)
        self.mlp_extractor = extractor.to(self.device)

    def _get_constructor_parameters(self) -> dict[str, Any]:
        return {**super()._get_constructor_parameters(), "actor_size": self.actor_size}
