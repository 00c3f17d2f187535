"""The library of scenarios, by name, and scenarios from files, functions and data."""

from ftac_gym.scenarios.library import get, is_shipped, names, register
from ftac_gym.scenarios.sources import ScenarioLike, resolve
from ftac_gym.scenarios.splits import SPLITS

__all__ = ["SPLITS", "ScenarioLike", "get", "is_shipped", "names", "register", "resolve"]
