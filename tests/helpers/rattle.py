"""A kind of fault from outside the package, as the source of a module or a script."""

RATTLE = """
from dataclasses import dataclass
from typing import ClassVar
from ftac_gym.faults import CustomKind, WheelFault, register

@register
@dataclass(frozen=True, kw_only=True)
class Rattle(WheelFault):
    kind: ClassVar[CustomKind] = CustomKind(100, "rattle")

    def _fill(self, rows, uniform, torque_limit):
        rows["bias_amplitude"] = 0.1 * torque_limit
"""
