from importlib.metadata import PackageNotFoundError, version

import gymnasium as gym
import pytest

import ftac_gym  # noqa: F401  registers the ids

LIBRARIES = ["torch", "stable-baselines3", "sb3-contrib", "sbx-rl", "rl_zoo3", "torchrl", "skrl", "tianshou"]
"""Names of the packages on the page and of what they have in common."""

DURATION = 2.0
"""Length of an episode of the snippets under test [s]: 20 steps."""


@pytest.fixture
def duration(monkeypatch, tmp_path):
    """Shorten the episodes of the id that the snippets use, and run them in a folder of their own."""
    kwargs = gym.registry["SpacecraftFTC-v0"].kwargs
    monkeypatch.setitem(kwargs, "duration", DURATION)
    monkeypatch.chdir(tmp_path)
    return DURATION


def pytest_report_header():
    """Name the versions of the libraries."""
    found = []
    for name in LIBRARIES:
        try:
            found.append(f"{name} {version(name)}")
        except PackageNotFoundError:
            found.append(f"{name} missing")
    return ", ".join(found)
