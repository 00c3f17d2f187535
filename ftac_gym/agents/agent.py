"""A trained agent on disk: the policy, its normaliser, and a card that says how it was made."""

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

MODEL_FILE = "model.zip"
NORMALIZER_FILE = "normalizer.pkl"
CARD_FILE = "card.json"

TRUTH = ("FaultEstimateObservation", {"source": "truth"})
"""The wrapper that shows what the faults really do."""


@dataclass(frozen=True)
class Interface:
    """What surrounds a policy network: the observation it sees and what its action means.

    Parameters
    ----------
    observation
        Information tier.
    wrappers
        Name in :mod:`ftac_gym.wrappers` and arguments of each wrapper, the innermost first. A base that is a class is
        kept as ``"module:Class"``, so that the interface can be written to a card.
    hold
        Control periods for which every action is held.
    critic_sees_faults
        Whether the truth about the faults stands at the end of the observation, for the critic alone: the actor of
        such a model does not look there (:mod:`ftac_gym.training.networks`), and it is zero when the agent flies.

    Raises
    ------
    ValueError
        If a wrapper is unknown, or a base is a class that cannot be imported from anywhere.
    """

    observation: str = "attitude"
    wrappers: tuple[tuple[str, dict[str, Any]], ...] = ()
    hold: int = 1
    critic_sees_faults: bool = False

    def __post_init__(self) -> None:
        """Check the wrappers, which may come as lists from a file."""
        written = tuple((name, _as_text(dict(arguments))) for name, arguments in self.wrappers)
        object.__setattr__(self, "wrappers", written)
        for name, _ in self.wrappers:
            require(name in WRAPPERS, "wrappers", f"must be among {list(WRAPPERS)}", name)
        require(isinstance(self.hold, int) and self.hold > 0, "hold", "must be a positive integer", self.hold)

    @property
    def information(self) -> str:
        """The tier of what the actor knows: the observation's, or more if a wrapper or its base knows more."""
        known = {self.observation}
        for name, given in self.wrappers:
            base = base_of(name, given)
            arguments = {**({} if base is None else baselines.defaults(base)), **given}
            if base is not None:
                known.add(baselines.baseline_class(base).information)
            source = arguments.get("source", arguments.get("faults"))
            if source == TRUTH[1]["source"]:
                known.add("oracle")
            elif source in observers.names():
                known.add(observers.information(source))
            if arguments.get("telemetry"):
                known.add("telemetry")
        return max(known, key=TIERS.index)

    @property
    def bases(self) -> tuple[str, ...]:
        """The laws through which the agent acts."""
        found = (base_of(name, given) for name, given in self.wrappers)
        return tuple(base for base in found if base is not None)

    def wrap(self, env: Any) -> Any:
        """Return the environment as the actor sees it, single or vector."""
        for name, arguments in self.wrappers:
            env = getattr(wrappers, name)(env, **arguments)
        return env

    def wrap_for_training(self, env: Any) -> Any:
        """Return the environment as the model is trained on it: for a critic that sees the faults, with the truth."""
        env = self.wrap(env)
        return wrappers.FaultEstimateObservation(env, **TRUTH[1]) if self.critic_sees_faults else env


WRAPPERS = ("FaultEstimateObservation", "GainScheduling", "ObservationHistory", "ResidualPolicy")
"""Wrappers that an interface may be made of."""

ON_BASE = ("GainScheduling", "ResidualPolicy")
"""Those through which an agent acts on a base, whose own action is an action of zero."""


def base_of(wrapper: str, arguments: Mapping[str, Any]) -> str | None:
    """Return the base through which an agent acts by a wrapper with these arguments; None if it has none."""
    return arguments.get("base", "pd_dob") if wrapper in ON_BASE else None


def _as_text(arguments: dict[str, Any]) -> dict[str, Any]:
    """Return the arguments of a wrapper with a base that is a class as text."""
    return {**arguments, "base": baselines.path_of(arguments["base"])} if "base" in arguments else arguments


class Agent:
    """A trained policy with its normaliser.

    Parameters
    ----------
    model
        The Stable-Baselines3 model.
    normalizer
        The normaliser it was trained with; None if it saw raw observations.
    interface
        What surrounds it.
    fingerprint
        Same for the same agent: finished batches of an evaluation are found by it. None if it has no file, or acts on
        a law that is not of this package.
    """

    def __init__(
        self,
        model: BaseAlgorithm,
        normalizer: VecNormalize | None,
        interface: Interface,
        fingerprint: str | None = None,
    ) -> None:
        self.fingerprint = fingerprint
        self.model = model
        self.normalizer = normalizer
        self.interface = interface

    @property
    def tier(self) -> str:
        """The information tier of the observation that it is given."""
        return self.interface.observation

    @property
    def information(self) -> str:
        """The tier of what it knows, wrappers included."""
        return self.interface.information

    @classmethod
    def load(cls, path: str | Path) -> Agent:
        """Load an agent.

        Parameters
        ----------
        path
            A folder with ``model.zip``, ``normalizer.pkl`` and ``card.json``, or a Stable-Baselines3 zip file beside
            which the other two may lie. Without a card the agent is taken to act directly, in the attitude tier.

        Raises
        ------
        ValueError
            If there is no model, the card is none of this version, or the card says that there is a normaliser and
            there is none.
        ImportError
            If Stable-Baselines3 is not installed.
        """
        path = Path(path)
        model_path = path / MODEL_FILE if path.is_dir() else path
        require(model_path.is_file(), "agent", "must be a folder with model.zip, or a zip file", str(path))
        card_path = model_path.with_name(CARD_FILE)
        interface, normalized = Interface(), False
        if card_path.is_file():
            try:
                card = json.loads(card_path.read_text())
                normalized = bool(card.get("normalized", False))
                interface = Interface(**card["interface"])
            except (KeyError, TypeError, json.JSONDecodeError) as error:
                rule = f"must be of this version: {error}; train the agent again"
                raise ValueError(f"agent: {card_path} {rule}") from None
        normalizer = None
        normalizer_path = model_path.with_name(NORMALIZER_FILE)
        if normalizer_path.is_file():
            with normalizer_path.open("rb") as file:
                normalizer = pickle.load(file)
            normalizer.training = False
        rule = f"must have {NORMALIZER_FILE} beside it, which its card speaks of: copy it from where it was trained"
        require(normalizer is not None or not normalized, "agent", rule, str(model_path))
        parts = [item.read_bytes() for item in (model_path, card_path, normalizer_path) if item.is_file()]
        # What a law from outside of the package does is not in these files.
        own = any(base not in baselines.names() for base in interface.bases)
        fingerprint = None if own else hashlib.sha256(b"".join(parts)).hexdigest()
        return cls(load_model(model_path), normalizer, interface, fingerprint)

    def attach(self, env: SpacecraftFTCVectorEnv) -> VectorEnv[Any, Any, Any]:
        """Wrap a vector environment for this agent.

        Raises
        ------
        ValueError
            If the agent's spaces do not fit the environment.
        """
        wrapped: VectorEnv[Any, Any, Any] = self.interface.wrap(env)
        given = wrapped.single_observation_space.shape or ()
        wanted = self._visible
        rule = f"must have been trained on observations of {given[0]} entries, as {env.scenario.name} gives in the "
        rule += f"{self.tier} tier: fly it on the scenario of its card, or train one for this"
        require(given == (wanted,), "agent", rule, wanted)
        wanted_action, given_action = self.model.action_space.shape, wrapped.single_action_space.shape
        rule = f"must have been trained for actions {given_action}, as {env.scenario.name} takes"
        require(wanted_action == given_action, "agent", rule, wanted_action)
        return wrapped

    @property
    def _visible(self) -> int:
        """How many entries of the observation the actor sees: all, unless the critic is told more."""
        whole = (self.model.observation_space.shape or (0,))[0]
        return int(getattr(self.model.policy, "actor_size", whole))

    def predict(
        self,
        observation: npt.NDArray[Any],
        state: Any = None,
        episode_start: npt.NDArray[Any] | None = None,
        deterministic: bool = True,
    ) -> tuple[npt.NDArray[Any], Any]:
        """Return the action for raw observations (N, size), as Stable-Baselines3's ``predict`` does.

        The state carries, for every craft, the control periods until the next decision, the action held, and the memory
        of a recurrent network.
        """
        start = np.zeros(len(observation), dtype=np.bool_)
        if episode_start is not None:
            start = np.asarray(episode_start, dtype=np.bool_)

        def decide(memory: Any) -> tuple[npt.NDArray[Any], Any]:
            # The entries for the critic alone are zero in flight: the actor has no path from them.
            unseen = (self.model.observation_space.shape or (0,))[0] - self._visible
            padded = np.pad(observation, ((0, 0), (0, unseen)))
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
    """Load a model of any algorithm that agents are trained with; the file tells which.

    Parameters
    ----------
    path
        The zip file.
    env
        Environment to train on further, or None.
    kind
        Turns the class of the algorithm into the one to build, or None for itself.
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
    algorithm = next((kind for name, kind in kinds.items() if f".{name}." in module), sb3.PPO)
    built = algorithm if kind is None else kind(algorithm)
    return built.load(path, env=env, device="cpu", custom_objects=changes or None)
