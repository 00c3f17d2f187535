"""Fault kinds of reaction wheels, except those that change the effectiveness of the motor."""

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from ftac_gym.faults.fault import WheelFault, magnitude
from ftac_gym.faults.table import LONGEST_DELAY, FaultKind
from ftac_gym.spacecraft.wheel_array import WheelArray
from ftac_gym.utils.parameters import (
    FloatArray,
    Interval,
    bounds,
    draw,
    flag,
    largest,
    normalise,
    require,
)
from ftac_gym.utils.serialization import serializable

DIRECTIONS = ("both", "forward", "backward", "either")
"""Senses of rotation in which friction can rise."""


def _random_signs(uniform: FloatArray) -> FloatArray:
    """Turn uniform deviates into +1 and -1 with equal chances."""
    return np.where(uniform < 0.5, -1.0, 1.0)


def _require_limits(torque_limit: FloatArray, kind: str) -> None:
    """Raise a ValueError unless all affected wheels have a torque limit, in which the kind measures its size."""
    limited = bool(np.isfinite(torque_limit).all())
    require(limited, kind, "needs wheels with a torque limit; torque_limit", torque_limit.tolist())


@serializable
@dataclass(frozen=True, kw_only=True)
class Bias(WheelFault):
    """Added torque b = constant + slope s + amplitude s^exponent sin(frequency s + phase), with s = t - onset.

    The bias adds to the limited command, so that the wheel's torque can exceed its command limit.

    Parameters
    ----------
    constant, slope
        Constant part [N m] and ramp [N m/s].
    amplitude, exponent, frequency, phase
        The oscillating part [N m s^-exponent, -, rad/s, rad]. Exponent 0 is a plain sinusoid; a negative
        one is refused, as the bias would be infinite at the onset.
    random_sign
        Whether each draw takes either sign with equal chances.
    """

    kind: ClassVar[FaultKind] = FaultKind.BIAS
    constant: Interval = field(default=0.0, metadata=magnitude("bias"))
    slope: Interval = field(default=0.0, metadata=magnitude("bias_slope"))
    amplitude: Interval = field(default=0.0, metadata=magnitude("bias_amplitude"))
    exponent: Interval = field(default=0.0, metadata=magnitude("bias_exponent", low=0.0))
    frequency: Interval = field(default=0.0, metadata=magnitude("bias_frequency"))
    phase: Interval = field(default=0.0, metadata=magnitude("bias_phase"))
    random_sign: bool = False

    def __post_init__(self) -> None:
        """Check and normalise the fields."""
        super().__post_init__()
        normalise(self, flag, "random_sign")

    def largest_torque(self, time: float, limits: FloatArray) -> FloatArray:
        """Return a bound on the torque [N m] of wheels with torque limits (m,) in an episode of a length [s].

        It is infinite beyond double precision.
        """
        if self.recovery is not None:
            time = min(time, bounds(self.recovery)[1] - bounds(self.onset)[0])
        elif self.duration is not None:
            time = min(time, bounds(self.duration)[1])
        with np.errstate(over="ignore"):
            swing = largest(self.amplitude) * max(1.0, float(np.power(time, largest(self.exponent))))
        return np.full(len(limits), largest(self.constant) + largest(self.slope) * time + swing)

    def _fill(self, rows: npt.NDArray[np.void], uniform: FloatArray, torque_limit: FloatArray) -> None:
        if self.random_sign:
            for name in ("bias", "bias_slope", "bias_amplitude"):
                rows[name] *= _random_signs(uniform[:, 6])


@serializable
@dataclass(frozen=True, kw_only=True)
class Outage(WheelFault):
    """Effectiveness zero, no bias: the wheel floats."""

    kind: ClassVar[FaultKind] = FaultKind.OUTAGE
    constants: ClassVar = {"effectiveness": 0.0}


@serializable
@dataclass(frozen=True, kw_only=True)
class LockInPlace(WheelFault):
    """The torque at the onset is held, whatever is commanded, until the wheel's momentum limit stops it."""

    kind: ClassVar[FaultKind] = FaultKind.LOCK_IN_PLACE
    gradual: ClassVar[bool] = False
    constants: ClassVar = {"effectiveness": 0.0, "locked": 1.0}


@serializable
@dataclass(frozen=True, kw_only=True)
class HardOver(WheelFault):
    """The wheel applies a fraction of its torque limit, whatever is commanded, until its momentum limit stops it.

    Parameters
    ----------
    fraction
        Fraction of the torque limit, in [-1, 1]; 1 is the classical hard-over.
    random_sign
        Whether each draw takes either sign with equal chances.

    Raises
    ------
    ValueError
        When drawn, if the affected wheel has no torque limit.
    """

    kind: ClassVar[FaultKind] = FaultKind.HARD_OVER
    constants: ClassVar = {"effectiveness": 0.0}
    fraction: Interval = field(default=1.0, metadata=magnitude("bias", low=-1.0, high=1.0))
    random_sign: bool = True

    def largest_torque(self, time: float, limits: FloatArray) -> FloatArray:
        """Return a bound on the torque [N m] of wheels with torque limits (m,), at any time."""
        return largest(self.fraction) * limits

    def __post_init__(self) -> None:
        """Check and normalise the fields."""
        super().__post_init__()
        normalise(self, flag, "random_sign")

    def _fill(self, rows: npt.NDArray[np.void], uniform: FloatArray, torque_limit: FloatArray) -> None:
        _require_limits(torque_limit, "HardOver")
        if self.random_sign:
            rows["bias"] *= _random_signs(uniform[:, 1])
        rows["bias"] *= torque_limit


@serializable
@dataclass(frozen=True, kw_only=True)
class FrictionRise(WheelFault):
    """The dry friction of the wheel grows by a factor, as on FUSE and Kepler before their wheels stopped.

    Only for wheels that have friction.

    Parameters
    ----------
    factor
        Factor on the Coulomb and the breakaway torque, at least 1.
    direction
        Sense of rotation in which it grows: ``"both"``, ``"forward"`` (positive momentum), ``"backward"``, or
        ``"either"``, which draws one of the two.
    rise
        Length of the growth [s].
    """

    kind: ClassVar[FaultKind] = FaultKind.FRICTION_RISE
    factor: Interval = field(default=(2.0, 20.0), metadata=magnitude(low=1.0))
    direction: str = "both"
    rise: Interval = (20.0, 60.0)

    def __post_init__(self) -> None:
        """Check and normalise the fields."""
        super().__post_init__()
        known = isinstance(self.direction, str) and self.direction in DIRECTIONS
        require(known, "direction", f"must be one of {list(DIRECTIONS)}", self.direction)

    def check(self, wheels: WheelArray) -> None:
        """Raise a ValueError unless every wheel that the fault can affect has dry friction, which can grow."""
        super().check(wheels)
        dry = [entry is not None and (entry.breakaway or 0.0) > 0.0 for entry in wheels.frictions]
        fits = all(dry) if self.wheel is None else dry[self.wheel]
        rule = "must be given, with a dry part, for the wheels that a FrictionRise can affect"
        require(fits, "friction", rule, wheels.friction)

    def _fill(self, rows: npt.NDArray[np.void], uniform: FloatArray, torque_limit: FloatArray) -> None:
        factor, either = draw(self.factor, uniform[:, 0]), self.direction == "either"
        forward = self.direction in ("both", "forward") or either & (uniform[:, 1] < 0.5)
        backward = self.direction in ("both", "backward") or either & (uniform[:, 1] >= 0.5)
        rows["friction_forward"] = np.where(forward, factor, 1.0)
        rows["friction_backward"] = np.where(backward, factor, 1.0)


@serializable
@dataclass(frozen=True, kw_only=True)
class Seizure(WheelFault):
    """Dry friction beyond the torque of the motor: the momentum of the wheel goes into the body.

    The brake torque b stops a wheel of momentum h in h / b seconds, a little later or earlier if the motor pulls. From
    then on it holds the wheel at rest, whatever is commanded.

    Parameters
    ----------
    brake
        Brake torque over the torque limit; above 1, so that the motor cannot overcome it.

    Raises
    ------
    ValueError
        When drawn, if the affected wheel has no torque limit.
    """

    kind: ClassVar[FaultKind] = FaultKind.SEIZURE
    gradual: ClassVar[bool] = False
    brake: Interval = field(default=(1.5, 4.0), metadata=magnitude("brake", above=1.0))

    def _fill(self, rows: npt.NDArray[np.void], uniform: FloatArray, torque_limit: FloatArray) -> None:
        _require_limits(torque_limit, "Seizure")
        rows["brake"] *= torque_limit


@serializable
@dataclass(frozen=True, kw_only=True)
class IntermittentShutdown(WheelFault):
    """No motor torque while shut down; the times of shut-down and restart are a two-state Markov chain.

    Parameters
    ----------
    mean_acting
        Mean time from shut-down to restart [s].
    mean_resting
        Mean time from restart to the next shut-down [s].

    Raises
    ------
    ValueError
        If the chain is left out.
    """

    kind: ClassVar[FaultKind] = FaultKind.INTERMITTENT_SHUTDOWN
    constants: ClassVar = {"effectiveness": 0.0}
    mean_acting: float | None = 5.0
    mean_resting: float | None = 15.0

    def __post_init__(self) -> None:
        """Check and normalise the fields."""
        super().__post_init__()
        require(self.random_chain, "mean_acting", "must be given: without it the fault is an Outage", self.mean_acting)


@serializable
@dataclass(frozen=True, kw_only=True)
class CommandDelay(WheelFault):
    """The wheel receives every command a whole number of control periods late.

    Parameters
    ----------
    periods
        The delay in control periods: a whole number from 1 to 5, or a pair of them, both included in the draw.
    """

    kind: ClassVar[FaultKind] = FaultKind.COMMAND_DELAY
    gradual: ClassVar[bool] = False
    periods: Interval = field(default=(1.0, 5.0), metadata=magnitude())

    def __post_init__(self) -> None:
        """Check and normalise the fields."""
        super().__post_init__()
        low, high = bounds(self.periods)
        whole = low.is_integer() and high.is_integer() and low >= 1.0 and high <= LONGEST_DELAY
        require(whole, "periods", f"must be whole numbers from 1 to {LONGEST_DELAY}", self.periods)

    def _fill(self, rows: npt.NDArray[np.void], uniform: FloatArray, torque_limit: FloatArray) -> None:
        low, high = bounds(self.periods)
        # The minimum is for a deviate just below one, whose draw rounding takes beyond the longest delay.
        rows["delay"] = np.minimum(np.floor(draw((low, high + 1.0), uniform[:, 0])), high)
