"""Episodes of some spacecraft put in the place of those that they were in."""

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from ftac_gym.faults import DrawnFaults
from ftac_gym.faults.live import widened
from ftac_gym.task.episodes import Episodes


def with_faults(episodes: Episodes, drawn: DrawnFaults) -> Episodes:
    """Return the episodes with other faults."""
    return replace(episodes, faults=drawn.wheels, sensor_faults=drawn.sensors, switches=drawn.switches)


def merged(current: Episodes, new: Episodes, rows: npt.NDArray[np.int64]) -> Episodes:
    """Return the current episodes with new ones in the listed rows; arrays of ``current`` are written to.

    Episodes may differ in the number of faults that one of their wheels can have: the tables become as wide as the
    widest.
    """
    ours, theirs = current.drawn_faults, new.drawn_faults
    widths = [max(a.shape[axis], b.shape[axis]) for a, b, axis in zip(ours, theirs, (2, 1, 1), strict=True)]
    current, new = with_faults(current, widened(ours, *widths)), with_faults(new, widened(theirs, *widths))
    arrays = new.arrays()
    for name, array in current.arrays().items():
        array[rows] = arrays[name]
    return current
