"""Gains found by a search, stored as data: one JSON file per baseline, with their provenance."""

from __future__ import annotations

import json
from importlib.resources import files
from typing import Any

from ftac_gym.utils.parameters import require

FOLDER = files("ftac_gym.baselines") / "tuned_gains"
"""Folder of the files."""


def names() -> list[str]:
    """Return the names of the baselines that have tuned gains."""
    if not FOLDER.is_dir():
        return []
    return sorted(item.name.removesuffix(".json") for item in FOLDER.iterdir() if item.name.endswith(".json"))


def record(name: str) -> dict[str, Any]:
    """Return the tuned gains of a baseline and their provenance.

    Raises
    ------
    ValueError
        If there are none; the message names the command that tunes them.
    """
    remedy = f"must be tuned first: python train/tune.py --baseline {name} --store. Tuned are {names()}"
    require(name in names(), "gains", remedy, name)
    found: dict[str, Any] = json.loads((FOLDER / f"{name}.json").read_text())
    return found


def gains(name: str) -> dict[str, Any]:
    """Return the tuned gains of a baseline; raises as :func:`record` does."""
    found: dict[str, Any] = record(name)["gains"]
    return found
