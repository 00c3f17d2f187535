"""The flagship: a rest-to-rest slew from any attitude, then fine pointing, with faults of wheels.

The spacecraft is that of Shen et al. 2019 (IEEE TIE 66(5)): a mid-size body with four 0.2 N m, 12 N m s wheels in a
sign pyramid. The faults are weighted towards those that separate methods: bias, stuck torque and outage, at times when
torque is needed. Loss of effectiveness occurs too, but more rarely. Faults are abrupt or incipient, permanent or
recovering, steady or intermittent. :mod:`ftac_gym.scenarios.splits` holds the other splits.
"""

import math
from dataclasses import replace

from ftac_gym.faults import (
    Bias,
    DriftingEffectiveness,
    FaultDistribution,
    HardOver,
    LockInPlace,
    LossOfEffectiveness,
    Outage,
)
from ftac_gym.spacecraft import Spacecraft, WheelArray
from ftac_gym.task import (
    Disturbance,
    Gyro,
    Harmonic,
    InertiaUncertainty,
    InitialState,
    MRPSinusoid,
    Scenario,
    SensorSuite,
    StarTracker,
    WheelTelemetry,
)

ONSET = (2.0, 80.0)
"""Onsets of faults [s]: during the slew, during settling, during fine pointing."""

DEGREE = math.pi / 180.0

CONTROL_PERIOD = 0.1
"""Control period and loop delay [s]: a command takes effect when the next measurement is taken."""


def spacecraft() -> Spacecraft:
    """Return the nominal spacecraft."""
    inertia = ((10.0, 1.2, 0.5), (1.2, 19.0, 1.5), (0.5, 1.5, 25.0))  # kg m^2
    return Spacecraft(inertia, WheelArray.sign_pyramid(torque_limit=0.2, momentum_limit=12.0))


def faults() -> FaultDistribution:
    """Return the training distribution: a tenth healthy, most with one faulty wheel, some with two."""
    return FaultDistribution(
        kinds=(
            LossOfEffectiveness(onset=ONSET, effectiveness=(0.1, 0.8)),
            LossOfEffectiveness(
                onset=ONSET, effectiveness=(0.3, 0.7), amplitude=(0.1, 0.3), frequency=(0.1, 2.0), phase=(0.0, 6.283)
            ),
            DriftingEffectiveness(onset=ONSET, effectiveness=(0.0, 0.5), rise=(10.0, 60.0)),
            Bias(onset=ONSET, constant=(0.01, 0.1), random_sign=True),
            Bias(onset=ONSET, constant=(0.03, 0.1), random_sign=True, duration=(10.0, 30.0)),
            Bias(onset=ONSET, slope=(2e-4, 1e-3), random_sign=True),
            Bias(onset=ONSET, amplitude=(0.02, 0.08), frequency=(0.05, 0.5), random_sign=True),
            Bias(onset=ONSET, constant=(0.03, 0.1), random_sign=True, period=(10.0, 30.0), on_time=(3.0, 10.0)),
            Outage(onset=ONSET),
            Outage(onset=ONSET, duration=(10.0, 30.0)),
            LockInPlace(onset=ONSET),
            HardOver(onset=ONSET, fraction=(0.2, 0.5)),
        ),
        weights=(1.0, 0.5, 0.5, 1.5, 0.5, 1.0, 1.0, 1.0, 1.0, 0.5, 2.0, 1.0),
        fault_counts=(0.1, 0.75, 0.15),
    )


def disturbance() -> Disturbance:
    """Return a low-orbit torque: a constant and one slow harmonic."""
    constant, swing = (-5e-5, 5e-5), (0.0, 1e-4)  # N m
    phase = (0.0, 2.0 * math.pi)
    return Disturbance((constant,) * 3, (Harmonic((swing,) * 3, frequency=(1e-3, 0.02), phase=(phase,) * 3),))


def gyro() -> Gyro:
    """Return the gyros: like those of a small fibre-optic unit."""
    return Gyro(
        angle_random_walk=0.01,
        rate_random_walk=0.12,
        bias=(-1.0, 1.0),
        scale_factor=(-100.0, 100.0),
        misalignment=(0.0, 0.02),
    )


def sensors() -> SensorSuite:
    """Return star tracker, gyros and tachometers, with errors that data sheets of small spacecraft's units give."""
    return SensorSuite(
        star_tracker=StarTracker(rate=5.0, latency=0.15, cross_noise=6.0, boresight_noise=40.0),
        gyro=gyro(),
        wheels=WheelTelemetry(noise=5e-4),
    )


def flagship() -> Scenario:
    """Return the scenario of ``SpacecraftFTC-v0``."""
    return Scenario(
        name="flagship",
        spacecraft=spacecraft(),
        initial_state=InitialState(max_rate=1.0 * DEGREE, wheel_momentum=(-1.0, 1.0)),
        faults=faults(),
        disturbance=disturbance(),
        sensors=sensors(),
        inertia_uncertainty=InertiaUncertainty(relative=0.1),
        control_period=CONTROL_PERIOD,
        loop_delay=CONTROL_PERIOD,
        physics_step=0.02,
        duration=120.0,
        tumble_rate=0.5,
    )


def flagship_pointing() -> Scenario:
    """Return a training task for the flagship: on target from the start, with earlier faults."""
    usual = faults()
    kinds = tuple(replace(kind, onset=(2.0, 25.0)) for kind in usual.kinds)
    return flagship().replace(
        name="flagship_pointing",
        initial_state=InitialState(angle=(0.0, 0.1 * DEGREE), max_rate=0.01 * DEGREE, wheel_momentum=(-1.0, 1.0)),
        faults=replace(usual, kinds=kinds),
        duration=40.0,
    )


def flagship_tracking() -> Scenario:
    """Return the scenario of ``SpacecraftFTCTracking-v0``: the same spacecraft follows slow sinusoids."""
    amplitude, frequency, phase = (0.05, 0.15), (0.02, 0.06), (0.0, 2.0 * math.pi)
    return flagship().replace(
        name="flagship_tracking",
        initial_state=InitialState(angle=(0.0, 60.0 * DEGREE), max_rate=1.0 * DEGREE, wheel_momentum=(-1.0, 1.0)),
        reference=MRPSinusoid(amplitude=(amplitude,) * 3, frequency=(frequency,) * 3, phase=(phase,) * 3),
    )
