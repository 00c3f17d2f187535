"""Sensors as data sheets describe them: star tracker, gyros, and the telemetry of wheels and vibration modes.

The gyros have a file of their own, :mod:`ftac_gym.task.gyro`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ftac_gym.task.gyro import Gyro
from ftac_gym.utils.parameters import (
    FloatArray,
    Interval,
    Vector,
    draw,
    fields_named,
    interval,
    largest,
    non_negative,
    non_negative_interval,
    normalise,
    positive,
    require,
    vector,
)
from ftac_gym.utils.serialization import serializable

ARCSECOND = math.pi / 648000.0
"""One arcsecond [rad]."""

MOST_FIXES = 100
"""Most samples that a star tracker can have in its pipeline at once: the simulator stores as many."""

SUITE = np.dtype(
    [
        *((name, "f8") for name in ("latency", "cross_noise", "boresight_noise")),
        ("boresight", "f8", (3,)),
        *((name, "f8") for name in ("angle_random_walk", "rate_random_walk", "bias_instability", "correlation_time")),
        *((name, "f8", (3,)) for name in ("gyro_bias", "scale_factor", "gyro_misalignment")),
        *((name, "f8") for name in ("wheel_momentum_noise", "wheel_momentum_quantum")),
        *((name, "f8") for name in ("modal_displacement_noise", "modal_rate_noise")),
    ]
)
"""Per spacecraft, in SI units.

Star tracker: latency [s]; noise about an axis across the boresight, and about it [rad]; the boresight in body axes.
Gyros: angle random walk [rad per square root of second]; rate random walk [rad/s per square root of second]; standard
deviation of the bias that varies about zero [rad/s] and its correlation time [s]; bias at the start [rad/s]; relative
error of each scale factor; the rotation vector [rad] by which the rate is turned in body axes. Telemetry: noise and
quantum of the wheel momentum [N m s]; noise of modal displacement [kg^1/2 m] and rate [kg^1/2 m/s].
"""


@serializable
@dataclass(frozen=True, kw_only=True)
class StarTracker:
    """Star tracker that takes samples at its own rate and delivers each after a latency.

    The samples are taken at multiples of the period 1 / ``rate`` since the start of the episode. Each is available at
    the first control tick that is ``latency`` or more after it. Noise is white, and normal on each axis.

    Parameters
    ----------
    rate
        Samples per second [Hz]. Its period must be a multiple of the control period.
    latency
        Time from a sample to its availability [s], at most 100 periods.
    cross_noise
        Standard deviation about each axis across the boresight [arcsec].
    boresight_noise
        Standard deviation about the boresight [arcsec].
    boresight
        Direction of the boresight, a unit vector in body axes.

    Raises
    ------
    ValueError
        If a value is negative or too large, or the boresight is no unit vector.
    """

    rate: float = 5.0
    latency: Interval = 0.0
    cross_noise: Interval = 0.0
    boresight_noise: Interval = 0.0
    boresight: Vector = (0.0, 0.0, 1.0)

    def __post_init__(self) -> None:
        """Check and normalise the fields."""
        normalise(self, positive, "rate")
        normalise(self, non_negative_interval, "latency")
        half_turn = 180.0 * 3600.0
        normalise(self, lambda value, name: interval(value, name, 0.0, half_turn), "cross_noise", "boresight_noise")
        normalise(self, lambda value, name: vector(value, 3, name), "boresight")
        norm = math.hypot(*self.boresight)
        require(abs(norm - 1.0) < 1e-3, "boresight", "must be a unit vector", self.boresight)
        if abs(norm - 1.0) > 1e-15:
            object.__setattr__(self, "boresight", tuple(value / norm for value in self.boresight))
        longest = MOST_FIXES / self.rate
        rule = f"must be at most {longest:g} s, {MOST_FIXES} periods of the star tracker"
        require(largest(self.latency) <= longest, "latency", rule, self.latency)

    def _fill(self, table: npt.NDArray[np.void], uniform: FloatArray) -> None:
        table["latency"] = draw(self.latency, uniform[:, 0])
        table["cross_noise"] = ARCSECOND * draw(self.cross_noise, uniform[:, 1])
        table["boresight_noise"] = ARCSECOND * draw(self.boresight_noise, uniform[:, 2])
        table["boresight"] = self.boresight


@serializable
@dataclass(frozen=True, kw_only=True)
class WheelTelemetry:
    """Tachometers that report the momentum of each wheel with white noise, in steps of a quantum.

    Parameters
    ----------
    noise
        Standard deviation of a sample of the momentum [N m s].
    quantum
        Step in which the momentum is reported [N m s]; zero for none.

    Raises
    ------
    ValueError
        If a value is negative.
    """

    noise: Interval = 0.0
    quantum: float = 0.0

    def __post_init__(self) -> None:
        """Check and normalise the fields."""
        normalise(self, non_negative_interval, "noise")
        normalise(self, non_negative, "quantum")

    def _fill(self, table: npt.NDArray[np.void], uniform: FloatArray) -> None:
        table["wheel_momentum_noise"] = draw(self.noise, uniform[:, 0])
        table["wheel_momentum_quantum"] = self.quantum


@serializable
@dataclass(frozen=True, kw_only=True)
class ModalTelemetry:
    """Strain gauges that report displacement and rate of each vibration mode with white noise.

    Parameters
    ----------
    displacement_noise
        Standard deviation of a sample of the modal displacement [kg^1/2 m].
    rate_noise
        Standard deviation of a sample of the modal rate [kg^1/2 m/s].

    Raises
    ------
    ValueError
        If a value is negative.
    """

    displacement_noise: Interval = 0.0
    rate_noise: Interval = 0.0

    def __post_init__(self) -> None:
        """Check and normalise the fields."""
        normalise(self, non_negative_interval, "displacement_noise", "rate_noise")

    def _fill(self, table: npt.NDArray[np.void], uniform: FloatArray) -> None:
        table["modal_displacement_noise"] = draw(self.displacement_noise, uniform[:, 0])
        table["modal_rate_noise"] = draw(self.rate_noise, uniform[:, 1])


_DEVIATES: dict[str, slice] = {
    "star_tracker": slice(0, 3),
    "gyro": slice(3, 15),
    "wheels": slice(15, 16),
    "modes": slice(16, 18),
}
"""Uniform deviates of each part of a suite: those of one do not depend on the others."""


@serializable
@dataclass(frozen=True, kw_only=True)
class SensorSuite:
    """Sensors of a spacecraft by their data sheets; a part that is None measures without errors or delay.

    Parameters
    ----------
    star_tracker
        Star tracker.
    gyro
        Gyros.
    wheels
        Telemetry of the wheels.
    modes
        Telemetry of the vibration modes.

    Raises
    ------
    ValueError
        If a part is of another class.
    """

    star_tracker: StarTracker | None = None
    gyro: Gyro | None = None
    wheels: WheelTelemetry | None = None
    modes: ModalTelemetry | None = None

    def __post_init__(self) -> None:
        """Check the classes of the parts."""
        kinds: dict[str, type] = {
            "star_tracker": StarTracker, "gyro": Gyro, "wheels": WheelTelemetry, "modes": ModalTelemetry,
        }  # fmt: skip
        for name, kind in kinds.items():
            part = getattr(self, name)
            require(part is None or isinstance(part, kind), name, f"must be a {kind.__name__} or None", part)

    @property
    def uniform_count(self) -> int:
        """Number of uniform deviates that one episode needs."""
        return 18

    def draw(self, uniform: FloatArray) -> npt.NDArray[np.void]:
        """Draw the sensor parameters of N spacecraft from uniform deviates (N, 18); returns SUITE records (N,)."""
        table = np.zeros(len(uniform), SUITE)
        table["boresight"], table["correlation_time"] = (0.0, 0.0, 1.0), 1.0
        for name, columns in _DEVIATES.items():
            if (part := getattr(self, name)) is not None:
                part._fill(table, uniform[:, columns])
        return table

    def tracker_periods(self, control_period: float) -> int:
        """Return the control periods from one sample of the star tracker to the next."""
        return 1 if self.star_tracker is None else round(1.0 / (self.star_tracker.rate * control_period))

    def fixes(self, control_period: float) -> int:
        """Return the samples of the star tracker that are stored at once: those in the pipeline, and the newest."""
        if self.star_tracker is None:
            return 1
        longest = latency_periods(largest(self.star_tracker.latency), control_period)
        return longest // self.tracker_periods(control_period) + 1

    def check(self, control_period: float, duration: float, fastest: float) -> None:
        """Check the sensors against the timing of a scenario.

        Parameters
        ----------
        control_period, duration
            Those of the scenario [s].
        fastest
            Fastest rate that the plant integrates [rad/s].

        Raises
        ------
        ValueError
            If samples of the star tracker do not fall on control ticks, or an error of the gyros is too large.
        """
        if (tracker := self.star_tracker) is not None:
            highest = 1.0 / control_period
            rule = f"must not be above that of the control periods, {highest:.6g} Hz"
            require(tracker.rate <= highest * (1.0 + 1e-9), "star_tracker.rate", rule, tracker.rate)
            ratio = 1.0 / (tracker.rate * control_period)
            whole = abs(ratio - round(ratio)) <= 1e-9 * ratio
            rule = f"must have a period that is a multiple of control_period = {control_period!r} s"
            require(whole, "star_tracker.rate", rule, tracker.rate)
        if self.gyro is not None:
            with fields_named("gyro."):
                self.gyro.check(control_period, duration, fastest)


def latency_periods(latency: float, control_period: float) -> int:
    """Return the control periods from a sample to the first tick at which it is available."""
    return math.ceil(latency / control_period - 1e-9)
