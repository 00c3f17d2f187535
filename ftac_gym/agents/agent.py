"""A trained agent: the network, its normaliser and its interface, in memory and on disk."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
from gymnasium.vector import VectorEnv

from ftac_gym import baselines
from ftac_gym.agents.interface import Interface
from ftac_gym.agents.normalizer import Normalizer
from ftac_gym.agents.storage import read_agent, write_agent
from ftac_gym.baselines import tuned
from ftac_gym.baselines.synthesis import designs
from ftac_gym.envs import SpacecraftFTCVectorEnv
from ftac_gym.utils.parameters import require
from ftac_gym.wrappers.action_hold import held_decision

if TYPE_CHECKING:
    from stable_baselines3.common.base_class import BaseAlgorithm
    from stable_baselines3.common.policies import BasePolicy


@dataclass(frozen=True, eq=False)
class Agent:
    """A trained policy with its normaliser.

    Parameters
    ----------
    policy
        Stable-Baselines3's policy, which is the network.
    normalizer
        Standardisation of its observations; None for raw ones.
    interface
        Interface of the network.
    fingerprint
        Equal for agents that act alike: stored results are found by it. It covers network, normaliser, interface, and
        the data of this package that the interface refers to. None if the agent has no files, or a custom base.
    """

    policy: BasePolicy
    normalizer: Normalizer | None
    interface: Interface
    fingerprint: str | None = None

    @property
    def tier(self) -> str:
        """Information tier of its observation."""
        return self.interface.observation

    @property
    def information(self) -> str:
        """Information tier of its inputs, with those of wrappers and bases."""
        return self.interface.information

    @classmethod
    def of(cls, model: BaseAlgorithm, interface: Interface | None = None) -> Agent:
        """Return the agent of a model in memory, with the present statistics of its ``VecNormalize``.

        The network is the model's own: it goes on learning with the model.

        Parameters
        ----------
        model
            A model of Stable-Baselines3.
        interface
            Interface of its network; by default it acts directly, in the attitude tier.
        """
        normalizer = Normalizer.of(model.get_vec_normalize_env())
        return cls(model.policy, normalizer, Interface() if interface is None else interface)

    @classmethod
    def load(cls, folder: str | Path) -> Agent:
        """Load an agent. Its files are data: nothing in them is executed, and no global state changes.

        Parameters
        ----------
        folder
            A folder with ``card.json`` and the weights that it names.

        Raises
        ------
        ValueError
            If a file is missing, damaged, or of another version; the message is one line with the file and the remedy.
        MissingExtra
            If Stable-Baselines3 is not installed.
        """
        stored = read_agent(Path(folder))
        return cls(stored.policy, stored.normalizer, stored.interface, _fingerprint(stored.digest, stored.interface))

    def save(self, folder: str | Path, **provenance: Any) -> None:
        """Write the agent to a folder, in the place of an earlier one.

        Parameters
        ----------
        folder
            The folder, which is created. Its other files stay.
        **provenance
            Origin of the agent for its card; names are those of :data:`ftac_gym.agents.storage.PROVENANCE`.

        Raises
        ------
        ValueError
            If the network cannot be written as data, or the origin has another entry.
        """
        write_agent(Path(folder), self.policy, self.normalizer, self.interface, provenance)

    def attach(self, env: SpacecraftFTCVectorEnv) -> VectorEnv[Any, Any, Any]:
        """Wrap a vector environment for this agent.

        Raises
        ------
        ValueError
            If the agent's spaces do not fit the environment.
        """
        wrapped = self.interface.wrap(env)
        given, trained = wrapped.single_observation_space.shape, self.observation_size
        rule = f"must have been trained on observations of {given[0]} entries, as {env.scenario.name} gives in the "
        rule += f"{self.tier} tier: fly it on the scenario of its card, or train one for this"
        require(given == (trained,), "agent", rule, trained)
        actions, trained_actions = wrapped.single_action_space.shape, self.policy.action_space.shape
        rule = f"must have been trained for actions {actions}, as {env.scenario.name} takes"
        require(actions == trained_actions, "agent", rule, trained_actions)
        if self.normalizer is not None:
            self.normalizer.check_size(self._whole_size)
        return wrapped

    @property
    def observation_size(self) -> int:
        """Entries of the observation that the agent is given: those of its actor."""
        return int(getattr(self.policy, "actor_size", self._whole_size))

    @property
    def _whole_size(self) -> int:
        """Entries of the observation of the network, with those for a critic that sees the faults."""
        return (self.policy.observation_space.shape or (0,))[0]

    def predict(
        self, observation: npt.NDArray[Any], state: Any = None, episode_start: Any = None, deterministic: bool = True
    ) -> tuple[npt.NDArray[Any], Any]:
        """Return the actions (N, k) for raw observations (N, size), and the state, as Stable-Baselines3 does.

        The state holds for every spacecraft the control periods until the next decision and the action held, and the
        memory of a recurrent network.
        """
        none = np.zeros(len(observation), dtype=np.bool_)
        start = none if episode_start is None else np.asarray(episode_start, dtype=np.bool_)

        def decide(memory: Any) -> Any:
            # The entries for the critic alone are zero in flight.
            padded = np.pad(observation, ((0, 0), (0, self._whole_size - self.observation_size)))
            if self.normalizer is not None:
                padded = self.normalizer.normalize(padded)
            return self.policy.predict(padded, memory, start, deterministic)

        return held_decision(decide, self.interface.hold, state, start)


def _fingerprint(digest: str, interface: Interface) -> str | None:
    """Return the fingerprint of an agent with this digest of its files."""
    # The files do not hold the code of a custom base.
    if any(base not in baselines.names() for base in interface.bases):
        return None
    tuned_gains = [tuned.gains(*base) for base in interface.tuned_bases]
    parts = [digest.encode(), json.dumps(tuned_gains, sort_keys=True).encode(), *designs.stored_files().values()]
    return hashlib.sha256(b"".join(parts)).hexdigest()
