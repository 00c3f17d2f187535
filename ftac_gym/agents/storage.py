"""Files of an agent: a card in JSON, and its weights as arrays. Nothing in them is code."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ftac_gym.agents import network
from ftac_gym.agents.interface import Interface
from ftac_gym.agents.normalizer import Normalizer
from ftac_gym.utils.extras import require_extra
from ftac_gym.utils.files import reading, replacing, write_text
from ftac_gym.utils.parameters import require
from ftac_gym.utils.serialization import parse_json

if TYPE_CHECKING:
    from stable_baselines3.common.policies import BasePolicy

CARD_FILE = "card.json"
"""File that makes a folder an agent; all else is found by it."""

PROVENANCE: dict[str, tuple[type, ...]] = {
    "environment": (str,),
    "scenario": (str,),
    "algorithm": (str,),
    "command": (str,),
    "seed": (int,),
    "commit": (str,),
    "steps": (int,),
    "training_seconds": (int, float),
    "ftac_gym": (str,),
    "run_steps": (int,),
    "run_seconds": (int, float),
    "evaluation": (dict,),
}
"""Entries of a card about the origin of an agent, none of which is required, and their types."""

_BEHAVIOUR = ("interface", "network", "normalizer", "weights")
"""Entries of a card on which the actions of an agent depend."""

_REMEDY = "restore the whole folder from a copy, or train the agent again"
_OLDER = "must be of this version; pickles run code when they are read. Convert one that you trust, once: "
_OLDER += "ftac-convert OLD NEW --trust; a zip flies as it is as sb3:PATH"


@dataclass(frozen=True, eq=False)
class Stored:
    """An agent as its files have it.

    Attributes
    ----------
    policy
        The network.
    normalizer
        Standardisation of its observations, or None.
    interface
        Interface of the network.
    digest
        SHA-256 of all of these.
    """

    policy: BasePolicy
    normalizer: Normalizer | None
    interface: Interface
    digest: str


def write_agent(
    folder: Path,
    policy: BasePolicy,
    normalizer: Normalizer | None,
    interface: Interface,
    provenance: Mapping[str, Any],
) -> None:
    """Write an agent, in the place of an earlier one in the folder; other files stay.

    The card is replaced last, in one step, and names its weights by their content. At any moment the folder holds the
    earlier agent or this one, whole.

    Parameters
    ----------
    folder
        Folder of the agent, which is created.
    policy
        A policy of Stable-Baselines3 or sb3-contrib.
    normalizer
        Standardisation of its observations, or None.
    interface
        Interface of the network.
    provenance
        Origin of the agent; names are those of :data:`PROVENANCE`.

    Raises
    ------
    ValueError
        If the network cannot be written as data, or the provenance has another entry.
    """
    require_extra("safetensors")
    from safetensors.numpy import save

    _check_provenance(provenance)
    description, weights = network.describe(policy)
    network.build(description, weights)  # what could not be read is not written
    arrays = {f"network.{name}": value for name, value in weights.items()}
    statistics = None
    if normalizer is not None:
        arrays |= {f"normalizer.{name}": getattr(normalizer, name) for name in ("mean", "variance")}
        statistics = {name: getattr(normalizer, name) for name in ("clip", "epsilon", "count")}
    data = save(arrays)
    digest = hashlib.sha256(data).hexdigest()
    behaviour = {
        "interface": dataclasses.asdict(interface),
        "network": description,
        "normalizer": statistics,
        "weights": {"file": _weights_file(digest), "sha256": digest},
    }
    card = {**behaviour, "digest": _digest(behaviour), **provenance}
    with replacing(folder / _weights_file(digest)) as file:
        file.write(data)
    write_text(folder / CARD_FILE, _as_text(card))
    for path in folder.glob("weights-*.safetensors"):
        if path.name != _weights_file(digest):
            path.unlink(missing_ok=True)


def amend_card(folder: Path, provenance: Mapping[str, Any]) -> None:
    """Add entries about the origin to the card of an agent, or replace them."""
    _check_provenance(provenance)
    write_text(folder / CARD_FILE, _as_text({**read_card(folder), **provenance}))


def read_card(folder: Path, remedy: str = _REMEDY) -> dict[str, Any]:
    """Return the card of an agent, whose entries have been checked.

    Parameters
    ----------
    folder
        Folder of the agent.
    remedy
        Advice to the user if a file is damaged, in the imperative.

    Raises
    ------
    ValueError
        If there is none, it is damaged, or of another version; the message is one line with the remedy.
    """
    path = folder / CARD_FILE
    zipped = folder.is_file() or any(folder.glob("*.zip"))
    require(path.is_file() or not zipped, "agent", _OLDER, str(folder))
    require(path.is_file(), "agent", f"must be a folder with {CARD_FILE}", str(folder))
    with reading(path, remedy):
        card = parse_json(path.read_bytes())
        require(isinstance(card, dict), "card", "must be an object", type(card).__name__)
    require("weights" in card or not (zipped or "normalized" in card), "agent", _OLDER, str(folder))
    with reading(path, remedy):
        for name in (*_BEHAVIOUR, "digest"):
            require(name in card, name, "must be in the card", sorted(card))
        _check_provenance({name: card[name] for name in card if name not in (*_BEHAVIOUR, "digest")})
        rule = f"must be that of the card's {', '.join(_BEHAVIOUR)}, which have changed since it was written"
        require(card["digest"] == _digest(card), "digest", rule, card["digest"])
    return card


def read_agent(folder: Path, remedy: str = _REMEDY) -> Stored:
    """Read an agent. Nothing of it is executed, and no global state changes.

    Parameters
    ----------
    folder, remedy
        As for :func:`read_card`.

    Raises
    ------
    ValueError
        If a file is missing, damaged, of another version, or not of this agent; the message is one line with the file
        and the remedy.
    MissingExtra
        If Stable-Baselines3, or sb3-contrib for its policies, is not installed.
    """
    require_extra("safetensors", "stable_baselines3")
    from safetensors import SafetensorError
    from safetensors.numpy import load

    card = read_card(folder, remedy)
    with reading(folder / CARD_FILE, remedy):
        interface = Interface(**card["interface"])
        written = card["weights"]
        rule = "must name file and sha256"
        require(isinstance(written, dict) and set(written) == {"file", "sha256"}, "weights", rule, written)
        named = written["file"] == _weights_file(str(written["sha256"]))
        require(named, "weights", "must be in the file of their sha256", written["file"])
    path = folder / written["file"]
    if not path.is_file() and read_card(folder, remedy) != card:
        return read_agent(folder, remedy)  # it was replaced after its card was read
    with reading(path, remedy, SafetensorError):
        data = path.read_bytes()
        found = hashlib.sha256(data).hexdigest()
        require(found == written["sha256"], "SHA-256", "must be that of the card", found)
        arrays = load(data)
    with reading(folder / CARD_FILE, remedy, RuntimeError, AssertionError, MemoryError, ArithmeticError):
        normalizer = _normalizer_of(card["normalizer"], arrays)
        policy = network.build(card["network"], {name.removeprefix("network."): arrays[name] for name in arrays})
        size = policy.observation_space.shape
        fits = normalizer is None or normalizer.mean.shape == size
        require(fits, "normalizer.mean", f"must have the shape {size} of an observation", normalizer)
    return Stored(policy, normalizer, interface, card["digest"])


def _normalizer_of(statistics: Any, arrays: dict[str, Any]) -> Normalizer | None:
    """Return the normaliser of a card, whose arrays are taken out of those of the agent."""
    if statistics is None:
        return None
    names = {"clip", "epsilon", "count"}
    numbers = isinstance(statistics, dict) and set(statistics) == names
    numbers = numbers and all(type(value) in (int, float) for value in statistics.values())
    require(numbers, "normalizer", f"must have the numbers {sorted(names)}", statistics)
    return Normalizer(arrays.pop("normalizer.mean"), arrays.pop("normalizer.variance"), **statistics)


def _weights_file(digest: str) -> str:
    return f"weights-{digest[:8]}.safetensors"


def _digest(card: Mapping[str, Any]) -> str:
    """Return the SHA-256 of the entries on which the actions of an agent depend."""
    behaviour = {name: card[name] for name in _BEHAVIOUR}
    return hashlib.sha256(json.dumps(behaviour, sort_keys=True, allow_nan=False).encode()).hexdigest()


def _check_provenance(entries: Mapping[str, Any]) -> None:
    for name, value in entries.items():
        require(name in PROVENANCE, "card", f"must have entries among {list(PROVENANCE)}", name)
        kinds = " or ".join(kind.__name__ for kind in PROVENANCE[name])
        require(type(value) in PROVENANCE[name], name, f"must be {kinds}", value)


def _as_text(card: Mapping[str, Any]) -> str:
    """Return a card as JSON with each list of numbers in a line."""
    text = json.dumps(card, indent=2, allow_nan=False)
    rows = re.compile(r"\[\n\s*([^\[\]{}]*?)\n\s*\]")
    return rows.sub(lambda found: "[" + re.sub(r"\n\s*", " ", found[1]) + "]", text) + "\n"
