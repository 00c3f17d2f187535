"""The numerical examples of Ma, Wang and Wang 2023 (Mathematics 11, 3431, section 5).

A body with three wheels follows a slowly turning reference under a disturbance near the resonance of the paper's law.
In one example all three wheels have lost half of their effectiveness. In the other they are healthy, and the attitude's
quaternion starts with a negative scalar part. The wheels are ideal torquers without gyroscopic coupling, as in the
paper's equations.

The paper leaves these open, and they are chosen here:

- saturation of the wheels at the torque that the paper calls the largest, no momentum limit, perfect sensors;
- the control period, the integrator's step, the length of the episode and the success criterion.

All other numbers are the authors'.
"""

import math

from ftac_gym.faults import FaultSchedule, LossOfEffectiveness
from ftac_gym.spacecraft import Spacecraft, WheelArray, three_orthogonal
from ftac_gym.task import Disturbance, Harmonic, InitialState, RateProfile, Scenario

_SCALAR = math.sqrt(0.78)
"""Printed as 0.8832, with which the quaternion's norm is 1.00002."""


def ma_2023_faulty() -> Scenario:
    """Return the example of section 5.1, with the three wheels at about half of their effectiveness."""
    slow = math.pi / 100.0
    return Scenario(
        name="ma_2023_faulty",
        spacecraft=Spacecraft(
            ((22.0, 1.2, 0.9), (1.2, 19.0, 1.4), (0.9, 1.4, 18.0)),  # kg m^2
            WheelArray(three_orthogonal(), torque_limit=10.0, momentum_coupling=False),
        ),
        initial_state=InitialState.fixed((_SCALAR, 0.3, -0.2, -0.3), rate=(0.06, -0.04, 0.05)),
        reference=RateProfile(amplitude=(0.05, 0.05, 0.05), frequency=(slow, 2.0 * slow, 3.0 * slow)),
        faults=FaultSchedule(
            (
                LossOfEffectiveness(wheel=0, effectiveness=0.5, amplitude=0.01, frequency=10.0),
                LossOfEffectiveness(wheel=1, effectiveness=0.5, amplitude=0.02, frequency=20.0, phase=0.5 * math.pi),
                LossOfEffectiveness(wheel=2, effectiveness=0.5, amplitude=0.03, frequency=30.0),
            )
        ),
        disturbance=Disturbance(
            harmonics=(
                Harmonic((0.1, 0.0, 0.0), frequency=1.0),
                Harmonic((0.0, 0.2, 0.0), frequency=1.2),
                Harmonic((0.0, 0.0, 0.3), frequency=1.5),
            )
        ),
        control_period=0.01,
        physics_step=0.01,
        duration=60.0,
    )


def ma_2023_unwinding() -> Scenario:
    """Return the example of section 5.2, without faults.

    Its start is not the attitude of section 5.1 with the other sign of the quaternion: it is the inverse rotation. The
    sign matters to laws that treat q and -q as different attitudes.
    """
    return ma_2023_faulty().replace(
        name="ma_2023_unwinding",
        initial_state=InitialState.fixed((-_SCALAR, 0.3, -0.2, -0.3), rate=(0.06, -0.04, 0.05)),
        faults=None,
    )
