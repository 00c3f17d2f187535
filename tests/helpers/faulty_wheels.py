"""Real wheels with faults on a free body."""

import numpy as np

from ftac_gym import attitude as att
from ftac_gym.dynamics import Simulator
from ftac_gym.faults import (
    FaultSchedule,
)
from ftac_gym.spacecraft.friction import Friction
from ftac_gym.spacecraft.spacecraft import Spacecraft
from ftac_gym.spacecraft.wheel_array import WheelArray
from ftac_gym.task.initial_state import InitialState
from ftac_gym.task.scenario import Scenario

INERTIA = np.array([[10.0, 1.2, 0.5], [1.2, 19.0, 1.5], [0.5, 1.5, 25.0]])  # kg m^2
PYRAMID = WheelArray.sign_pyramid(0.2, None).axis_matrix
LIMIT, SPIN, PERIOD = 0.2, 0.02, 0.1  # N m, kg m^2, s
FRICTION = Friction(coulomb=2e-3, breakaway=4e-3, breakaway_speed=0.3, viscous=1e-4)
REAL = {"spin_inertia": SPIN, "friction": FRICTION, "lag": 0.05}


def start(*faults, momentum=0.0, rate=(0.0, 0.0, 0.0), step=0.02, period=PERIOD, axes=PYRAMID, duration=300.0, **parts):
    parts = {"torque_limit": LIMIT} | parts
    scenario = Scenario(
        name="wheels",
        spacecraft=Spacecraft(INERTIA, WheelArray(axes, **parts)),
        initial_state=InitialState.fixed(rate=rate, wheel_momentum=momentum),
        faults=FaultSchedule(faults) if faults else None,
        control_period=period,
        physics_step=step,
        duration=duration,
    )
    simulator = Simulator(scenario, 1)
    simulator.reset(scenario.draw(0, 1))
    return simulator


def body_momentum(state):
    """Momentum of the body alone in inertial axes (3,)."""
    return att.rotate_to_reference(state.attitude, state.rate @ INERTIA)[0]


def total_momentum(state, axes=PYRAMID):
    return att.rotate_to_reference(state.attitude, state.rate @ INERTIA + state.wheel_momentum @ axes.T)[0]
