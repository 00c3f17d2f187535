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


def is_file(gains: object) -> bool:
    """Tell whether a set of gains is the path of a file ``FILE.json``, as ``ftac-tune`` writes it."""
    return isinstance(gains, str) and gains.lower().endswith(".json")


def record(name: str, source: str = "tuned") -> dict[str, Any]:
    """Return tuned gains of a baseline and their provenance.

    Parameters
    ----------
    name
        Name of the baseline.
    source
        ``"tuned"`` for the gains that the package has, or a file of ``ftac-tune``.

    Raises
    ------
    ValueError
        If there are none, or their file is damaged or of another baseline; the message names the command that tunes.
    """
    command = f"ftac-tune --baseline {name}"
    if is_file(source):
        return _read(Path(source), f"tune again: {command}", name)
    rule = f"must be tuned first: {command} --store. Tuned are {names()}"
    require(name in names(), "gains", rule, name)
    return _read(Path(str(FOLDER / f"{name}.json")), f"tune it again: {command} --store", None)


def _read(path: Path, remedy: str, baseline: str | None) -> dict[str, Any]:
    with reading(path, remedy):
        found = parse_json(path.read_bytes())
        require(isinstance(found, dict), "tuned gains", "must be an object", found)
        for part in ("gains", "provenance"):
            require(isinstance(found.get(part), dict), part, "must be an object", found.get(part))
        for part, kind in (("scenario", str), ("trials", int)):
            value = found["provenance"].get(part)
            require(isinstance(value, kind), f"{part} of the provenance", f"must be of type {kind.__name__}", value)
        if baseline is not None:
            named = found["provenance"].get("baseline")
            require(named == baseline, "baseline of the provenance", f"must be {baseline!r}", named)
        return dict(found)


def gains(name: str, source: str = "tuned") -> dict[str, Any]:
    """Return tuned gains of a baseline; parameters and errors as of :func:`record`."""
    found: dict[str, Any] = record(name, source)["gains"]
    return found
