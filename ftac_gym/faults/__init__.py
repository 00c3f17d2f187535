"""Faults of wheels and sensors: their kinds, their drawing, and the registration of custom kinds."""

from ftac_gym.faults.distribution import FaultDistribution
from ftac_gym.faults.effect import FaultEffect, fault_effect
from ftac_gym.faults.effectiveness_faults import DriftingEffectiveness, LossOfEffectiveness
from ftac_gym.faults.fault import Fault, SensorFault, WheelFault
from ftac_gym.faults.registry import KINDS, label_of, register, registered
from ftac_gym.faults.schedule import FaultSchedule
from ftac_gym.faults.sensor_faults import AttitudeSpike, GyroBiasStep, StarTrackerOutage
from ftac_gym.faults.table import FAULT, LONGEST_DELAY, SENSOR_FAULT, CustomKind, DrawnFaults, FaultKind
from ftac_gym.faults.wheel_faults import (
    Bias,
    CommandDelay,
    FrictionRise,
    HardOver,
    IntermittentShutdown,
    LockInPlace,
    Outage,
    Seizure,
)

__all__ = [
    "FAULT",
    "KINDS",
    "LONGEST_DELAY",
    "SENSOR_FAULT",
    "AttitudeSpike",
    "Bias",
    "CommandDelay",
    "CustomKind",
    "DrawnFaults",
    "DriftingEffectiveness",
    "Fault",
    "FaultDistribution",
    "FaultEffect",
    "FaultKind",
    "FaultSchedule",
    "FrictionRise",
    "GyroBiasStep",
    "HardOver",
    "IntermittentShutdown",
    "LockInPlace",
    "LossOfEffectiveness",
    "Outage",
    "Seizure",
    "SensorFault",
    "StarTrackerOutage",
    "WheelFault",
    "fault_effect",
    "label_of",
    "register",
    "registered",
]
