"""A trained agent on disk: the model, its normaliser, and a card with its interface and origin."""

from __future__ import annotations

import hashlib
import json
import pickle
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
from gymnasium.vector import VectorEnv

from ftac_gym import baselines, wrappers
from ftac_gym.baselines import observers
from ftac_gym.envs import SpacecraftFTCVectorEnv
from ftac_gym.envs.observation import TIERS
from ftac_gym.utils.parameters import require
from ftac_gym.wrappers.action_hold import held_decision

if TYPE_CHECKING:
    from stable_baselines3.common.base_class import BaseAlgorithm
    from stable_baselines3.common.vec_env import VecNormalize

MODEL_FILE, NORMALIZER_FILE, CARD_FILE = "model.zip", "normalizer.pkl", "card.json"
"""Files of an agent."""

WRAPPERS = ("FaultEstimateObservation", "GainScheduling", "ObservationHistory", "ResidualPolicy")
"""Wrappers of which an interface can consist."""

ON_BASE = ("GainScheduling", "ResidualPolicy")
"""Wrappers through which an agent acts on a base, whose own action is an action of zero."""


@dataclass(frozen=True)
class Interface:
    """Observation and meaning of the action of a policy network.

    Parameters
    ----------
    observation
        Information tier.
    wrappers
        Name in :mod:`ftac_gym.wrappers` and arguments of each wrapper, the innermost first. A base that is a class is
        stored as ``"module:Class"``, so that a card can hold the interface.
    hold
        Control periods for which every action is held.
    critic_sees_faults
        Whether the truth about the faults is at the end of the observation, for the critic alone. The actor of such a
        model has no path from it (:mod:`ftac_gym.training.networks`), and it is zero when the agent flies.

    Raises
    ------
    ValueError
        If a wrapper is unknown, or a base is a class that cannot be imported.
    """

    observation: str = "attitude"
    wrappers: tuple[tuple[str, dict[str, Any]], ...] = ()
    hold: int = 1
    critic_sees_faults: bool = False

    def __post_init__(self) -> None:
        """Check the wrappers, which are lists if they come from a file."""
        written = tuple((name, dict(arguments)) for name, arguments in self.wrappers)
        object.__setattr__(self, "wrappers", written)
        for name, arguments in written:
            require(name in WRAPPERS, "wrappers", f"must be among {list(WRAPPERS)}", name)
            if "base" in arguments:
                arguments["base"] = baselines.path_of(arguments["base"])
        require(isinstance(self.hold, int) and self.hold > 0, "hold", "must be a positive integer", self.hold)

    @property
    def information(self) -> str:
        """Information tier of the actor's inputs: that of the observation, or of a wrapper or base with more."""
        tiers = {self.observation}
        for name, given in self.wrappers:
            base, arguments = base_of(name, given), given
            if base is not None:
                tiers.add(baselines.baseline_class(base).information)
                arguments = {**baselines.defaults(base), **given}
            source = arguments.get("source", arguments.get("faults"))
            if source == "truth":
                tiers.add("oracle")
            elif source in observers.names():
                tiers.add(observers.information(source))
            if arguments.get("telemetry"):
                tiers.add("telemetry")
        return max(tiers, key=TIERS.index)

    @property
    def bases(self) -> tuple[str, ...]:
        """Baselines through which the agent acts."""
        found = (base_of(name, given) for name, given in self.wrappers)
        return tuple(base for base in found if base is not None)

    def wrap(self, env: Any) -> Any:
        """Return an environment, single or vector, with the wrappers."""
        for name, arguments in self.wrappers:
            env = getattr(wrappers, name)(env, **arguments)
        return env

    def wrap_for_training(self, env: Any) -> Any:
        """Return an environment with the wrappers, and with the truth for a critic that sees the faults."""
        env = self.wrap(env)
        return wrappers.FaultEstimateObservation(env, "truth") if self.critic_sees_faults else env


def base_of(wrapper: str, arguments: Mapping[str, Any]) -> str | None:
    """Return the base on which an agent acts through a wrapper with these arguments; None if it has none."""
    return arguments.get("base", "pd_dob") if wrapper in ON_BASE else None


@dataclass(frozen=True, eq=False)
class Agent:
    """A trained policy with its normaliser.

    Parameters
    ----------
    model
        The Stable-Baselines3 model.
    normalizer
        The ``VecNormalize`` of its training; None for raw observations.
    interface
        Interface of the policy network.
    fingerprint
        Equal for equal agents: stored results are found by it. None if the agent has no file, or a custom base.
    """

    model: BaseAlgorithm
    normalizer: VecNormalize | None
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
    def load(cls, path: str | Path) -> Agent:
        """Load an agent.

        Parameters
        ----------
        path
            A folder with ``model.zip``, ``normalizer.pkl`` and ``card.json``, or a Stable-Baselines3 zip file with or
            without the other two beside it. Without a card the agent acts directly, in the attitude tier.

        Raises
        ------
        ValueError
            If there is no model, the card is not of this version, or the normaliser of the card is missing.
        ImportError
            If Stable-Baselines3 is not installed.
        """
        path = Path(path)
        model_path = path / MODEL_FILE if path.is_dir() else path
        require(model_path.is_file(), "agent", "must be a folder with model.zip, or a zip file", str(path))
        files = [model_path, model_path.with_name(CARD_FILE), model_path.with_name(NORMALIZER_FILE)]
        _, card, normalizer = contents = [file.read_bytes() if file.is_file() else b"" for file in files]
        fields: dict[str, Any] = {"interface": {}}
        try:
            fields = json.loads(card) if card else fields
            interface = Interface(**fields["interface"])
        except (KeyError, TypeError, json.JSONDecodeError) as error:
            rule = f"must be of this version: {error}; train the agent again"
            raise ValueError(f"agent: {files[1]} {rule}") from None
        rule = f"must have {NORMALIZER_FILE} beside it, as its card says: copy it from the folder of its training"
        require(bool(normalizer) or not fields.get("normalized"), "agent", rule, str(model_path))
        # The files do not hold the code of a custom base.
        custom = any(base not in baselines.names() for base in interface.bases)
        fingerprint = None if custom else hashlib.sha256(b"".join(contents)).hexdigest()
        agent = cls(load_model(model_path), pickle.loads(normalizer) if normalizer else None, interface, fingerprint)
        if agent.normalizer is not None:
            agent.normalizer.training = False
        return agent

    def attach(self, env: SpacecraftFTCVectorEnv) -> VectorEnv[Any, Any, Any]:
        """Wrap a vector environment for this agent.

        Raises
        ------
        ValueError
            If the agent's spaces do not fit the environment.
        """
        wrapped = self.interface.wrap(env)
        given, trained = wrapped.single_observation_space.shape, self._sizes[1]
        rule = f"must have been trained on observations of {given[0]} entries, as {env.scenario.name} gives in the "
        rule += f"{self.tier} tier: fly it on the scenario of its card, or train one for this"
        require(given == (trained,), "agent", rule, trained)
        actions, trained_actions = wrapped.single_action_space.shape, self.model.action_space.shape
        rule = f"must have been trained for actions {actions}, as {env.scenario.name} takes"
        require(actions == trained_actions, "agent", rule, trained_actions)
        return wrapped

    @property
    def _sizes(self) -> tuple[int, int]:
        """Entries of the observation for the model and for its actor, without those for the critic alone."""
        whole = (self.model.observation_space.shape or (0,))[0]
        return whole, int(getattr(self.model.policy, "actor_size", whole))

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
            whole, actor = self._sizes
            # The entries for the critic alone are zero in flight.
            padded = np.pad(observation, ((0, 0), (0, whole - actor)))
            if self.normalizer is not None:
                padded = np.asarray(self.normalizer.normalize_obs(padded))
            return self.model.predict(padded, memory, start, deterministic)

        return held_decision(decide, self.interface.hold, state, start)


def load_model(
    path: Path,
    env: Any = None,
    kind: Callable[[type[BaseAlgorithm]], type[BaseAlgorithm]] | None = None,
    **changes: Any,
) -> BaseAlgorithm:
    """Load a model of any algorithm that agents are trained with; the file names it.

    Parameters
    ----------
    path
        The zip file.
    env
        Environment for further training, or None.
    kind
        Function from the class of the algorithm to the one to build, or None for itself.
    **changes
        Objects to use instead of those in the file.

    Raises
    ------
    ImportError
        If the model is of sb3-contrib, which is not installed.
    """
    import stable_baselines3 as sb3
    from stable_baselines3.common.save_util import load_from_zip_file

    data, _, _ = load_from_zip_file(path, device="cpu")
    module = data["policy_class"].__module__ if data is not None else ""
    kinds: dict[str, type[BaseAlgorithm]] = {"sac": sb3.SAC, "td3": sb3.TD3, "dqn": sb3.DQN}
    if module.startswith("sb3_contrib"):
        import sb3_contrib

        kinds |= {"tqc": sb3_contrib.TQC, "recurrent": sb3_contrib.RecurrentPPO}
    # PPO and A2C share their policies; for prediction it does not matter which of them trained.
    algorithm = next((found for name, found in kinds.items() if f".{name}." in module), sb3.PPO)
    built = algorithm if kind is None else kind(algorithm)
    return built.load(path, env=env, device="cpu", custom_objects=changes or None)
