"""The drawn numbers of the episodes that the craft of a simulator are in."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ftac_gym.faults import DrawnFaults
from ftac_gym.faults.live import widened
from ftac_gym.task.episodes import Episodes
from ftac_gym.utils.parameters import require

Tables = dict[str, npt.NDArray[Any]]
"""The arrays of :class:`~ftac_gym.task.episodes.Episodes` by name, with the craft on the first axis."""


def faults_in(tables: Tables) -> DrawnFaults:
    """Return the faults in the tables: views."""
    return DrawnFaults(tables["faults"], tables["sensor_faults"], tables["switches"])


def with_faults(tables: Tables, drawn: DrawnFaults) -> Tables:
    """Return the tables with other faults."""
    return {**tables, "faults": drawn.wheels, "sensor_faults": drawn.sensors, "switches": drawn.switches}


def with_episodes(tables: Tables, episodes: Episodes, chosen: npt.NDArray[np.int64]) -> Tables:
    """Return the tables with new episodes for the chosen craft, which must fit those of the others.

    Craft may differ in how many faults one of their wheels can have: the tables become as wide as the widest.

    Raises
    ------
    ValueError
        If the episodes do not fit.
    """
    new = episodes.arrays()
    mine, theirs = faults_in(tables), episodes.drawn_faults
    room = [
        max(ours.shape[axis], others.shape[axis]) for ours, others, axis in zip(mine, theirs, (2, 1, 1), strict=True)
    ]
    tables, new = with_faults(tables, widened(mine, *room)), with_faults(new, widened(theirs, *room))
    for name, table in tables.items():
        fits = table.dtype == new[name].dtype and table.shape[1:] == new[name].shape[1:]
        rule = f"must fit the scenario: {name} must have shape (episodes, *{table.shape[1:]})"
        require(fits, "episodes", rule, new[name].shape)
    for name, table in tables.items():
        table[chosen] = new[name]
    return tables
