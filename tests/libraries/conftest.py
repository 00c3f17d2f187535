import math
from importlib.metadata import PackageNotFoundError, version

import gymnasium as gym
import pytest

import ftac_gym  # noqa: F401  registers the ids

LIBRARIES = ["torch", "stable-baselines3", "sb3-contrib", "sbx-rl", "rl_zoo3", "torchrl", "skrl", "tianshou"]
"""Names of the packages on the page and of what they have in common."""


@pytest.fixture
def short_episodes(monkeypatch, tmp_path):
    """Shorten the episodes of the id on the page to at most 20 steps, and run in a folder of the test.

    Many start near the rate at which they end, so that the spacecraft of a vector environment end one by one.
    """
    kwargs = gym.registry["SpacecraftFTC-v0"].kwargs
    monkeypatch.setitem(kwargs, "duration", 2.0)
    monkeypatch.setitem(kwargs, "tumble_rate", math.radians(0.8))
    monkeypatch.chdir(tmp_path)


def pytest_report_header():
    """Name the versions of the libraries."""
    found = []
    for name in LIBRARIES:
        try:
            found.append(f"{name} {version(name)}")
        except PackageNotFoundError:
            found.append(f"{name} missing")
    return ", ".join(found)
