"""Faults in words, for people who look at an episode."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ftac_gym.faults.effect import presence
from ftac_gym.faults.registry import label_of
from ftac_gym.faults.table import DrawnFaults
from ftac_gym.utils.parameters import FloatArray

Words = tuple[str, ...]


class ActingFaults(NamedTuple):
    """What is wrong with one craft at a moment.

    Attributes
    ----------
    wheels
        (m,) whether anything is wrong with each wheel.
    words
        One entry for each acting fault, those of wheels first.
    """

    wheels: npt.NDArray[np.bool_]
    words: Words


def acting_faults(drawn: DrawnFaults, time: FloatArray) -> tuple[ActingFaults, ...]:
    """Return what is wrong with each of N craft now.

    Parameters
    ----------
    drawn
        Their faults.
    time
        (N,) time of each episode [s].
    """
    wheels = (presence(drawn.wheels, drawn.switches, time) > 0.0) & (drawn.wheels["kind"] > 0)
    sensors = (presence(drawn.sensors, drawn.switches, time) > 0.0) & (drawn.sensors["kind"] > 0)
    return tuple(
        ActingFaults(wheels[craft].any(axis=1), _listed(drawn, craft, wheels[craft], sensors[craft]))
        for craft in range(len(time))
    )


def drawn_faults(drawn: DrawnFaults, craft: int) -> Words:
    """Return everything that is or will be wrong in one craft's episode."""
    wheels, sensors = drawn.wheels[craft]["kind"] > 0, drawn.sensors[craft]["kind"] > 0
    return _listed(drawn, craft, wheels, sensors)


def _listed(drawn: DrawnFaults, craft: int, wheels: npt.NDArray[np.bool_], sensors: npt.NDArray[np.bool_]) -> Words:
    listed = [f"wheel {wheel}: {_in_words(drawn.wheels[craft, wheel, layer])}" for wheel, layer in np.argwhere(wheels)]
    return (*listed, *(_in_words(drawn.sensors[craft, index]) for index in np.flatnonzero(sensors)))


def _in_words(record: np.void) -> str:
    return f"{label_of(int(record['kind']))} at {record['onset']:.1f} s"
