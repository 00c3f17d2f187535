"""Scheduled faults: the same ones in every episode."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ftac_gym.faults.fault import UNIFORMS_PER_FAULT, Fault, SensorFault, WheelFault, check_all
from ftac_gym.faults.registry import check_registered
from ftac_gym.faults.table import FLIPS, DrawnFaults, no_faults, no_sensor_faults
from ftac_gym.spacecraft.wheel_array import WheelArray
from ftac_gym.utils.parameters import FloatArray, require
from ftac_gym.utils.serialization import serializable


@serializable
@dataclass(frozen=True)
class FaultSchedule:
    """All the listed faults, in every episode; several may affect the same wheel.

    Parameters
    ----------
    faults
        The faults; those of wheels with their ``wheel`` given. Times and magnitudes may still be random.

    Raises
    ------
    ValueError
        If a fault of a wheel names no wheel.
    """

    faults: tuple[Fault, ...]

    def __post_init__(self) -> None:
        """Check and normalise the fields."""
        require(isinstance(self.faults, (tuple, list)), "faults", "must be a tuple of Fault objects", self.faults)
        object.__setattr__(self, "faults", tuple(self.faults))
        for fault in self.faults:
            check_registered(fault, "faults")
            placed = isinstance(fault, SensorFault) or (isinstance(fault, WheelFault) and fault.wheel is not None)
            require(placed, "faults", "must each name a wheel", fault)

    @property
    def _wheels(self) -> list[int]:
        """The wheel of each fault of a wheel, in order."""
        return [fault.wheel for fault in self.faults if isinstance(fault, WheelFault) and fault.wheel is not None]

    @property
    def most_faults(self) -> int:
        """Largest number of faults of an episode."""
        return len(self.faults)

    @property
    def paths(self) -> Iterator[tuple[str, Fault]]:
        """Names of the faults in messages, and the faults."""
        for index, fault in enumerate(self.faults):
            yield f"faults[{index}]", fault

    def check(self, wheels: WheelArray) -> None:
        """Raise a ValueError if a fault does not fit the wheels or names one that the array does not have."""
        check_all(self.faults, wheels, "faults")

    def layers(self) -> int:
        """Return the largest number of faults of one wheel."""
        return max(Counter(self._wheels).values(), default=1)

    def uniform_count(self, wheels: int) -> int:
        """Return the number of uniform deviates that one episode needs."""
        return max(1, len(self.faults) * UNIFORMS_PER_FAULT)

    @property
    def switching_count(self) -> int:
        """Number of uniform deviates that the random chains of one episode need."""
        return len(self.faults) * FLIPS if any(fault.random_chain for fault in self.faults) else 0

    def draw(self, uniform: FloatArray, switching: FloatArray, torque_limits: FloatArray) -> DrawnFaults:
        """Draw the faults of N episodes, as :meth:`~ftac_gym.faults.distribution.FaultDistribution.draw` does."""
        count = len(uniform)
        wheels = no_faults(count, len(torque_limits), self.layers())
        sensors = no_sensor_faults(count, len(self.faults) - len(self._wheels))
        chances = switching.reshape(count, -1, FLIPS)
        switches = np.zeros_like(chances)
        used: Counter[int | None] = Counter()
        for index, fault in enumerate(self.faults):
            part = uniform[:, index * UNIFORMS_PER_FAULT : (index + 1) * UNIFORMS_PER_FAULT]
            wheel = fault.wheel if isinstance(fault, WheelFault) else None
            records = sensors[:, used[None]] if wheel is None else wheels[:, wheel, used[wheel]]
            records[:] = fault.draw(part, np.full(count, torque_limits[wheel or 0]))
            used[wheel] += 1
            if fault.random_chain:
                records["chain"] = index
                switches[:, index] = fault.switching_times(records["onset"], chances[:, index])
        return DrawnFaults(wheels, sensors, switches)
