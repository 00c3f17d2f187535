"""Simulators of real wheels with faults, about one axis or on a free body, and a loop that runs them."""

import numpy as np

from ftac_gym import attitude as att
from ftac_gym.dynamics import Simulator
from ftac_gym.faults import FaultSchedule
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


def start(
    *faults,
    momentum=0.0,
    rate=(0.0, 0.0, 0.0),
    step=0.02,
    period=PERIOD,
    axes=PYRAMID,
    duration=300.0,
    inertia=INERTIA,
    **parts,
):
    """Return a simulator of one spacecraft with these faults at the start of its episode."""
    parts = {"torque_limit": LIMIT} | parts
    scenario = Scenario(
        name="wheels",
        spacecraft=Spacecraft(inertia, WheelArray(axes, **parts)),
        initial_state=InitialState.fixed(rate=rate, wheel_momentum=momentum),
        faults=FaultSchedule(faults) if faults else None,
        control_period=period,
        physics_step=step,
        duration=duration,
    )
    simulator = Simulator(scenario, 1)
    simulator.reset(scenario.draw(0, 1))
    return simulator


def one_axis(count, *faults, period=PERIOD, **parts):
    """Return a simulator of one heavy spacecraft with so many wheels about one axis."""
    axes = np.zeros((3, count))
    axes[2] = 1.0
    inertia = np.diag([1e4, 1.2e4, 1.4e4])  # A test bench: the body hardly turns.
    return start(*faults, period=period, axes=axes, duration=100.0 * period, inertia=inertia, **parts)


def body_momentum(state):
    """Momentum of the body alone in inertial axes (3,)."""
    return att.rotate_to_reference(state.attitude, state.rate @ INERTIA)[0]


def total_momentum(state, axes=PYRAMID):
    """Momentum of body and wheels in inertial axes (3,)."""
    return att.rotate_to_reference(state.attitude, state.rate @ INERTIA + state.wheel_momentum @ axes.T)[0]


def run(simulator, commands):
    """Return torque on the body and momentum (T, m) after each control period."""
    torque, momentum = [], []
    for command in commands:
        simulator.step(np.broadcast_to(command, simulator.last_command.shape))
        torque.append(simulator.state.wheel_torque[0].copy())
        momentum.append(simulator.state.wheel_momentum[0].copy())
    return np.array(torque), np.array(momentum)
