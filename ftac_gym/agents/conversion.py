"""Conversion of agents that are stored as pickles, which run code of their author when read."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np

from ftac_gym.agents.agent import Agent
from ftac_gym.agents.export import MODEL_FILE
from ftac_gym.agents.interface import Interface
from ftac_gym.agents.pickles import NORMALIZER_FILES, find_normalizer, load_model, load_normalizer
from ftac_gym.agents.shipped import EVALUATIONS_FILE, agent_folders
from ftac_gym.agents.storage import CARD_FILE
from ftac_gym.utils.files import reading
from ftac_gym.utils.parameters import require
from ftac_gym.utils.serialization import parse_json

_TRIALS = 1000
"""Random observations to which old and new agent must give the same actions."""


def convert(old: Path, new: Path) -> dict[Path, bool]:
    """Write agents that are stored as pickles as data, and check that they act alike. This runs code of the old files.

    Parameters
    ----------
    old
        The folder of an agent with ``model.zip``; a folder of such with one for each training seed (``seed_*``); the
        folder of a run; or a zip of Stable-Baselines3. The normaliser is ``normalizer.pkl`` or ``vecnormalize.pkl``
        beside the zip, or in a folder of its name. Without a card the agent acts directly, in the attitude tier.
    new
        Folder for the agents, in the order of the old ones, with the tables of their evaluations.

    Returns
    -------
    The folders of the new agents, each with whether it has a normaliser.

    Raises
    ------
    ValueError
        If there is no such agent, its files cannot be read, the new folder holds one already, or a network cannot be
        written as data.
    """
    require(old.exists(), "old", "must be a folder or a zip file", str(old))
    found = {}
    for source in agent_folders(old):
        target = new if source == old else new / source.relative_to(old)
        require(not (target / CARD_FILE).exists(), "new", "must not hold an agent yet", str(target))
        found[target] = _convert(source if source.is_file() else source / MODEL_FILE, target)
        for folder, place in ((source, target), (source.parent, target.parent)):
            if (folder / EVALUATIONS_FILE).is_file() and (folder == source or source.name == "agent"):
                shutil.copyfile(folder / EVALUATIONS_FILE, place / EVALUATIONS_FILE)
    return found


def _convert(path: Path, target: Path) -> bool:
    """Write the agent of one zip, and return whether it has a normaliser."""
    require(path.is_file(), "old", f"must have {MODEL_FILE}", str(path.parent))
    card: dict[str, Any] = {"interface": {}}
    written = path.with_name(CARD_FILE)
    with reading(written, "remove the card of another version to convert the network alone"):
        if written.is_file():
            card = parse_json(written.read_bytes())
        interface = Interface(**card.pop("interface"))
        normalized = card.pop("normalized", False)
    statistics = find_normalizer(path)
    rule = f"must have {NORMALIZER_FILES[0]} beside it, as its card says: copy it from the folder of its training"
    require(statistics is not None or not normalized, "old", rule, str(path))
    model = load_model(path)
    normalizer = None if statistics is None else load_normalizer(statistics)
    agent = Agent(model.policy, normalizer, interface)
    agent.save(target, **card)
    observations = np.random.default_rng(0).normal(0.0, 2.0, (_TRIALS, agent.observation_size)).astype(np.float32)
    (actions, _), (again, _) = (item.predict(observations) for item in (agent, Agent.load(target)))
    require(np.array_equal(actions, again), "new", "must act as the old agent does", str(target))
    return normalizer is not None
