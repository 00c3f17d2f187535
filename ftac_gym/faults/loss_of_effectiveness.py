"""Loss of effectiveness: the wheel gives a fraction of the commanded torque."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from ftac_gym.faults.fault import WheelFault
from ftac_gym.faults.table import FaultKind
from ftac_gym.utils.parameters import FloatArray, Interval, bounds, draw, interval, require


@dataclass(frozen=True, kw_only=True)
class LossOfEffectiveness(WheelFault):
    """Effectiveness e(t) = effectiveness + amplitude * sin(frequency * t + phase), with t the time of the episode.

    Parameters
    ----------
    effectiveness
        The constant part, in [0, 1].
    amplitude
        Amplitude of the varying part; e(t) must stay within [0, 1].
    frequency
        Angular frequency [rad/s].
    phase
        Phase [rad].

    Raises
    ------
    ValueError
        If e(t) can leave [0, 1].
    """

    kind: ClassVar[FaultKind] = FaultKind.LOSS_OF_EFFECTIVENESS

    effectiveness: Interval = 0.5
    amplitude: Interval = 0.0
    frequency: Interval = 0.0
    phase: Interval = 0.0

    def __post_init__(self) -> None:
        """Check and normalise the fields."""
        super().__post_init__()
        for name in ("effectiveness", "amplitude", "frequency", "phase"):
            object.__setattr__(self, name, interval(getattr(self, name), name))
        low, high = bounds(self.effectiveness)
        swing = max(abs(value) for value in bounds(self.amplitude))
        require(
            low - swing >= -1e-12 and high + swing <= 1.0 + 1e-12,
            "effectiveness",
            f"with amplitude {self.amplitude!r} must stay within [0, 1]",
            self.effectiveness,
        )

    def _fill(self, rows: npt.NDArray[np.void], uniform: FloatArray, torque_limit: FloatArray) -> None:
        rows["effectiveness"] = draw(self.effectiveness, uniform[:, 0])
        rows["effectiveness_amplitude"] = draw(self.amplitude, uniform[:, 1])
        rows["effectiveness_frequency"] = draw(self.frequency, uniform[:, 2])
        rows["effectiveness_phase"] = draw(self.phase, uniform[:, 3])
