"""The numerical example of Zhang and Zhou 2019 (IET Control Theory & Applications 13(15), sec. 5), and three variants.

Four strong wheels, two faults at 10 s, a large external torque and a fast start. As printed, no controller can follow
the reference: see :func:`zhang_zhou_2019`. Chosen here, because the paper leaves it open: no momentum limit, wheels
without gyroscopic coupling (the paper's equations have none), perfect sensors, the control period, the integrator's
step, the length of the episode, and when the task counts as done. All other numbers are the authors' unless a variant
says otherwise.

The torques below are those that following a reference exactly asks of the most loaded wheel, with the nominal inertia
and the allocation that keeps that as small as can be (:func:`peak_wheel_torque`).
"""

from __future__ import annotations

import numpy as np

from ftac_gym.attitude import quaternion_from_mrp
from ftac_gym.faults import Bias, FaultSchedule, LossOfEffectiveness
from ftac_gym.spacecraft.layouts import orthogonal_and_skew
from ftac_gym.spacecraft.spacecraft import Spacecraft
from ftac_gym.spacecraft.wheel_array import WheelArray
from ftac_gym.task.disturbances import Disturbance, Harmonic
from ftac_gym.task.inertia import InertiaUncertainty
from ftac_gym.task.initial_state import InitialState
from ftac_gym.task.references import MRPSinusoid, fixed_attitude
from ftac_gym.task.scenario import Scenario

SLOWING = 0.2
"""How much slower than printed the feasible reference is [chosen]."""


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
    external torque, and commands of up to 47.7 N m once the first wheel gives half of what it is told; with the
    pseudo-inverse 35.4, 35.5 and 50.8 N m.
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

    It needs 1.30 N m, 1.31 with the external torque, and commands of up to 1.92 N m after the faults: within the limit
    of 5 N m, and just within 2 N m too. With the pseudo-inverse it needs 1.42, 1.43 and 2.03 N m.
    """
    return zhang_zhou_2019().replace(name="zhang_zhou_2019_feasible", reference=_reference(SLOWING))


def zhang_zhou_2019_stabilisation() -> Scenario:
    """Return the scenario with the reference at rest: the paper's other controller, for which it prints no example."""
    return zhang_zhou_2019().replace(name="zhang_zhou_2019_stabilisation", reference=fixed_attitude())
