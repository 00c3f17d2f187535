"""Saved models of Stable-Baselines3, sb3-contrib and SBX, with the normaliser beside them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ftac_gym.agents.agent import Agent
from ftac_gym.agents.interface import Interface, wrapper_pairs
from ftac_gym.agents.pickles import find_normalizer, load_model, load_normalizer
from ftac_gym.utils.parameters import require


def load_sb3(
    path: str | Path,
    observation: str = "attitude",
    hold: int = 1,
    normalizer: str | Path | None = None,
    wrappers: Sequence[Any] = (),
) -> Agent:
    """Load a model that ``model.save`` of Stable-Baselines3, sb3-contrib or SBX wrote.

    .. warning::
        The file holds pickles: loading it runs code of its author. Load only files that you trust.

    Parameters
    ----------
    path
        The zip file; its suffix may be left out. It names its algorithm.
    observation
        Information tier on which the model was trained.
    hold
        Control periods for which every action was held.
    normalizer
        File of a ``VecNormalize``; by default ``vecnormalize.pkl`` beside the model, or in a folder of its name there.
        Without such a file the model takes raw observations.
    wrappers
        Name in :mod:`ftac_gym.wrappers` and arguments of each wrapper of the training, the innermost first.

    Raises
    ------
    ValueError
        If a file is missing or damaged, or an argument is refused.
    MissingExtra
        If the library of the model is not installed; the message has the command that installs it.
    """
    given = Path(path)
    file = given if given.is_file() else Path(f"{given}.zip")
    require(file.is_file(), "sb3", "must be the zip file of a model", str(path))
    interface = Interface(observation, wrapper_pairs(wrappers), hold)
    model = load_model(file)
    valid = normalizer is None or isinstance(normalizer, (str, Path))
    require(valid, "normalizer", "must be a file or None", normalizer)
    statistics = find_normalizer(file) if normalizer is None else Path(normalizer)
    require(statistics is None or statistics.is_file(), "normalizer", "must be a file", str(statistics))
    return Agent(model.policy, None if statistics is None else load_normalizer(statistics), interface)
