"""Initial state of an episode."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from ftac_gym import attitude as attitudes
from ftac_gym.utils.parameters import (
    FloatArray,
    Interval,
    Vector,
    draw,
    interval,
    is_number,
    largest,
    non_negative_interval,
    normalise,
    optional,
    require,
    uniform_directions,
    unit_quaternion,
    vector,
)
from ftac_gym.utils.serialization import LATER_PART, serializable

_MODAL = ("modal_displacement", "modal_rate")


def _modal(values: Sequence[Interval], name: str) -> tuple[Interval, ...]:
    """Return one checked interval per mode."""
    require(isinstance(values, (tuple, list)), name, "must have one entry per mode", values)
    return tuple(interval(value, f"{name}[{mode}]") for mode, value in enumerate(values))


def initial_dtype(wheels: int, modes: int = 0) -> np.dtype[np.void]:
    """Return the record of a start: attitude (4,), rate (3,) [rad/s], wheel_momentum (wheels,) [N m s].

    A flexible spacecraft has modal_displacement (modes,) [kg^1/2 m] and modal_rate (modes,) [kg^1/2 m/s] too.
    """
    rigid = [("attitude", "f8", (4,)), ("rate", "f8", (3,)), ("wheel_momentum", "f8", (wheels,))]
    flexible = [("modal_displacement", "f8", (modes,)), ("modal_rate", "f8", (modes,))]
    return np.dtype(rigid + flexible if modes else rigid)


@serializable
@dataclass(frozen=True)
class InitialState:
    """Distribution of attitude, rate and wheel momentum at time zero.

    Parameters
    ----------
    attitude
        Fixed quaternion; None draws one at random.
    angle
        Angle from the inertial frame of a random attitude [rad], its axis uniform on the sphere; None makes the
        attitude uniform over all rotations.
    rate
        Fixed body rate [rad/s]; None draws its direction uniformly and its magnitude by ``max_rate``.
    max_rate
        Magnitude of a random rate [rad/s]: uniform below a number, or uniform in a pair (low, high).
    wheel_momentum
        Momentum of each wheel [N m s]: one interval for all wheels.
    fixed_wheel_momentum
        Momentum of each wheel [N m s], one number per wheel; None draws from ``wheel_momentum``.
    modal_displacement, modal_rate
        Displacement [kg^1/2 m] and rate [kg^1/2 m/s] of each vibration mode: one interval per mode; None is at rest.
    """

    attitude: Vector | None = None
    angle: Interval | None = None
    rate: Vector | None = None
    max_rate: Interval = 0.0
    wheel_momentum: Interval = 0.0
    fixed_wheel_momentum: Vector | None = None
    modal_displacement: tuple[Interval, ...] | None = field(default=None, metadata=LATER_PART)
    modal_rate: tuple[Interval, ...] | None = field(default=None, metadata=LATER_PART)

    def __post_init__(self) -> None:
        """Check and normalise the fields."""
        normalise(self, optional(unit_quaternion), "attitude")
        normalise(self, optional(lambda value, name: interval(value, name, 0.0, math.pi)), "angle")
        normalise(self, optional(lambda values, name: vector(values, 3, name)), "rate")
        normalise(self, non_negative_interval, "max_rate")
        normalise(self, interval, "wheel_momentum")
        normalise(self, optional(lambda values, name: vector(values, None, name)), "fixed_wheel_momentum")
        normalise(self, optional(_modal), *_MODAL)

    @classmethod
    def fixed(
        cls,
        attitude: Sequence[float] = (1.0, 0.0, 0.0, 0.0),
        rate: Sequence[float] = (0.0, 0.0, 0.0),
        wheel_momentum: float | Sequence[float] = 0.0,
    ) -> InitialState:
        """Build a fixed start from a quaternion, a rate [rad/s] and the wheel momentum [N m s].

        The momentum is one number for all wheels, or one per wheel.
        """
        momentum: Any = wheel_momentum
        name = "wheel_momentum" if is_number(momentum) else "fixed_wheel_momentum"
        return cls(attitude=unit_quaternion(attitude, "attitude"), rate=vector(rate, 3, "rate"), **{name: momentum})

    @property
    def largest_rate(self) -> float:
        """Largest body rate [rad/s]."""
        return largest(self.max_rate) if self.rate is None else math.hypot(*self.rate)

    def largest_momentum(self, wheels: int) -> FloatArray:
        """Return the largest momentum of each wheel (wheels,) [N m s]."""
        if self.fixed_wheel_momentum is None:
            return np.full(wheels, largest(self.wheel_momentum))
        return np.abs(self.fixed_wheel_momentum)

    def uniform_count(self, wheels: int, modes: int = 0) -> int:
        """Return the number of uniform deviates that one episode needs."""
        return 7 + wheels + 2 * modes

    def check(self, momentum_limits: FloatArray, modes: int = 0) -> None:
        """Check the start against momentum limits (wheels,) [N m s] and the number of vibration modes.

        Raises
        ------
        ValueError
            If a wheel would start beyond its momentum limit, or the number of momenta is not that of the wheels. Also
            if the number of modal displacements or rates is not that of the modes.
        """
        wheels = len(momentum_limits)
        if self.fixed_wheel_momentum is not None:
            given = len(self.fixed_wheel_momentum)
            require(given == wheels, "fixed_wheel_momentum", f"must have {wheels} values, one per wheel", given)
        for name in _MODAL:
            if (values := getattr(self, name)) is not None:
                require(len(values) == modes, name, f"must have {modes} entries, one per mode", len(values))
        most = self.largest_momentum(wheels)
        within = bool(np.all(most <= momentum_limits))
        field = "wheel_momentum" if self.fixed_wheel_momentum is None else "fixed_wheel_momentum"
        require(within, field, f"must stay within the limits {momentum_limits.tolist()}", most.tolist())

    def draw(self, uniform: FloatArray, momentum_limits: FloatArray, modes: int = 0) -> npt.NDArray[np.void]:
        """Draw N starts.

        Parameters
        ----------
        uniform
            (N, uniform_count) uniform deviates.
        momentum_limits
            (wheels,) momentum limits [N m s].
        modes
            Number of vibration modes.

        Raises
        ------
        ValueError
            If the start does not fit the wheels or the modes; see :meth:`check`.
        """
        self.check(momentum_limits, modes)
        count, wheels = len(uniform), len(momentum_limits)
        table = np.zeros(count, initial_dtype(wheels, modes))
        if self.attitude is not None:
            table["attitude"] = self.attitude
        elif self.angle is None:
            table["attitude"] = attitudes.random_quaternion_from_uniforms(uniform[:, 0:3])
        else:
            angle = draw(self.angle, uniform[:, 2])
            rotation = angle[:, None] * uniform_directions(uniform[:, 0:2])
            table["attitude"] = attitudes.quaternion_from_rotation_vector(rotation)
        if self.rate is not None:
            table["rate"] = self.rate
        else:
            low, high = self.max_rate if isinstance(self.max_rate, tuple) else (0.0, self.max_rate)
            magnitude = draw((low, high), uniform[:, 3])
            table["rate"] = magnitude[:, None] * uniform_directions(uniform[:, 4:6])
        if self.fixed_wheel_momentum is None:
            table["wheel_momentum"] = draw(self.wheel_momentum, uniform[:, 7 : 7 + wheels])
        else:
            table["wheel_momentum"] = self.fixed_wheel_momentum
        for number, name in enumerate(_MODAL):
            if (values := getattr(self, name)) is None:
                continue
            for mode, value in enumerate(values):
                table[name][:, mode] = draw(value, uniform[:, 7 + wheels + number * modes + mode])
        return table
