"""Faults of wheels and sensors: one kind per file, what draws them, and how to add a kind from outside."""

from ftac_gym.faults.attitude_spike import AttitudeSpike
from ftac_gym.faults.bias import Bias
from ftac_gym.faults.command_delay import CommandDelay
from ftac_gym.faults.distribution import FaultDistribution
from ftac_gym.faults.drifting_effectiveness import DriftingEffectiveness
from ftac_gym.faults.effect import FaultEffect, fault_effect
from ftac_gym.faults.fault import Fault, SensorFault, WheelFault
from ftac_gym.faults.friction_rise import FrictionRise
from ftac_gym.faults.gyro_bias_step import GyroBiasStep
from ftac_gym.faults.hard_over import HardOver
from ftac_gym.faults.intermittent_shutdown import IntermittentShutdown
from ftac_gym.faults.lock_in_place import LockInPlace
from ftac_gym.faults.loss_of_effectiveness import LossOfEffectiveness
from ftac_gym.faults.outage import Outage
from ftac_gym.faults.registry import label_of, register, registered
from ftac_gym.faults.schedule import FaultSchedule
from ftac_gym.faults.seizure import Seizure
from ftac_gym.faults.star_tracker_outage import StarTrackerOutage
from ftac_gym.faults.table import FAULT, SENSOR_FAULT, CustomKind, DrawnFaults, FaultKind
from ftac_gym.utils.serialization import serializable

KINDS: tuple[type[Fault], ...] = (
    LossOfEffectiveness,
    DriftingEffectiveness,
    Bias,
    Outage,
    LockInPlace,
    HardOver,
    FrictionRise,
    Seizure,
    IntermittentShutdown,
    CommandDelay,
    GyroBiasStep,
    StarTrackerOutage,
    AttitudeSpike,
)
"""All fault kinds of this package; :func:`registered` has those from outside too."""

for _kind in KINDS:
    serializable(_kind)

__all__ = [
    "FAULT",
    "KINDS",
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
