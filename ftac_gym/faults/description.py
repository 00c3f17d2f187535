"""Descriptions of faults as text, for people who look at an episode."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ftac_gym.faults.effect import presence
from ftac_gym.faults.registry import label_of
from ftac_gym.faults.table import DrawnFaults
from ftac_gym.utils.parameters import FloatArray

Descriptions = tuple[str, ...]


class ActingFaults(NamedTuple):
    """The faults of one spacecraft at a moment.

    Attributes
    ----------
    wheels
        (m,) whether any fault of each wheel acts.
    descriptions
        One entry for each acting fault, those of wheels first.
    """

    wheels: npt.NDArray[np.bool_]
    descriptions: Descriptions


def acting_faults(drawn: DrawnFaults, time: FloatArray) -> tuple[ActingFaults, ...]:
    """Return the faults of each of N spacecraft that act now.

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
        ActingFaults(wheels[i].any(axis=1), _descriptions(drawn, i, wheels[i], sensors[i])) for i in range(len(time))
    )


def drawn_faults(drawn: DrawnFaults, spacecraft: int) -> Descriptions:
    """Return descriptions of all faults in the episode of one spacecraft."""
    wheels, sensors = drawn.wheels[spacecraft]["kind"] > 0, drawn.sensors[spacecraft]["kind"] > 0
    return _descriptions(drawn, spacecraft, wheels, sensors)


def _descriptions(
    drawn: DrawnFaults, spacecraft: int, wheels: npt.NDArray[np.bool_], sensors: npt.NDArray[np.bool_]
) -> Descriptions:
    of_wheels = (
        f"wheel {wheel}: {_description(drawn.wheels[spacecraft, wheel, layer])}" for wheel, layer in np.argwhere(wheels)
    )
    return (*of_wheels, *(_description(drawn.sensors[spacecraft, index]) for index in np.flatnonzero(sensors)))


def _description(record: np.void) -> str:
    return f"{label_of(int(record['kind']))} at {record['onset']:.1f} s"
