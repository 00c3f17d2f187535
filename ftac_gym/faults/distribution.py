"""Random faults: their number, their kinds and their wheels."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ftac_gym.faults.fault import UNIFORMS_PER_FAULT, Fault, SensorFault, WheelFault, check_all
from ftac_gym.faults.registry import check_registered
from ftac_gym.faults.schedule import FaultSchedule
from ftac_gym.faults.table import FLIPS, DrawnFaults, no_faults, no_sensor_faults, scale_magnitudes
from ftac_gym.spacecraft.wheel_array import WheelArray
from ftac_gym.utils.parameters import FloatArray, Vector, as_array, broken, fields_named, finite, require
from ftac_gym.utils.serialization import LATER_PART, serializable

_UNIFORMS_PER_SLOT = 2 + UNIFORMS_PER_FAULT
"""Of each slot: one to choose the kind, one to thin out by severity, the rest for the fault itself."""


def _probabilities(values: tuple[float, ...], field: str) -> Vector:
    array = as_array(values)
    rule = "must be non-negative weights with a positive sum"
    if array is None or array.ndim != 1:
        raise broken(field, rule, values)
    with np.errstate(over="ignore"):
        total = float(array.sum())
    require(bool(np.all(array >= 0.0)) and 0.0 < total < np.inf, field, rule, values)
    # Normalised values stay as they are, so that a round trip through JSON changes nothing.
    return tuple(float(value) for value in (array if abs(total - 1.0) < 1e-15 * array.size else array / total))


@serializable
@dataclass(frozen=True)
class FaultDistribution:
    """Random faults: their number in an episode, and their kinds; beside them faults that are always there.

    Every random fault of a wheel affects another wheel; faults of the sensors count with the others. A random fault may
    affect a wheel that ``always`` names too. Both then act together, as several faults of a wheel in a
    :class:`~ftac_gym.faults.FaultSchedule` do. The random faults are those of the same episodes without ``always``.

    Parameters
    ----------
    kinds
        The fault kinds to choose from; each draws its own timing and magnitude. Their ``wheel`` must be None; a kind
        that always affects the same one belongs to a :class:`~ftac_gym.faults.FaultSchedule`.
    weights
        Relative frequency of each kind; None for equal weights.
    fault_counts
        Relative frequency of 0, 1, 2, ... faults; the entry for 0 is the share of healthy episodes.
    severity
        Severity of the faults, in [0, 1], for curricula: 1 as described by the kinds, 0 healthy. In between the
        magnitudes shrink in proportion, and kinds that are not gradual (lock in place, seizure, delay, star-tracker
        outage) occur with this probability. Episodes of a seed grow worse monotonically.
    always
        Faults in every episode, those of wheels with their ``wheel`` given, as in a
        :class:`~ftac_gym.faults.FaultSchedule`. They are a condition of the spacecraft: neither ``fault_counts`` nor
        ``severity`` is about them.

    Raises
    ------
    ValueError
        If there are no kinds, the weights do not match them, a weight is negative, or the severity leaves [0, 1]. Also
        if a fault of a wheel in ``always`` names no wheel.
    """

    kinds: tuple[Fault, ...]
    weights: Vector | None = None
    fault_counts: Vector = (0.0, 1.0)
    severity: float = 1.0
    always: tuple[Fault, ...] = field(default=(), metadata=LATER_PART)

    def __post_init__(self) -> None:
        """Check and normalise the fields."""
        require(isinstance(self.kinds, (tuple, list)), "kinds", "must be a tuple of Fault objects", self.kinds)
        object.__setattr__(self, "kinds", tuple(self.kinds))
        require(len(self.kinds) > 0, "kinds", "must name at least one fault kind", self.kinds)
        for fault in self.kinds:
            check_registered(fault, "kinds")
            free = isinstance(fault, SensorFault) or (isinstance(fault, WheelFault) and fault.wheel is None)
            require(free, "kinds", "must leave wheel=None: the distribution chooses it", fault)
        weights = _probabilities(self.weights if self.weights is not None else (1.0,) * len(self.kinds), "weights")
        require(len(weights) == len(self.kinds), "weights", f"must match the {len(self.kinds)} kinds", self.weights)
        object.__setattr__(self, "weights", weights)
        object.__setattr__(self, "fault_counts", _probabilities(self.fault_counts, "fault_counts"))
        object.__setattr__(self, "severity", finite(self.severity, "severity"))
        require(0.0 <= self.severity <= 1.0, "severity", "must be within [0, 1]", self.severity)
        with fields_named(faults="always"):
            object.__setattr__(self, "always", FaultSchedule(self.always).faults)

    @property
    def slots(self) -> int:
        """Largest number of random faults of an episode."""
        return len(self.fault_counts) - 1

    @property
    def most_faults(self) -> int:
        """Largest number of faults of an episode."""
        return self.slots + len(self.always)

    @property
    def faults(self) -> tuple[Fault, ...]:
        """The fault kinds, and behind them the faults that are always there."""
        return (*self.kinds, *self.always)

    @property
    def paths(self) -> Iterator[tuple[str, Fault]]:
        """Names of the faults in messages, and the faults, in the order of :attr:`faults`."""
        for name in ("kinds", "always"):
            for index, fault in enumerate(getattr(self, name)):
                yield f"{name}[{index}]", fault

    @cached_property
    def _schedule(self) -> FaultSchedule:
        return FaultSchedule(self.always)

    def check(self, wheels: WheelArray) -> None:
        """Raise a ValueError if more wheels can fail than there are, or a kind does not fit them."""
        rule = f"must not exceed the {wheels.count} wheels of the spacecraft"
        require(self.slots <= wheels.count, "fault_counts", rule, self.slots)
        check_all(self.kinds, wheels, "kinds")
        check_all(self.always, wheels, "always")

    def uniform_count(self, wheels: int) -> int:
        """Return the number of uniform deviates that one episode needs."""
        return self._random_count(wheels) + (self._schedule.uniform_count(wheels) if self.always else 0)

    def _random_count(self, wheels: int) -> int:
        """Return the number of uniform deviates of the random faults; those of the others come behind."""
        return 1 + wheels + self.slots * _UNIFORMS_PER_SLOT

    @property
    def switching_count(self) -> int:
        """Number of uniform deviates that the random chains of one episode need."""
        return self._random_chains * FLIPS + self._schedule.switching_count

    @property
    def _random_chains(self) -> int:
        """Number of random chains of the random faults; those of the others come behind."""
        return self.slots if any(fault.random_chain for fault in self.kinds) else 0

    def draw(self, uniform: FloatArray, switching: FloatArray, torque_limits: FloatArray) -> DrawnFaults:
        """Draw the faults of N episodes.

        Parameters
        ----------
        uniform
            (N, uniform_count) uniform deviates.
        switching
            (N, switching_count) uniform deviates.
        torque_limits
            (wheels,) [N m].
        """
        chains, count = self._random_chains, self._random_count(len(torque_limits))
        drawn = self._draw_random(uniform, switching[:, : chains * FLIPS], torque_limits)
        if not self.always:
            return drawn
        others = self._schedule.draw(uniform[:, count:], switching[:, chains * FLIPS :], torque_limits)
        for table in (others.wheels, others.sensors):
            table["chain"] += np.where(table["chain"] >= 0, chains, 0)
        return DrawnFaults(
            np.concatenate([drawn.wheels, others.wheels], axis=2),
            np.concatenate([drawn.sensors, others.sensors], axis=1),
            np.concatenate([drawn.switches, others.switches], axis=1),
        )

    def random_part(self, drawn: DrawnFaults) -> DrawnFaults:
        """Return tables without the faults that are always there; tables of another source as they are."""
        others = sum(isinstance(fault, SensorFault) for fault in self.always)
        shape = 1 + self._schedule.layers(), self._sensor_slots + others
        if not self.always or (drawn.wheels.shape[2], drawn.sensors.shape[1]) != shape:
            return drawn
        return drawn._replace(wheels=drawn.wheels[:, :, :1], sensors=drawn.sensors[:, : self._sensor_slots])

    @property
    def _sensor_slots(self) -> int:
        """Largest number of random faults of the sensors."""
        return self.slots if any(isinstance(fault, SensorFault) for fault in self.kinds) else 0

    def _draw_random(self, uniform: FloatArray, switching: FloatArray, torque_limits: FloatArray) -> DrawnFaults:
        count, wheels = len(uniform), len(torque_limits)
        table = no_faults(count, wheels)
        sensors = no_sensor_faults(count, self._sensor_slots)
        chances = switching.reshape(count, -1, FLIPS)
        switches = np.zeros_like(chances)
        numbers = np.searchsorted(np.cumsum(self.fault_counts), uniform[:, 0], side="right")
        order = np.argsort(uniform[:, 1 : 1 + wheels], axis=1)
        weights = np.asarray(self.weights)
        for slot in range(self.slots):
            start = 1 + wheels + slot * _UNIFORMS_PER_SLOT
            chosen = np.searchsorted(np.cumsum(weights), uniform[:, start], side="right").clip(max=len(weights) - 1)
            for index, fault in enumerate(self.kinds):
                # A severity of zero leaves no fault; below one it thins out the kinds that cannot be made smaller.
                present = uniform[:, start + 1] < self.severity if not fault.gradual else self.severity > 0.0
                rows = np.flatnonzero((numbers > slot) & (chosen == index) & present)
                if rows.size == 0:
                    continue
                affected = order[rows, slot]
                records = fault.draw(uniform[rows, start + 2 : start + _UNIFORMS_PER_SLOT], torque_limits[affected])
                if fault.gradual:
                    scale_magnitudes(records, self.severity)
                if fault.random_chain:
                    records["chain"] = slot
                    switches[rows, slot] = fault.switching_times(records["onset"], chances[rows, slot])
                if isinstance(fault, WheelFault):
                    table[rows, affected, 0] = records
                else:
                    sensors[rows, slot] = records
        return DrawnFaults(table, sensors, switches)
