"""Gains found by a search, stored as data: one JSON file per baseline, with their provenance."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path
from typing import Any

from ftac_gym.utils.files import reading
from ftac_gym.utils.parameters import require
from ftac_gym.utils.serialization import parse_json

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
        If there are none, or their file is damaged; the message names the command that tunes them.
    """
    command = f"python train/tune.py --baseline {name} --store"
    require(name in names(), "gains", f"must be tuned first: {command}. Tuned are {names()}", name)
    path = FOLDER / f"{name}.json"
    with reading(Path(str(path)), f"tune it again: {command}"):
        found = parse_json(path.read_bytes())
        require(isinstance(found, dict), "tuned gains", "must be an object", found)
        for part in ("gains", "provenance"):
            require(isinstance(found.get(part), dict), part, "must be an object", found.get(part))
        for part, kind in (("scenario", str), ("trials", int)):
            value = found["provenance"].get(part)
            require(isinstance(value, kind), f"{part} of the provenance", f"must be of type {kind.__name__}", value)
        return dict(found)


def gains(name: str) -> dict[str, Any]:
    """Return the tuned gains of a baseline; raises as :func:`record` does."""
    found: dict[str, Any] = record(name)["gains"]
    return found
