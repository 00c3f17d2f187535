"""The numerical example of Cao, Gong and Han 2022 (Processes 10, 2294, section 5).

A turn back to the inertial axes with three wheels, none of them redundant, that lose effectiveness one after the
other. The wheels are ideal torquers without gyroscopic coupling, as in the paper's equations. The control period is
the interval of its learning observer.

The paper leaves these open, and they are chosen here:

- the torque limit, no momentum limit, perfect sensors;
- no inertia uncertainty (the paper has one without giving it);
- the integrator's step, the length of the episode and the success criterion.

All other numbers are the authors'.
"""

import math

import numpy as np

from ftac_gym.attitude import quaternion_from_mrp
from ftac_gym.faults import FaultSchedule, LossOfEffectiveness
from ftac_gym.spacecraft import Spacecraft, WheelArray, three_orthogonal
from ftac_gym.task import Disturbance, Harmonic, InitialState, Scenario, fixed_attitude


def cao_2022() -> Scenario:
    """Return the scenario.

    The paper bounds the torque by a number that it does not give; here it is 20 N m [chosen]. Without a limit its
    controller, with the exponent that makes it usable, reaches 20.5 N m: the limit changes little.
    """
    attitude = quaternion_from_mrp(np.array([0.3, -0.2, 0.2]))
    cosine = 0.5 * math.pi
    return Scenario(
        name="cao_2022",
        spacecraft=Spacecraft(
            ((36.0, 0.0, 0.0), (0.0, 17.0, 0.0), (0.0, 0.0, 26.0)),  # kg m^2
            WheelArray(three_orthogonal(), torque_limit=20.0, momentum_coupling=False),
        ),
        initial_state=InitialState.fixed(attitude=attitude.tolist()),
        reference=fixed_attitude(),
        faults=FaultSchedule(
            (
                LossOfEffectiveness(wheel=0, onset=5.0, effectiveness=0.8),
                LossOfEffectiveness(wheel=1, onset=8.0, effectiveness=0.6),
                LossOfEffectiveness(
                    wheel=2, onset=10.0, effectiveness=0.4, amplitude=0.05, frequency=0.25, phase=cosine
                ),
            )
        ),
        # 0.01 (|w|^2 + 0.05) [sin 0.8 t, cos 0.5 t, cos 0.3 t]: one harmonic per axis.
        disturbance=Disturbance(
            harmonics=(
                Harmonic((0.01, 0.0, 0.0), frequency=0.8),
                Harmonic((0.0, 0.01, 0.0), frequency=0.5, phase=(0.0, cosine, 0.0)),
                Harmonic((0.0, 0.0, 0.01), frequency=0.3, phase=(0.0, 0.0, cosine)),
            ),
            rate_offset=0.05,
        ),
        control_period=0.01,
        physics_step=0.01,
        duration=40.0,
    )
