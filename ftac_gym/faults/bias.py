"""Additive bias: a torque that nobody commanded."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from ftac_gym.faults.fault import WheelFault, random_signs
from ftac_gym.faults.table import FaultKind
from ftac_gym.utils.parameters import FloatArray, Interval, bounds, draw, interval, require


@dataclass(frozen=True, kw_only=True)
class Bias(WheelFault):
    """Added torque b = constant + slope s + amplitude s^exponent sin(frequency s + phase), with s = t - onset.

    The bias adds to the limited command, so that the wheel's torque can exceed its command limit.

    Parameters
    ----------
    constant
        Constant part [N m].
    slope
        Ramp [N m/s].
    amplitude, exponent, frequency, phase
        The oscillating part [N m s^-exponent, -, rad/s, rad]; exponent 0 is a plain sinusoid.
    random_sign
        Whether each draw takes either sign with equal chances.

    Raises
    ------
    ValueError
        If the exponent can be negative (the bias would be infinite at the onset).
    """

    kind: ClassVar[FaultKind] = FaultKind.BIAS

    constant: Interval = 0.0
    slope: Interval = 0.0
    amplitude: Interval = 0.0
    exponent: Interval = 0.0
    frequency: Interval = 0.0
    phase: Interval = 0.0
    random_sign: bool = False

    def __post_init__(self) -> None:
        """Check and normalise the fields."""
        super().__post_init__()
        for name in ("constant", "slope", "amplitude", "exponent", "frequency", "phase"):
            object.__setattr__(self, name, interval(getattr(self, name), name))
        require(bounds(self.exponent)[0] >= 0.0, "exponent", "must not be negative", self.exponent)

    def _fill(self, rows: npt.NDArray[np.void], uniform: FloatArray, torque_limit: FloatArray) -> None:
        sign = random_signs(uniform[:, 6]) if self.random_sign else 1.0
        rows["bias"] = sign * draw(self.constant, uniform[:, 0])
        rows["bias_slope"] = sign * draw(self.slope, uniform[:, 1])
        rows["bias_amplitude"] = sign * draw(self.amplitude, uniform[:, 2])
        rows["bias_exponent"] = draw(self.exponent, uniform[:, 3])
        rows["bias_frequency"] = draw(self.frequency, uniform[:, 4])
        rows["bias_phase"] = draw(self.phase, uniform[:, 5])
