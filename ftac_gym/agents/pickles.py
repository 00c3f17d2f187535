"""Files of Stable-Baselines3, sb3-contrib and SBX. They hold pickles, which run code of their author when read.

No other module of this package reads a pickle.
"""

from __future__ import annotations

import pickle
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ftac_gym.agents.export import NORMALIZER_FILE
from ftac_gym.agents.normalizer import Normalizer
from ftac_gym.utils.extras import MissingExtra, require_extra
from ftac_gym.utils.files import damage, reading
from ftac_gym.utils.parameters import require

if TYPE_CHECKING:
    from stable_baselines3.common.base_class import BaseAlgorithm

NORMALIZER_FILES = ("normalizer.pkl", NORMALIZER_FILE)
"""Files of a ``VecNormalize``: of old agents, and of RL Baselines3 Zoo."""

_ALGORITHMS = {
    "stable_baselines3.sac": "SAC",
    "stable_baselines3.td3": "TD3",
    "stable_baselines3.dqn": "DQN",
    "sb3_contrib.tqc": "TQC",
    "sb3_contrib.crossq": "CrossQ",
    "sb3_contrib.ars": "ARS",
    "sb3_contrib.common.recurrent": "RecurrentPPO",
    "sbx.ppo": "PPO",
    "sbx.sac": "SAC",
    "sbx.tqc": "TQC",
    "sbx.td3": "TD3",
    "sbx.crossq": "CrossQ",
}
"""Algorithm of a policy by the folder of its class. DDPG has the policies of TD3, PPO, A2C and TRPO share theirs."""

_INSTALL = {"sbx": "pip install sbx-rl", "sb3_contrib": "pip install sb3-contrib"}


def load_model(path: Path) -> BaseAlgorithm:
    """Load a model for prediction; the file names its algorithm. This runs code of the file.

    Raises
    ------
    ValueError
        If the file is damaged, or of other versions.
    MissingExtra
        If the library of the model is not installed; the message has the command that installs it.
    """
    require_extra("stable_baselines3")
    from stable_baselines3.common.save_util import load_from_zip_file

    # For prediction a replay buffer and schedules of training are not needed.
    replaced: dict[str, Any] = {"learning_rate": 0.0, "lr_schedule": _zero, "clip_range": _zero, "buffer_size": 1}
    try:
        data, _, _ = load_from_zip_file(path, device="cpu", custom_objects=replaced)
        return _algorithm(data or {}).load(path, device="cpu", custom_objects=replaced)
    except ImportError as error:
        library = str(error.name).partition(".")[0]
        raise MissingExtra(f"{path} needs {library}: {_INSTALL.get(library, f'pip install {library}')}") from error
    except Exception as error:
        remedy = "load it with the versions of Python and the library that wrote it"
        raise ValueError(damage(path, error, remedy)) from error


def _zero(_: float) -> float:
    return 0.0


def _algorithm(data: dict[str, Any]) -> type[BaseAlgorithm]:
    """Return the algorithm that reads the data of a model; for prediction it need not be the one that trained."""
    for base in getattr(data.get("policy_class"), "__mro__", ()):
        parts = base.__module__.split(".")
        for length in (3, 2):
            name = _ALGORITHMS.get(".".join(parts[:length]))
            if name is not None:
                return getattr(import_module(parts[0]), name)
    return import_module("stable_baselines3").PPO


def find_normalizer(path: Path) -> Path | None:
    """Return the file of the ``VecNormalize`` beside the zip of a model or in a folder of its name, if there is one."""
    places = [folder / name for folder in (path.parent, path.with_suffix("")) for name in NORMALIZER_FILES]
    return next((place for place in places if place.is_file()), None)


def load_normalizer(path: Path) -> Normalizer | None:
    """Load the statistics of a ``VecNormalize``, which runs code of the file; None if it leaves observations alone.

    Raises
    ------
    ValueError
        If the file is damaged, or holds something else.
    """
    with reading(path, "load it with the version of Stable-Baselines3 that wrote it", Exception):
        found = pickle.loads(path.read_bytes())
        require(hasattr(found, "norm_obs"), "content", "must be a VecNormalize", type(found).__name__)
        return Normalizer.of(found)
