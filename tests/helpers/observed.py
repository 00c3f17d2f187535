"""Spacecraft under known commands, with an observer that watches them."""

import numpy as np

from ftac_gym.baselines import observers
from ftac_gym.baselines.memory import Memory
from ftac_gym.dynamics import Simulator
from ftac_gym.faults import FaultSchedule, LossOfEffectiveness
from ftac_gym.spacecraft.layouts import orthogonal_and_skew, three_orthogonal
from ftac_gym.spacecraft.spacecraft import Spacecraft
from ftac_gym.spacecraft.wheel_array import WheelArray
from ftac_gym.task.initial_state import InitialState
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.scenario import Scenario

FREQUENCIES = np.array([0.5, 0.8, 1.1, 1.5])  # rad/s


def task(wheels, period, faults="random", **changes):
    """The spacecraft of Zhang and Zhou 2019, four wheels, or of Cao, Gong and Han 2022, three; 5 N m."""
    axes = three_orthogonal() if wheels == 3 else orthogonal_and_skew()
    inertia = ((30.0, 5.3, 6.4), (5.3, 27.0, 10.0), (6.4, 10.0, 19.0))
    if wheels == 3:
        inertia = ((36.0, 0.0, 0.0), (0.0, 17.0, 0.0), (0.0, 0.0, 26.0))
    weak = tuple(LossOfEffectiveness(wheel=wheel, effectiveness=(0.3, 1.0)) for wheel in range(wheels))
    parts = {
        "name": "observed",
        "spacecraft": Spacecraft(
            inertia, WheelArray(axes, 5.0, momentum_coupling=False), allow_unphysical_inertia=True
        ),
        "initial_state": InitialState.fixed(),
        "faults": FaultSchedule(weak) if faults == "random" else faults,
        "control_period": period,
        "physics_step": period,
        "duration": 1000.0 * period,
    }  # fmt: skip
    return Scenario(**{**parts, **changes})


def sustained(time, wheels, amplitude=2.0):
    """Slow torques of different frequencies, (wheels,) [N m]."""
    return amplitude * np.cos(FREQUENCIES[:wheels] * time)


def watch(name, scenario, count, steps, command, **gains):
    """Yield the simulator, the observer's memory and its estimate after each sample under ``command(time)``."""
    simulator, memory = Simulator(scenario, count), Memory(count)
    observer = observers.make(name, scenario, memory, **gains)
    simulator.reset(scenario.draw(1, count))
    shape = simulator.last_command.shape
    for step in range(steps):
        measurement = simulator.measurement()
        yield simulator, memory, observer.update(measurement, measurement.last_command, scenario.control_period)
        simulator.step(np.broadcast_to(command(step * scenario.control_period), shape))


def seen(rate, command):
    """Return the measurement of spacecraft with the given rates (N, 3) and last commands (N, m)."""
    count = len(rate)
    identity, three = np.tile([1.0, 0.0, 0.0, 0.0], (count, 1)), np.zeros((count, 3))
    return Measurement(
        np.zeros(count), identity, rate, np.zeros_like(command), command, np.ones(count, bool), identity, three, three
    )


def random_walk(scenario, count, steps, size=1.0):
    """Return measurements that no spacecraft would make: rates and commands at random."""
    random, wheels = np.random.default_rng(5), scenario.spacecraft.wheels.count
    return [
        seen(size * random.normal(size=(count, 3)), random.uniform(-5.0, 5.0, (count, wheels))) for _ in range(steps)
    ]
