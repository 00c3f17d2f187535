"""Wheel faults: one kind per file, and the distributions that draw them."""

from ftac_gym.faults.bias import Bias
from ftac_gym.faults.distribution import FaultDistribution, FaultSchedule
from ftac_gym.faults.effect import fault_effect
from ftac_gym.faults.fault import Fault
from ftac_gym.faults.hard_over import HardOver
from ftac_gym.faults.lock_in_place import LockInPlace
from ftac_gym.faults.loss_of_effectiveness import LossOfEffectiveness
from ftac_gym.faults.outage import Outage
from ftac_gym.faults.table import FAULT, FaultKind, no_faults

__all__ = [
    "FAULT",
    "Bias",
    "Fault",
    "FaultDistribution",
    "FaultKind",
    "FaultSchedule",
    "HardOver",
    "LockInPlace",
    "LossOfEffectiveness",
    "Outage",
    "fault_effect",
    "no_faults",
]
