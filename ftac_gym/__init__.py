"""Gymnasium environments for learning-based fault-tolerant attitude control of spacecraft.

Importing the package registers the environment ids; everything that needs the compiler or PyTorch is imported when it
is first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

import gymnasium as gym

if TYPE_CHECKING:
    from ftac_gym import baselines, evaluation, faults, scenarios, wrappers
    from ftac_gym.dynamics import Simulator
    from ftac_gym.task.episodes import Episodes
    from ftac_gym.task.initial_state import InitialState
    from ftac_gym.task.measurement import Measurement
    from ftac_gym.task.scenario import Scenario

__version__ = "0.1.0"

__all__ = [
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

_HOMES = {
    "Episodes": "ftac_gym.task.episodes",
    "InitialState": "ftac_gym.task.initial_state",
    "Measurement": "ftac_gym.task.measurement",
    "Scenario": "ftac_gym.task.scenario",
    "Simulator": "ftac_gym.dynamics",
}
_MODULES = ("baselines", "evaluation", "faults", "scenarios", "wrappers")


def __getattr__(name: str) -> Any:
    """Import a public name when it is first asked for."""
    if name in _HOMES:
        return getattr(import_module(_HOMES[name]), name)
    if name in _MODULES:
        return import_module(f"ftac_gym.{name}")
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    """List the public names."""
    return sorted([*globals(), *__all__])


def _register(environment_id: str, scenario: str) -> None:
    gym.register(
        id=environment_id,
        entry_point="ftac_gym.envs:SpacecraftFTCEnv",
        vector_entry_point="ftac_gym.envs:SpacecraftFTCVectorEnv",
        kwargs={"default_scenario": scenario},
    )


_register("SpacecraftFTC-v0", "flagship")
_register("SpacecraftFTCTracking-v0", "flagship_tracking")
_register("SpacecraftFTCFlexible-v0", "flexible")
_register("SpacecraftFTCZhangZhou2019-v0", "zhang_zhou_2019")
_register("SpacecraftFTCCao2022-v0", "cao_2022")
_register("SpacecraftFTCLi2023-v0", "li_2023")
_register("SpacecraftFTCMa2023-v0", "ma_2023_faulty")
_register("SpacecraftFTCChen2018-v0", "chen_2018")
