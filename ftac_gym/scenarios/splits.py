"""The other splits of the flagship: the same task, each with a difference that training does not have."""

from dataclasses import fields, is_dataclass, replace
from typing import Any

from ftac_gym.faults import (
    AttitudeSpike,
    Bias,
    CommandDelay,
    FaultDistribution,
    FrictionRise,
    GyroBiasStep,
    HardOver,
    IntermittentShutdown,
    LossOfEffectiveness,
    Seizure,
    StarTrackerOutage,
)
from ftac_gym.scenarios.flagship import DEGREE, ONSET, faults, flagship, gyro, sensors, spacecraft
from ftac_gym.spacecraft import Friction, Spacecraft, WheelArray, catalogue, sign_pyramid
from ftac_gym.task import InertiaUncertainty, LowOrbitTorque, Scenario

SPLITS = (
    "flagship",
    *(f"flagship_{name}" for name in ("severe", "unseen", "double", "plant", "noise", "delay", "hardware")),
)
"""The flagship and its splits, in the order of tables."""

_WHEEL = catalogue.get("hr12-12")


def _with_wheels(wheels: WheelArray) -> Spacecraft:
    return replace(spacecraft(), wheels=wheels)


def flagship_severe() -> Scenario:
    """Return the split with magnitudes beyond those of training."""
    severe = FaultDistribution(
        kinds=(
            LossOfEffectiveness(onset=ONSET, effectiveness=(0.0, 0.1)),
            Bias(onset=ONSET, constant=(0.1, 0.14), random_sign=True),
            Bias(onset=ONSET, slope=(1e-3, 3e-3), random_sign=True),
            Bias(onset=ONSET, amplitude=(0.08, 0.13), frequency=(0.05, 0.5), random_sign=True),
            HardOver(onset=ONSET, fraction=(0.5, 0.75)),
        ),
        weights=(0.5, 1.5, 1.0, 1.0, 1.0),
        fault_counts=(0.0, 0.7, 0.3),
    )
    return flagship().replace(name="flagship_severe", faults=severe)


def flagship_unseen() -> Scenario:
    """Return the split with fault kinds that training does not have: of wheels with friction, and of sensors."""
    unseen = FaultDistribution(
        kinds=(
            FrictionRise(onset=ONSET, factor=(5.0, 20.0)),
            FrictionRise(onset=ONSET, factor=(5.0, 20.0), direction="either"),
            Seizure(onset=ONSET),
            IntermittentShutdown(onset=ONSET, mean_acting=5.0, mean_resting=10.0),
            CommandDelay(onset=ONSET),
            GyroBiasStep(onset=ONSET, size=(0.002 * DEGREE, 0.02 * DEGREE)),
            StarTrackerOutage(onset=ONSET, duration=(10.0, 60.0)),
            AttitudeSpike(onset=ONSET, angle=(0.1 * DEGREE, 2.0 * DEGREE), period=(3.0, 10.0), on_time=(0.1, 0.3)),
        ),
        weights=(1.0, 1.0, 2.0, 2.0, 2.0, 1.0, 1.0, 1.0),
    )
    friction = Friction(_WHEEL.coulomb or 0.0)
    wheels = replace(spacecraft().wheels, spin_inertia=_WHEEL.spin_inertia, friction=friction)
    return flagship().replace(name="flagship_unseen", spacecraft=_with_wheels(wheels), faults=unseen)


def flagship_double() -> Scenario:
    """Return the split in which two wheels fail in every episode."""
    return flagship().replace(name="flagship_double", faults=replace(faults(), fault_counts=(0.0, 0.0, 1.0)))


def flagship_plant() -> Scenario:
    """Return the split with an inertia uncertainty of 30 % instead of 10 %."""
    return flagship().replace(name="flagship_plant", inertia_uncertainty=InertiaUncertainty(relative=0.3))


def flagship_noise() -> Scenario:
    """Return the split with three times the noise, the biases and the random walks of the sensors."""
    return flagship().replace(name="flagship_noise", sensors=_noisier(sensors(), 3.0))


def _noisier(part: Any, factor: float) -> Any:
    """Return sensors, or a part of them, with their noise, biases and random walks times a factor."""
    changes: dict[str, Any] = {}
    for field in fields(part):
        value = getattr(part, field.name)
        if is_dataclass(value):
            changes[field.name] = _noisier(value, factor)
        elif any(word in field.name for word in ("noise", "bias", "walk")):
            scaled = tuple(factor * bound for bound in value) if isinstance(value, tuple) else factor * value
            changes[field.name] = scaled
    return replace(part, **changes)


def flagship_delay() -> Scenario:
    """Return the split whose loop is one to four control periods later than it should be, constant in an episode."""
    return flagship().replace(name="flagship_delay", extra_delay=(1, 4))


def flagship_hardware() -> Scenario:
    """Return the split with real wheels, misaligned gyros and the torques of a low orbit.

    The wheels are the catalogue's HR12 of 12 N m s. Their lag of 30 ms and power limit of 60 W are chosen.
    """
    wheels = _WHEEL.array(sign_pyramid(), lag=0.03, power_limit=60.0)
    return flagship().replace(
        name="flagship_hardware",
        spacecraft=_with_wheels(wheels),
        sensors=replace(sensors(), gyro=replace(gyro(), misalignment=0.1)),
        disturbance=LowOrbitTorque(),
    )
