"""The numerical example of Zhang and Zhou 2019 (IET Control Theory & Applications 13(15), sec. 5), and three variants.

Four strong wheels, two faults at 10 s, a large external torque and a fast start. As printed, no controller can follow
the reference: see :func:`~ftac_gym.scenarios.zhang_zhou_2019.zhang_zhou_2019`.

The paper leaves these open, and they are chosen here:

- no momentum limit, perfect sensors, wheels without gyroscopic coupling (the paper's equations have none);
- the control period, the integrator's step, the length of the episode and the success criterion.

All other numbers are the authors' unless a variant says otherwise.

The torques below are those of the most loaded wheel when a reference is followed exactly. They hold for the nominal
inertia and the allocation that keeps this torque as small as possible
(:func:`~ftac_gym.reproduction.inverse_dynamics.peak_wheel_torque`).
"""

import numpy as np

from ftac_gym.attitude import quaternion_from_mrp
from ftac_gym.faults import Bias, FaultSchedule, LossOfEffectiveness
from ftac_gym.spacecraft import Spacecraft, WheelArray, orthogonal_and_skew
from ftac_gym.task import Disturbance, Harmonic, InertiaUncertainty, InitialState, MRPSinusoid, Scenario, fixed_attitude

SLOWING = 0.2
"""Ratio of the feasible reference's frequencies to the printed ones [chosen]."""


def _spacecraft(torque_limit: float) -> Spacecraft:
    """Return the printed spacecraft, whose inertia no rigid body has.

    Its principal moments are 11.9, 24.0 and 40.2 kg m^2, and the largest exceeds the sum of the others by 4.3.
    """
    inertia = ((30.0, 5.3, 6.4), (5.3, 27.0, 10.0), (6.4, 10.0, 19.0))  # kg m^2
    wheels = WheelArray(orthogonal_and_skew(), torque_limit, momentum_coupling=False)
    return Spacecraft(inertia, wheels, allow_unphysical_inertia=True)


def _reference(slowing: float) -> MRPSinusoid:
    """Return the printed reference with its frequencies [rad/s] times a factor."""
    return MRPSinusoid(amplitude=(0.3, 0.1, 0.2), frequency=(slowing, 2.0 * slowing, slowing))


def zhang_zhou_2019() -> Scenario:
    """Return the scenario as printed, with the torque limit of the paper's set-up, 5 N m.

    The reference is out of reach for any controller. It turns at up to 1.65 rad/s and needs 32.5 N m, 32.6 with the
    external torque. Once the first wheel gives half of its command, it needs commands of up to 47.7 N m. With the
    pseudo-inverse the three numbers are 35.4, 35.5 and 50.8 N m.
    """
    attitude = quaternion_from_mrp(np.array([-0.8, 0.3, 0.5]))
    return Scenario(
        name="zhang_zhou_2019",
        spacecraft=_spacecraft(torque_limit=5.0),
        initial_state=InitialState.fixed(attitude=attitude.tolist(), rate=(0.5, -0.6, 0.4)),
        reference=_reference(1.0),
        faults=FaultSchedule(
            (LossOfEffectiveness(wheel=0, onset=10.0, effectiveness=0.5), Bias(wheel=1, onset=10.0, constant=0.06))
        ),
        disturbance=Disturbance((0.1,) * 3, (Harmonic((0.1, 0.3, 0.5), frequency=1.0),)),
        # As printed, the inertia varies without the torque -J' w that this would make.
        inertia_uncertainty=InertiaUncertainty(amplitude=(1.0, 2.0, 1.0), frequency=(0.1, 0.2, 0.3), rate_torque=False),
        control_period=0.01,
        physics_step=0.01,
        duration=60.0,
    )


def zhang_zhou_2019_2nm() -> Scenario:
    """Return the scenario as printed, with the torque limit that the paper's results mention, 2 N m."""
    return zhang_zhou_2019().replace(name="zhang_zhou_2019_2nm", spacecraft=_spacecraft(torque_limit=2.0))


def zhang_zhou_2019_feasible() -> Scenario:
    """Return the scenario with the printed reference five times slower [chosen], at up to 0.33 rad/s.

    It needs 1.30 N m, 1.31 with the external torque, and commands of up to 1.92 N m after the faults. This is within
    the limit of 5 N m, and just within 2 N m too. With the pseudo-inverse it needs 1.42, 1.43 and 2.03 N m.
    """
    return zhang_zhou_2019().replace(name="zhang_zhou_2019_feasible", reference=_reference(SLOWING))


def zhang_zhou_2019_stabilisation() -> Scenario:
    """Return the scenario with the reference at rest, for the paper's other controller, which has no example there."""
    return zhang_zhou_2019().replace(name="zhang_zhou_2019_stabilisation", reference=fixed_attitude())
