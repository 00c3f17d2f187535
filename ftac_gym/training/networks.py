"""A policy whose critic knows more than its actor."""

from __future__ import annotations

from typing import Any

import torch
from stable_baselines3.common.policies import ActorCriticPolicy
from stable_baselines3.common.torch_layers import MlpExtractor
from torch import nn

from ftac_gym.utils.parameters import require


class _TwoViews(nn.Module):
    """Hidden layers of an actor that sees the first entries, and of a critic that sees all."""

    def __init__(
        self, features: int, actor_size: int, layers: dict[str, list[int]], activation: type[nn.Module]
    ) -> None:
        super().__init__()
        self._actor_size = actor_size
        self.policy_net = MlpExtractor(actor_size, {"pi": layers["pi"], "vf": []}, activation).policy_net
        self.value_net = MlpExtractor(features, {"pi": [], "vf": layers["vf"]}, activation).value_net
        self.latent_dim_pi = layers["pi"][-1] if layers["pi"] else actor_size
        self.latent_dim_vf = layers["vf"][-1] if layers["vf"] else features

    def forward(self, features: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """Return what actor and critic make of an observation."""
        return self.forward_actor(features), self.forward_critic(features)

    def forward_actor(self, features: torch.Tensor) -> torch.Tensor:
        """Return what the actor makes of its part."""
        latent: torch.Tensor = self.policy_net(features[:, : self._actor_size])
        return latent

    def forward_critic(self, features: torch.Tensor) -> torch.Tensor:
        """Return what the critic makes of the whole."""
        latent: torch.Tensor = self.value_net(features)
        return latent


class PrivilegedCriticPolicy(ActorCriticPolicy):
    """PPO's policy for asymmetric information: the actor sees the first entries of the observation, the critic all.

    The critic is needed in training alone, where the truth about the faults is known; its advice is better for it, and
    the actor cannot come to rely on what no craft can know (Pinto et al. 2018, asymmetric actor-critic). Like every
    policy of Stable-Baselines3 it can be named in a file of hyperparameters.

    Parameters
    ----------
    *args, **kwargs
        Those of Stable-Baselines3's ``ActorCriticPolicy``; ``net_arch`` must be a dict with "pi" and "vf".
    actor_size
        How many entries the actor sees.

    Raises
    ------
    ValueError
        If the observation has fewer entries, or ``net_arch`` is none that tells actor and critic apart.
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
        extractor: Any = _TwoViews(self.features_dim, self.actor_size, layers, self.activation_fn).to(self.device)
        self.mlp_extractor = extractor

    def _get_constructor_parameters(self) -> dict[str, Any]:
        return {**super()._get_constructor_parameters(), "actor_size": self.actor_size}
