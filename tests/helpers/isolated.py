"""Flights with faulty wheels under known commands, watched by the multiple-model estimator."""

import numpy as np

from ftac_gym import baselines, scenarios
from ftac_gym.baselines import observers
from ftac_gym.baselines.memory import Memory
from ftac_gym.dynamics import Simulator
from ftac_gym.faults import FaultSchedule

FLAGSHIP = scenarios.get("flagship").replace(faults=None)
FREQUENCIES = np.array([[0.7, 1.9], [0.9, 2.3], [1.1, 1.7], [1.3, 2.7]])  # rad/s


def exciting(time, count, amplitude=0.08):
    """Return torques (count, 4) [N m] of several frequencies, of which no two wheels have the same."""
    return np.tile(amplitude * np.sin(FREQUENCIES * time + [0.4, 1.7]).sum(axis=1), (count, 1))


class Watched:
    """Parts of the estimate along a flight of T control periods, (T, N, m) each.

    ``law`` flies a baseline in closed loop instead of the exciting commands.
    """

    def __init__(self, *faults, task=FLAGSHIP, count=20, duration=40.0, seed=5, name="multiple_model", **options):
        law, amplitude = options.pop("law", None), options.pop("amplitude", 0.08)
        scenario = task.replace(faults=FaultSchedule(faults)) if faults else task
        self.simulator, self.memory = Simulator(scenario, count), Memory(count)
        self.simulator.reset(scenario.draw(seed, count))
        observer = observers.make(name, scenario, self.memory, **options)
        baseline = baselines.make(law, scenario, count, gains="tuned") if law else None
        rows = {key: [] for key in ("condition", "delay", "effectiveness", "bias", "alarm", "identifiable")}
        for step in range(round(duration / scenario.control_period)):
            measurement = self.simulator.measurement()
            estimate = observer.update(measurement, measurement.last_command, scenario.control_period)
            for key, values in rows.items():
                values.append(np.array(getattr(estimate, key)))
            time = step * scenario.control_period
            command = baseline.act(measurement) if baseline else exciting(time, count, amplitude)
            self.simulator.step(command)
        for key, values in rows.items():
            setattr(self, key, np.array(values))
