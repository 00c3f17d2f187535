"""The task: a scenario, the episodes drawn from it, and the parts that both are made of."""

from ftac_gym.task.disturbances import Disturbance, Harmonic
from ftac_gym.task.episodes import Episodes
from ftac_gym.task.gyro import Gyro
from ftac_gym.task.inertia import InertiaUncertainty
from ftac_gym.task.initial_state import InitialState
from ftac_gym.task.low_orbit import LowOrbitTorque
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.objective import CostBounds, RewardWeights, SuccessCriterion
from ftac_gym.task.prescribed_bound import PrescribedBound
from ftac_gym.task.references import MRPSinusoid, RateProfile, SetPoints, fixed_attitude
from ftac_gym.task.sampled_reference import SampledReference
from ftac_gym.task.scenario import Scenario, success_steps
from ftac_gym.task.sensor_suite import ModalTelemetry, SensorSuite, StarTracker, WheelTelemetry
from ftac_gym.task.sensors import SensorErrors
from ftac_gym.task.vibration import AppendageUncertainty

__all__ = [
    "AppendageUncertainty",
    "CostBounds",
    "Disturbance",
    "Episodes",
    "Gyro",
    "Harmonic",
    "InertiaUncertainty",
    "InitialState",
    "LowOrbitTorque",
    "MRPSinusoid",
    "Measurement",
    "ModalTelemetry",
    "PrescribedBound",
    "RateProfile",
    "RewardWeights",
    "SampledReference",
    "Scenario",
    "SensorErrors",
    "SensorSuite",
    "SetPoints",
    "StarTracker",
    "SuccessCriterion",
    "WheelTelemetry",
    "fixed_attitude",
    "success_steps",
]
