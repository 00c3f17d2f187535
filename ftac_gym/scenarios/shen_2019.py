"""The numerical example of Shen, Yue, Goh and Wang 2019 (IEEE Transactions on Industrial Electronics 66(5)).

The best documented hardware-like case of the field: noisy sensors, misaligned gyros, a 10 Hz controller and four
0.2 N m wheels. Two wheels lose effectiveness at 5 s and two have a bias from 100 s on; one wheel has both.

The paper leaves these open, and they are chosen here:

- the wheels' momentum limit (that of the smallest wheel of this torque), the target (the inertial axes);
- the integrator's step, rest at the start and the success criterion.

All other numbers are the authors'.
"""

import math

from ftac_gym.faults import Bias, FaultSchedule, LossOfEffectiveness
from ftac_gym.spacecraft import Spacecraft, WheelArray
from ftac_gym.task import Disturbance, Harmonic, InitialState, Scenario, SensorErrors

_DEGREE = math.pi / 180.0


def shen_2019() -> Scenario:
    """Return the scenario."""
    vector = (-0.5, 0.3, -0.4)
    attitude = (math.sqrt(1.0 - sum(value * value for value in vector)), *vector)
    bias = _DEGREE / 3600.0  # 1 deg/h
    return Scenario(
        name="shen_2019",
        spacecraft=Spacecraft(
            ((10.0, 1.2, 0.5), (1.2, 19.0, 1.5), (0.5, 1.5, 25.0)),  # kg m^2
            WheelArray.sign_pyramid(torque_limit=0.2, momentum_limit=12.0),
        ),
        initial_state=InitialState.fixed(attitude=attitude),
        faults=FaultSchedule(
            (
                LossOfEffectiveness(wheel=0, onset=5.0, effectiveness=0.4),
                LossOfEffectiveness(wheel=1, onset=5.0, effectiveness=0.8),
                Bias(wheel=1, onset=100.0, constant=-0.03),
                Bias(wheel=2, onset=100.0, constant=-0.06),
            )
        ),
        disturbance=Disturbance(harmonics=(Harmonic((0.005,) * 3, frequency=1.0),)),
        sensors=SensorErrors(
            attitude_noise=0.005 * _DEGREE,
            rate_noise=5e-4 * _DEGREE,
            gyro_bias=bias,
            gyro_misalignment=0.1 * _DEGREE,
        ),
        control_period=0.1,
        physics_step=0.02,
        duration=200.0,
    )
