"""The numerical example of Chen, Chen, He and Sun 2018 (Complexity, section 5).

A heavy body with three wheels comes to rest within bounds that shrink to 0.001 of an MRP. Meanwhile its inertia varies
and its wheels drop to a fifth of their effectiveness. The wheels are ideal torquers without gyroscopic coupling, as in
the paper's equations.

The paper leaves these open, and they are chosen here:

- healthy wheels before the faults, no momentum limit, perfect sensors;
- the factors of the bounds at the start (infinity is printed);
- the control period, the integrator's step, the length of the episode and the success criterion.

All other numbers are the authors'.
"""

import math

import numpy as np

from ftac_gym.attitude import quaternion_from_mrp
from ftac_gym.faults import FaultSchedule, LossOfEffectiveness
from ftac_gym.spacecraft import Spacecraft, WheelArray, three_orthogonal
from ftac_gym.task import (
    Disturbance,
    Harmonic,
    InertiaUncertainty,
    InitialState,
    PrescribedBound,
    Scenario,
    fixed_attitude,
)


def _inertia(rate_torque: bool) -> InertiaUncertainty:
    return InertiaUncertainty(amplitude=(5.0, 7.0, 9.0), frequency=(0.1, 0.2, 0.3), rate_torque=rate_torque)


def _fault(wheel: int, onset: float, frequency: float) -> LossOfEffectiveness:
    return LossOfEffectiveness(wheel=wheel, onset=onset, effectiveness=0.2, amplitude=0.1, frequency=frequency)


def chen_2018() -> Scenario:
    """Return the scenario as printed: without the torque -J' w that the varying inertia would make."""
    attitude = quaternion_from_mrp(np.array([-0.3, -0.4, 0.2]))
    quarter = 0.5 * math.pi
    return Scenario(
        name="chen_2018",
        spacecraft=Spacecraft(
            ((350.0, 3.0, 4.0), (3.0, 270.0, 10.0), (4.0, 10.0, 192.0)),  # kg m^2
            WheelArray(three_orthogonal(), torque_limit=8.0, momentum_coupling=False),
        ),
        initial_state=InitialState.fixed(attitude=attitude.tolist()),
        reference=fixed_attitude(),
        faults=FaultSchedule(
            (_fault(0, 15.0, 0.2 * math.pi), _fault(1, 12.0, 0.3 * math.pi), _fault(2, 10.0, 0.4 * math.pi))
        ),
        # (|w|^2 + 0.05) [sin 0.8 t, cos 0.5 t, sin 0.3 t]: one harmonic per axis.
        disturbance=Disturbance(
            harmonics=(
                Harmonic((1.0, 0.0, 0.0), frequency=0.8),
                Harmonic((0.0, 1.0, 0.0), frequency=0.5, phase=(0.0, quarter, 0.0)),
                Harmonic((0.0, 0.0, 1.0), frequency=0.3),
            ),
            rate_offset=0.05,
        ),
        inertia_uncertainty=_inertia(rate_torque=False),
        control_period=0.005,
        physics_step=0.005,
        duration=60.0,
        prescribed_bound=PrescribedBound(
            0.5, 0.001, decay=0.1, lower=(0.8, 1.0, 0.2), upper=(0.2, 0.2, 0.8), initial_factor=2.0, factor_decay=5.0
        ),
    )


def chen_2018_rate_torque() -> Scenario:
    """Return the scenario with the torque -J' w of Euler's equation, which the paper leaves out."""
    return chen_2018().replace(name="chen_2018_rate_torque", inertia_uncertainty=_inertia(rate_torque=True))
