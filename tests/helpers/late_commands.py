"""A task for commands that take effect late, its simulators, and random commands."""

import numpy as np

from ftac_gym.dynamics import Simulator
from ftac_gym.faults import FaultSchedule
from ftac_gym.spacecraft import Spacecraft, WheelArray
from ftac_gym.task import InitialState, Scenario

PERIOD, STEP = 0.1, 0.02  # s
INERTIA = [[10.0, 1.2, 0.5], [1.2, 19.0, 1.5], [0.5, 1.5, 25.0]]  # kg m^2


def task(*faults, **changes):
    """Return a scenario without loop delay, in which spacecraft have only these faults."""
    fields = {
        "name": "late",
        "spacecraft": Spacecraft(INERTIA, WheelArray.sign_pyramid(0.2, 12.0)),
        "initial_state": InitialState(max_rate=0.02, wheel_momentum=(-1.0, 1.0)),
        "faults": FaultSchedule(faults) if faults else None,
        "control_period": PERIOD,
        "physics_step": STEP,
        "duration": 20.0,
    }
    return Scenario(**{**fields, **changes})


def start(scenario, count=1, seed=0):
    """Return a simulator at the start of episodes of a seed."""
    simulator = Simulator(scenario, count)
    simulator.reset(scenario.draw(seed, count))
    return simulator


def commands(periods, count=1, seed=0):
    """Random commands (periods, count, 4) [N m]."""
    return np.random.default_rng(seed).uniform(-0.2, 0.2, (periods, count, 4))
