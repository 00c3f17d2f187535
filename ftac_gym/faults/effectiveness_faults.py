"""Fault kinds of reaction wheels that change the effectiveness of the motor."""

from dataclasses import dataclass, field
from typing import ClassVar

from ftac_gym.faults.fault import WheelFault, magnitude
from ftac_gym.faults.table import FaultKind
from ftac_gym.utils.parameters import Interval, bounds, largest, normalise, positive_interval, require
from ftac_gym.utils.serialization import serializable


@serializable
@dataclass(frozen=True, kw_only=True)
class LossOfEffectiveness(WheelFault):
    """Effectiveness e(t) = effectiveness + amplitude * sin(frequency * t + phase), with t the time of the episode.

    Parameters
    ----------
    effectiveness
        The constant part, in [0, 1].
    amplitude
        Amplitude of the varying part; e(t) must stay within [0, 1].
    frequency, phase
        Angular frequency [rad/s] and phase [rad].

    Raises
    ------
    ValueError
        If e(t) can leave [0, 1].
    """

    kind: ClassVar[FaultKind] = FaultKind.LOSS_OF_EFFECTIVENESS
    effectiveness: Interval = field(default=0.5, metadata=magnitude("effectiveness"))
    amplitude: Interval = field(default=0.0, metadata=magnitude("effectiveness_amplitude"))
    frequency: Interval = field(default=0.0, metadata=magnitude("effectiveness_frequency"))
    phase: Interval = field(default=0.0, metadata=magnitude("effectiveness_phase"))

    def __post_init__(self) -> None:
        """Check and normalise the fields."""
        super().__post_init__()
        low, high = bounds(self.effectiveness)
        swing = largest(self.amplitude)
        rule = f"with amplitude {self.amplitude!r} must stay within [0, 1]"
        inside = low - swing >= -1e-12 and high + swing <= 1.0 + 1e-12
        require(inside, "effectiveness", rule, self.effectiveness)


@serializable
@dataclass(frozen=True, kw_only=True)
class DriftingEffectiveness(WheelFault):
    """Effectiveness that falls from one to ``effectiveness`` over ``rise`` seconds and stays there.

    Parameters
    ----------
    effectiveness
        End of the drift, in [0, 1].
    rise
        Length of the drift [s]; above zero.
    """

    kind: ClassVar[FaultKind] = FaultKind.DRIFTING_EFFECTIVENESS
    effectiveness: Interval = field(default=0.2, metadata=magnitude("effectiveness", low=0.0, high=1.0))
    rise: Interval = (20.0, 60.0)

    def __post_init__(self) -> None:
        """Check and normalise the fields."""
        super().__post_init__()
        normalise(self, positive_interval, "rise")
