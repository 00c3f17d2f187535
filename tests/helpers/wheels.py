"""Wheels about one axis of a spacecraft whose body is of no interest, and a loop that runs them."""

import numpy as np

from ftac_gym.dynamics import Simulator
from ftac_gym.faults import FaultSchedule
from ftac_gym.spacecraft.spacecraft import Spacecraft
from ftac_gym.spacecraft.wheel_array import WheelArray
from ftac_gym.task.initial_state import InitialState
from ftac_gym.task.scenario import Scenario

LIMIT, SPIN = 0.2, 0.02  # N m, kg m^2


def one_axis(count, *faults, momentum=0.0, step=0.02, period=0.1, torque_limit=LIMIT, **parts):
    """Return a simulator of one spacecraft with so many wheels about one axis."""
    axes = np.zeros((3, count))
    axes[2] = 1.0
    scenario = Scenario(
        name="wheels",
        spacecraft=Spacecraft(np.diag([10.0, 12.0, 14.0]), WheelArray(axes, torque_limit, **parts)),
        initial_state=InitialState.fixed(wheel_momentum=momentum),
        faults=FaultSchedule(faults) if faults else None,
        control_period=period,
        physics_step=step,
        duration=100.0 * period,
    )
    simulator = Simulator(scenario, 1)
    simulator.reset(scenario.draw(0, 1))
    return simulator


def run(simulator, commands):
    """Return torque on the body and momentum (T, m) after each control period."""
    torque, momentum = [], []
    for command in commands:
        simulator.step(np.broadcast_to(command, simulator.last_command.shape))
        torque.append(simulator.state.wheel_torque[0].copy())
        momentum.append(simulator.state.wheel_momentum[0].copy())
    return np.array(torque), np.array(momentum)
