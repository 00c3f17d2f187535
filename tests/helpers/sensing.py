"""Flights with the sensors of a suite."""

import numpy as np

from ftac_gym import attitude as att
from ftac_gym import scenarios
from ftac_gym.dynamics import Simulator
from ftac_gym.faults import FaultSchedule
from ftac_gym.spacecraft import Spacecraft, WheelArray
from ftac_gym.task import InitialState, Scenario

PERIOD = 0.1  # s
DEGREE = np.pi / 180.0
ARCSECOND = DEGREE / 3600.0


def task(sensors, *faults, **changes):
    """Return a scenario of a ball with three wheels, which spins steadily without commands."""
    fields = {
        "name": "suite",
        "spacecraft": Spacecraft(10.0 * np.eye(3), WheelArray(np.eye(3), 0.2, 5.0, momentum_coupling=False)),
        "initial_state": InitialState(max_rate=0.1, wheel_momentum=(-1.0, 1.0)),
        "faults": FaultSchedule(faults) if faults else None,
        "sensors": sensors,
        "control_period": PERIOD,
        "physics_step": PERIOD,
    }
    return Scenario(**{**fields, **changes})


def at_rest(sensors, *faults, **changes):
    """Return the scenario of a body that never moves."""
    return task(sensors, *faults, initial_state=InitialState.fixed(), **changes)


def flown(name, sensors, faults=()):
    """Return a scenario of the library with sensors and faults."""
    return scenarios.get(name).replace(sensors=sensors, faults=FaultSchedule(faults))


class Flight:
    """True and measured quantities (T + 1, N, ...) of an open-loop flight; one at rest gets no commands."""

    def __init__(self, scenario, steps=40, command=None, count=20):
        self.episodes = scenario.draw(0, count)
        simulator = Simulator(scenario, count)
        simulator.reset(self.episodes)
        moving = bool(np.any(self.episodes.initial["rate"]))
        command = (0.1 if moving else 0.0) if command is None else command
        random, rows = np.random.default_rng(0), []
        for step in range(steps + 1):
            if step:
                simulator.step(random.uniform(-command, command, (count, 3)))
            seen, state = simulator.measurement(), simulator.state
            true = state.attitude.copy(), state.rate.copy(), state.wheel_momentum.copy()
            measured = seen.attitude, seen.rate, seen.wheel_momentum, seen.star_tracker_valid, seen.attitude_age
            rows.append((*true, *measured))
        columns = [np.array(column) for column in zip(*rows, strict=True)]
        self.true_attitude, self.true_rate, self.true_momentum, self.attitude, self.rate, *columns = columns
        self.momentum, self.valid, self.age = columns
        self.time = np.arange(steps + 1) * scenario.control_period
        self.rate_error = self.rate - self.true_rate
        self.turn = att.rotation_vector_from_quaternion(att.quaternion_error(self.attitude, self.true_attitude))
