"""A trained agent on disk: the policy, its normaliser, and a card that says how it was made."""

from __future__ import annotations

import hashlib
import json
import pickle
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
from gymnasium.vector import VectorEnv

from ftac_gym.envs import SpacecraftFTCVectorEnv
from ftac_gym.parameters import require
from ftac_gym.wrappers import ResidualPolicy

if TYPE_CHECKING:
    from stable_baselines3.common.base_class import BaseAlgorithm
    from stable_baselines3.common.vec_env import VecNormalize

SHIPPED = Path(__file__).parent.parent / "agents"
"""Where the agents that come with the package lie, a folder each."""

MODEL_FILE = "model.zip"
NORMALIZER_FILE = "normalizer.pkl"
CARD_FILE = "card.json"


@dataclass(frozen=True)
class Interface:
    """What surrounds a policy network: the observation it sees and what its action means.

    Parameters
    ----------
    observation
        Information tier.
    base
        Name of the baseline that the agent corrects; None for an agent that acts directly.
    authority, fade_angle, fade_floor
        Authority of the residual; see :class:`~ftac_gym.wrappers.ResidualPolicy`.
    hold
        Control periods for which every action is held.
    gains
        Gains of the base.
    """

    observation: str = "attitude"
    base: str | None = "pd_dob"
    authority: float = 0.5
    fade_angle: float = 0.0
    fade_floor: float = 0.0
    hold: int = 1
    gains: dict[str, Any] = field(default_factory=dict)

    def wrap(self, env: Any) -> Any:
        """Return the environment as the policy network sees it, single or vector."""
        if self.base is None:
            return env
        return ResidualPolicy(
            env,
            base=self.base,
            authority=self.authority,
            fade_angle=self.fade_angle,
            fade_floor=self.fade_floor,
            **self.gains,
        )


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
        Same for the same agent: finished batches of an evaluation are found by it. None if it has no file.
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
        """The information tier of its observation."""
        return self.interface.observation

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
            If there is no model.
        ImportError
            If Stable-Baselines3 is not installed.
        """
        path = Path(path)
        model_path = path / MODEL_FILE if path.is_dir() else path
        require(model_path.is_file(), "agent", "must be a folder with model.zip, or a zip file", str(path))
        card_path = model_path.with_name(CARD_FILE)
        interface = Interface(base=None)
        if card_path.is_file():
            interface = Interface(**json.loads(card_path.read_text())["interface"])
        normalizer = None
        normalizer_path = model_path.with_name(NORMALIZER_FILE)
        if normalizer_path.is_file():
            with normalizer_path.open("rb") as file:
                normalizer = pickle.load(file)
            normalizer.training = False
        parts = [item.read_bytes() for item in (model_path, card_path, normalizer_path) if item.is_file()]
        fingerprint = hashlib.sha256(b"".join(parts)).hexdigest()
        return cls(_load_model(model_path), normalizer, interface, fingerprint)

    def attach(self, env: SpacecraftFTCVectorEnv) -> VectorEnv[Any, Any, Any]:
        """Wrap a vector environment for this agent.

        Raises
        ------
        ValueError
            If the agent's spaces do not fit the environment.
        """
        wrapped: VectorEnv[Any, Any, Any] = self.interface.wrap(env)
        wanted, given = self.model.observation_space.shape, wrapped.single_observation_space.shape
        require(wanted == given, "agent", f"must have been trained on the environment's observation {given}", wanted)
        wanted, given = self.model.action_space.shape, wrapped.single_action_space.shape
        require(wanted == given, "agent", f"must have been trained on the environment's action {given}", wanted)
        return wrapped

    def predict(
        self,
        observation: npt.NDArray[Any],
        state: Any = None,
        episode_start: npt.NDArray[Any] | None = None,
        deterministic: bool = True,
    ) -> tuple[npt.NDArray[Any], Any]:
        """Return the action for raw observations (N, size), as Stable-Baselines3's ``predict`` does.

        The state carries, for every craft, the control periods until the next decision, and the action held.
        """
        count = len(observation)
        waiting, held = state if state is not None else (np.zeros(count, dtype=np.int64), None)
        if episode_start is not None:
            waiting = np.where(episode_start, 0, waiting)
        due = waiting == 0
        if held is None or due.any():
            if self.normalizer is not None:
                observation = np.asarray(self.normalizer.normalize_obs(observation))
            decided, _ = self.model.predict(observation, deterministic=deterministic)
            held = decided if held is None else np.where(due[:, None], decided, held)
        return held, (np.where(due, self.interface.hold, waiting) - 1, held)


def _load_model(path: Path) -> BaseAlgorithm:
    """Load a model of any algorithm of Stable-Baselines3; the policy in the file tells which."""
    import stable_baselines3 as sb3
    from stable_baselines3.common.save_util import load_from_zip_file

    data, _, _ = load_from_zip_file(path, device="cpu")
    policy = data["policy_class"].__module__ if data is not None else ""
    kinds: dict[str, type[BaseAlgorithm]] = {"sac": sb3.SAC, "td3": sb3.TD3, "dqn": sb3.DQN}
    # PPO and A2C share their policies; for prediction it does not matter which of them trained.
    algorithm = next((kind for name, kind in kinds.items() if f".{name}." in policy), sb3.PPO)
    return algorithm.load(path, device="cpu")
