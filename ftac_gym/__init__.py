"""Gymnasium environments for learning-based fault-tolerant attitude control of spacecraft.

Importing the package registers the environment ids. Modules that need the compiler or PyTorch are imported when they
are first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

import gymnasium as gym

if TYPE_CHECKING:
    from ftac_gym import baselines, evaluation, faults, scenarios, spacecraft, wrappers
    from ftac_gym.dynamics import DivergenceError, Simulator
    from ftac_gym.envs import SpacecraftFTCEnv, SpacecraftFTCVectorEnv, make, make_vec
    from ftac_gym.faults import (
        AttitudeSpike,
        Bias,
        CommandDelay,
        DriftingEffectiveness,
        FaultDistribution,
        FaultSchedule,
        FrictionRise,
        GyroBiasStep,
        HardOver,
        IntermittentShutdown,
        LockInPlace,
        LossOfEffectiveness,
        Outage,
        Seizure,
        StarTrackerOutage,
    )
    from ftac_gym.spacecraft import FlexibleAppendages, Friction, Spacecraft, WheelArray
    from ftac_gym.task import (
        AppendageUncertainty,
        CostBounds,
        Disturbance,
        Episodes,
        Gyro,
        Harmonic,
        InertiaUncertainty,
        InitialState,
        LowOrbitTorque,
        Measurement,
        ModalTelemetry,
        MRPSinusoid,
        PrescribedBound,
        RateProfile,
        RewardWeights,
        SampledReference,
        Scenario,
        SensorErrors,
        SensorSuite,
        SetPoints,
        StarTracker,
        SuccessCriterion,
        WheelTelemetry,
        fixed_attitude,
    )

__version__ = "0.1.0"

__all__ = [
    "AppendageUncertainty",
    "AttitudeSpike",
    "Bias",
    "CommandDelay",
    "CostBounds",
    "Disturbance",
    "DivergenceError",
    "DriftingEffectiveness",
    "Episodes",
    "FaultDistribution",
    "FaultSchedule",
    "FlexibleAppendages",
    "Friction",
    "FrictionRise",
    "Gyro",
    "GyroBiasStep",
    "HardOver",
    "Harmonic",
    "InertiaUncertainty",
    "InitialState",
    "IntermittentShutdown",
    "LockInPlace",
    "LossOfEffectiveness",
    "LowOrbitTorque",
    "MRPSinusoid",
    "Measurement",
    "ModalTelemetry",
    "Outage",
    "PrescribedBound",
    "RateProfile",
    "RewardWeights",
    "SampledReference",
    "Scenario",
    "Seizure",
    "SensorErrors",
    "SensorSuite",
    "SetPoints",
    "Simulator",
    "Spacecraft",
    "SpacecraftFTCEnv",
    "SpacecraftFTCVectorEnv",
    "StarTracker",
    "StarTrackerOutage",
    "SuccessCriterion",
    "WheelArray",
    "WheelTelemetry",
    "baselines",
    "evaluation",
    "faults",
    "fixed_attitude",
    "make",
    "make_vec",
    "scenarios",
    "spacecraft",
    "wrappers",
]

_MODULES = ("baselines", "evaluation", "faults", "scenarios", "spacecraft", "wrappers")
"""Public names that are modules."""

_PACKAGES = ("task", "spacecraft", "faults", "dynamics", "envs")
"""Packages that the other public names are imported from, the compiled ones last."""

_IDS = {
    "SpacecraftFTCEasy-v0": ("easy", 1300.0),
    "SpacecraftFTC-v0": ("flagship", 1700.0),
    "SpacecraftFTCTracking-v0": ("flagship_tracking", 1900.0),
    "SpacecraftFTCFlexible-v0": ("flexible", 1600.0),
    "SpacecraftFTCZhangZhou2019-v0": ("zhang_zhou_2019", 220.0),
    "SpacecraftFTCCao2022-v0": ("cao_2022", 7000.0),
    "SpacecraftFTCLi2023-v0": ("li_2023", 6500.0),
    "SpacecraftFTCMa2023-v0": ("ma_2023_faulty", 9500.0),
    "SpacecraftFTCChen2018-v0": ("chen_2018", 11000.0),
}
"""Environment ids with their scenarios and reward thresholds: those of ``docs/environments/returns.md``."""

for _id, (_scenario, _threshold) in _IDS.items():
    gym.register(
        id=_id,
        entry_point="ftac_gym.envs:SpacecraftFTCEnv",
        vector_entry_point="ftac_gym.envs:SpacecraftFTCVectorEnv",
        reward_threshold=_threshold,
        kwargs={"default_scenario": _scenario},
    )


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    if name in _MODULES:
        return import_module(f"{__name__}.{name}")
    packages = (import_module(f"{__name__}.{package}") for package in _PACKAGES)
    return next(getattr(package, name) for package in packages if name in package.__all__)


def __dir__() -> list[str]:
    """List the public names."""
    return sorted([*globals(), *__all__])
