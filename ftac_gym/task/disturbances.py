"""External torques: a constant and harmonics, with a factor that may grow with the body rate."""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ftac_gym.utils.parameters import (
    FloatArray,
    Interval,
    Intervals,
    bounds,
    draw,
    draw_axes,
    interval,
    intervals,
    largest,
    non_negative,
    normalise,
    optional,
    require,
)
from ftac_gym.utils.serialization import serializable

DISTURBANCE = np.dtype([("constant", "f8", (3,)), ("rate_scaled", "f8"), ("rate_offset", "f8")])
"""Per spacecraft: constant torque [N m]; flag 1.0 if scaled by (``|w|^2`` + c); the offset c [rad^2/s^2]."""

HARMONIC = np.dtype([("frequency", "f8"), ("sine", "f8", (3,)), ("cosine", "f8", (3,))])
"""Per spacecraft and harmonic: frequency [rad/s], amplitudes of sin(f t) and cos(f t) [N m]."""


@serializable
@dataclass(frozen=True)
class Harmonic:
    """One harmonic, amplitude * sin(frequency * t + phase) on each body axis.

    Parameters
    ----------
    amplitude
        Torque amplitude per axis [N m].
    frequency
        Angular frequency [rad/s].
    phase
        Phase per axis [rad].
    """

    amplitude: Intervals
    frequency: Interval
    phase: Intervals = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        """Check and normalise the fields."""
        normalise(self, intervals, "amplitude", "phase")
        normalise(self, interval, "frequency")


@serializable
@dataclass(frozen=True)
class Disturbance:
    """External torque d(t), a constant and the sum of harmonics, in body axes.

    Parameters
    ----------
    constant
        Constant torque per axis [N m].
    harmonics
        The harmonics; each episode draws its own amplitudes, frequencies and phases.
    rate_offset
        c of the factor (``|w|^2`` + c) on the whole torque (Chen et al. 2018, Eq. (62)); None for no such factor.
    """

    constant: Intervals = (0.0, 0.0, 0.0)
    harmonics: tuple[Harmonic, ...] = ()
    rate_offset: float | None = None

    def __post_init__(self) -> None:
        """Check and normalise the fields."""
        normalise(self, intervals, "constant")
        normalise(self, optional(non_negative), "rate_offset")
        valid = isinstance(self.harmonics, (tuple, list))
        require(valid, "harmonics", "must be a tuple of Harmonic objects", self.harmonics)
        object.__setattr__(self, "harmonics", tuple(self.harmonics))
        for harmonic in self.harmonics:
            require(isinstance(harmonic, Harmonic), "harmonics", "must hold Harmonic objects", harmonic)

    @property
    def uniform_count(self) -> int:
        """Number of uniform deviates of one episode."""
        return 3 + 7 * len(self.harmonics)

    def largest_torque(self, moment: float) -> float:
        """Return a bound on the torque [N m], before any scaling with the rate; it does not depend on the inertia."""
        sizes = [self.constant, *(harmonic.amplitude for harmonic in self.harmonics)]
        return math.hypot(*(sum(largest(size[axis]) for size in sizes) for axis in range(3)))

    def swing(self, time: float) -> float:
        """Return a bound on the impulse of the torque within a time [N m s], in body axes: harmonics turn back."""
        lasting = math.hypot(*(largest(value) * time for value in self.constant))
        for harmonic in self.harmonics:
            slowest = min(abs(bound) for bound in bounds(harmonic.frequency))
            wave = min(time, 2.0 / slowest) if slowest > 0.0 else time
            lasting += math.hypot(*map(largest, harmonic.amplitude)) * wave
        return lasting

    def draw(
        self, uniform: FloatArray, inertia: FloatArray | None = None
    ) -> tuple[npt.NDArray[np.void], npt.NDArray[np.void]]:
        """Draw N torques from uniform deviates (N, uniform_count); they do not depend on the inertia.

        Returns
        -------
        Arrays of DISTURBANCE (N,) and HARMONIC (N, harmonics).
        """
        count = len(uniform)
        steady = np.zeros(count, DISTURBANCE)
        steady["constant"] = draw_axes(self.constant, uniform[:, 0:3])
        if self.rate_offset is not None:
            steady["rate_scaled"] = 1.0
            steady["rate_offset"] = self.rate_offset
        table = np.zeros((count, len(self.harmonics)), HARMONIC)
        for column, harmonic in enumerate(self.harmonics):
            part = uniform[:, 3 + 7 * column : 10 + 7 * column]
            amplitude = draw_axes(harmonic.amplitude, part[:, 0:3])
            phase = draw_axes(harmonic.phase, part[:, 3:6])
            table["frequency"][:, column] = draw(harmonic.frequency, part[:, 6])
            table["sine"][:, column] = amplitude * np.cos(phase)
            table["cosine"][:, column] = amplitude * np.sin(phase)
        return steady, table
