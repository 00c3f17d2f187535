"""Gymnasium environments for learning-based fault-tolerant attitude control of spacecraft.

Importing the package registers the environment ids. Modules that need the compiler or PyTorch are imported when they
are first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

import gymnasium as gym

if TYPE_CHECKING:
    from ftac_gym import baselines, evaluation, faults, scenarios, wrappers
    from ftac_gym.dynamics import DivergenceError, Simulator
    from ftac_gym.task import Episodes, InitialState, Measurement, Scenario

__version__ = "0.1.0"

__all__ = [
    "DivergenceError",
    "Episodes",
    "InitialState",
    "Measurement",
    "Scenario",
    "Simulator",
    "baselines",
    "evaluation",
    "faults",
    "scenarios",
    "wrappers",
]

_IDS = {
    "SpacecraftFTCEasy-v0": "easy",
    "SpacecraftFTC-v0": "flagship",
    "SpacecraftFTCTracking-v0": "flagship_tracking",
    "SpacecraftFTCFlexible-v0": "flexible",
    "SpacecraftFTCZhangZhou2019-v0": "zhang_zhou_2019",
    "SpacecraftFTCCao2022-v0": "cao_2022",
    "SpacecraftFTCLi2023-v0": "li_2023",
    "SpacecraftFTCMa2023-v0": "ma_2023_faulty",
    "SpacecraftFTCChen2018-v0": "chen_2018",
}
"""Environment ids with their scenarios."""

for _id, _scenario in _IDS.items():
    gym.register(
        id=_id,
        entry_point="ftac_gym.envs:SpacecraftFTCEnv",
        vector_entry_point="ftac_gym.envs:SpacecraftFTCVectorEnv",
        kwargs={"default_scenario": _scenario},
    )


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    if name[0].islower():
        return import_module(f"ftac_gym.{name}")
    package = "dynamics" if name in ("DivergenceError", "Simulator") else "task"
    return getattr(import_module(f"ftac_gym.{package}"), name)


def __dir__() -> list[str]:
    """List the public names."""
    return sorted([*globals(), *__all__])
