"""Units of a scenario for gains: the time of its control loop, and what its wheels can do to its spacecraft.

A gain in such a unit is a pure number, which suits spacecraft of any size, wheels and control period. Its physical
value follows from the scenario::

    rate_gain: float = parameter(1.2, "Damping", PER_LOOP, positive)

is 6 1/s where control period and loop delay add up to 0.2 s. Two spacecraft fly the same motion if inertia, wheel
torques and wheel momenta of one are k times those of the other.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from copy import copy
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from ftac_gym.spacecraft.envelope import UNLIMITED, envelope_normals
from ftac_gym.utils.parameters import FloatArray, require

if TYPE_CHECKING:
    from ftac_gym.task.scenario import Scenario

G = TypeVar("G")

Factors = Mapping[str, Any]
"""Physical values of one unit, by the name of the gain; of a gain that is a mapping, by the names of its entries."""


@dataclass(frozen=True)
class Scales:
    """Sizes of a scenario, from its nominal parameters.

    Parameters
    ----------
    loop_time
        L, control period plus loop delay [s].
    acceleration
        A, the largest angular acceleration that the wheels can give about every axis [rad/s^2].
    speed
        W, the smaller of two rates [rad/s]. One is sqrt(A), which A reaches within a turn of half a radian. The other
        is half of the rate whose momentum the wheels can hold about every axis.
    torque
        R, the smallest torque limit of a wheel [N m].
    inertia
        I, the smallest principal moment of inertia [kg m^2]: the axis that a torque moves most.
    """

    loop_time: float
    acceleration: float
    speed: float
    torque: float
    inertia: float

    @classmethod
    def of(cls, scenario: Scenario) -> Scales:
        """Return the sizes of a scenario; a wheel without a torque limit counts as one of 1 N m.

        Raises
        ------
        ValueError
            If the axes do not span space.
        """
        wheels, inertia = scenario.spacecraft.wheels, scenario.spacecraft.inertia_matrix
        limits = np.where(np.isfinite(wheels.torque_limits), wheels.torque_limits, 1.0)
        # Accelerations and rates by wheel, for one unit of torque and of momentum.
        effects: FloatArray = np.linalg.solve(inertia, wheels.axis_matrix).astype(np.float64)
        require(int(np.linalg.matrix_rank(effects)) == 3, "axes", "must span three dimensions", wheels.axes)
        acceleration = _inner_radius(effects, limits)
        stored = _inner_radius(effects, np.minimum(wheels.momentum_limits, UNLIMITED))
        return cls(
            loop_time=scenario.control_period + scenario.loop_delay,
            acceleration=acceleration,
            speed=min(math.sqrt(acceleration), 0.5 * stored),
            torque=float(limits.min()),
            inertia=float(np.linalg.eigvalsh(inertia)[0]),
        )


def _inner_radius(effects: FloatArray, reach: FloatArray) -> float:
    """Return the radius of the largest sphere in the zonotope sum_j [-reach_j, reach_j] effects[:, j]."""
    # Normals do not depend on the lengths of the edges, which may be tiny.
    directions = effects / np.linalg.norm(effects, axis=0)
    return float((np.abs(envelope_normals(directions) @ effects) @ reach).min())


@dataclass(frozen=True)
class Unit:
    """A product of powers of the sizes of a scenario.

    Parameters
    ----------
    symbol
        The product in the letters of :class:`Scales`, for documentation.
    si
        The SI unit of the product.
    loop_time, acceleration, speed, torque, inertia
        Exponents.
    """

    symbol: str
    si: str
    loop_time: int = 0
    acceleration: int = 0
    speed: int = 0
    torque: int = 0
    inertia: int = 0

    def __str__(self) -> str:
        """Return the symbol."""
        return self.symbol

    def value(self, scales: Scales) -> float:
        """Return the physical value of one unit [SI]."""
        factors = (getattr(scales, item.name) ** getattr(self, item.name) for item in fields(scales))
        return math.prod(factors)


LOOPS = Unit("L", "s", loop_time=1)
PER_LOOP = Unit("1/L", "1/s", loop_time=-1)
SPEED = Unit("W", "rad/s", speed=1)
PER_SPEED = Unit("1/W", "s/rad", speed=-1)
ACCELERATION = Unit("A", "rad/s^2", acceleration=1)
TORQUE = Unit("R", "N m", torque=1)


def has_units(gains: Any) -> bool:
    """Return whether a dataclass of gains has one in units of the scenario."""
    return any(isinstance(item.metadata.get("unit"), (Unit, Mapping)) for item in fields(gains))


def factors_of(gains: Any, scales: Scales) -> Factors:
    """Return the physical values of the units of a dataclass of gains; physical gains have none."""
    factors: dict[str, Any] = {}
    for item in fields(gains):
        unit = item.metadata.get("unit")
        if isinstance(unit, Unit):
            factors[item.name] = unit.value(scales)
        elif isinstance(unit, Mapping):
            factors[item.name] = {entry: part.value(scales) for entry, part in unit.items()}
    return factors


def relative(gains: Any, scales: Scales, values: Mapping[str, Any]) -> dict[str, Any]:
    """Return some gains, given in SI units, in those of a dataclass of gains: the inverse of :func:`physical`.

    Parameters
    ----------
    gains
        The dataclass.
    scales
        Sizes of the scenario.
    values
        Values by the name of the gain; those without a unit of the scenario stay as they are.
    """
    return _times(values, factors_of(gains, scales), -1)


def physical(gains: G, factors: Factors) -> G:
    """Return gains in SI units, unchecked.

    Parameters
    ----------
    gains
        The dataclass, or one with arrays (N, 1) in place of some numbers.
    factors
        Those of :func:`factors_of`.
    """
    result = copy(gains)
    for name, value in _times({name: getattr(gains, name) for name in factors}, factors, 1).items():
        object.__setattr__(result, name, value)
    return result


def _times(values: Mapping[str, Any], factors: Factors, power: int) -> dict[str, Any]:
    """Return values times the powers of their factors; None and what has no factor stay as they are."""
    found = dict(values)
    for name in found.keys() & factors.keys():
        value, factor = found[name], factors[name]
        if isinstance(factor, Mapping):
            found[name] = None if value is None else _times(value, factor, power)
        elif value is not None:
            found[name] = value * factor if power > 0 else value / factor
    return found
