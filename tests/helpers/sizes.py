"""Spacecraft of other sizes than the flagship: a 3U CubeSat and one of 300 kg, each with the tasks of its class."""

import math

from ftac_gym.faults import FaultDistribution, LossOfEffectiveness, Outage
from ftac_gym.scenarios import flagship
from ftac_gym.spacecraft import Spacecraft, WheelArray
from ftac_gym.spacecraft.layouts import pyramid, three_orthogonal
from ftac_gym.task import Disturbance, Gyro, InitialState, Scenario, SensorSuite, StarTracker, SuccessCriterion

DEGREE = math.pi / 180.0

CUBESAT = Scenario(
    name="cubesat",
    spacecraft=Spacecraft(
        inertia=((0.030, 5e-4, -3e-4), (5e-4, 0.032, 4e-4), (-3e-4, 4e-4, 0.007)),  # kg m^2
        wheels=WheelArray(axes=three_orthogonal(), torque_limit=4e-3, momentum_limit=0.01),
    ),
    initial_state=InitialState(max_rate=0.2 * DEGREE, wheel_momentum=(-1e-3, 1e-3)),
    disturbance=Disturbance(((-1e-6, 1e-6),) * 3),
    # A small star tracker, and the gyros of a good micromechanical unit.
    sensors=SensorSuite(
        star_tracker=StarTracker(rate=5.0, latency=0.2, cross_noise=10.0, boresight_noise=70.0),
        gyro=Gyro(angle_random_walk=0.15, rate_random_walk=1.0, bias=(-3.0, 3.0), scale_factor=(-500.0, 500.0)),
    ),
    control_period=0.2,
    loop_delay=0.2,
    duration=120.0,
    # White noise of these gyros is 0.006 deg/s at 5 Hz, which feedback returns as rates of up to 0.03 deg/s.
    success=SuccessCriterion(angle=0.1 * DEGREE, rate=0.05 * DEGREE),
)
"""A 3U CubeSat with three wheels of 4 mN m at 5 Hz, without faults."""


OBSERVATORY = Scenario(
    name="observatory",
    spacecraft=Spacecraft(
        inertia=((60.0, 4.0, -3.0), (4.0, 110.0, 5.0), (-3.0, 5.0, 150.0)),  # kg m^2
        wheels=WheelArray(axes=pyramid(35.0 * DEGREE, count=6), torque_limit=0.3, momentum_limit=20.0),
    ),
    initial_state=InitialState(max_rate=0.3 * DEGREE, wheel_momentum=(-1.0, 1.0)),
    disturbance=Disturbance(((-2e-4, 2e-4),) * 3),
    sensors=flagship.sensors(),
    control_period=0.1,
    loop_delay=0.1,
    duration=200.0,
)
"""A spacecraft of 300 kg with six wheels of 0.3 N m at 10 Hz, without faults."""

FAULTY_CUBESAT = CUBESAT.replace(
    name="faulty_cubesat",
    faults=FaultDistribution((LossOfEffectiveness(onset=(2.0, 40.0), effectiveness=(0.5, 0.9)),)),
)
"""One of the three wheels is weak."""

FAULTY_OBSERVATORY = OBSERVATORY.replace(
    name="faulty_observatory",
    faults=FaultDistribution(
        (LossOfEffectiveness(onset=(2.0, 60.0), effectiveness=(0.1, 0.8)), Outage(onset=(2.0, 60.0)))
    ),
)
"""One of the six wheels is weak or without torque."""
