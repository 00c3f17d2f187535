"""A baseline's flight with everything that a paper's figures show: errors, torques, estimates, truth."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ftac_gym import baselines
from ftac_gym.attitude import angle_between, mrp_from_quaternion
from ftac_gym.baselines import Baseline
from ftac_gym.dynamics import Simulator
from ftac_gym.faults import fault_effect
from ftac_gym.task.prescribed_bound import PrescribedBound
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray


@dataclass(frozen=True)
class Plan:
    """What to fly.

    Attributes
    ----------
    scenario
        The task.
    law
        Name of a baseline.
    gains
        Gains that differ from its own.
    seed, craft
        Which episodes: the first ``craft`` ones of a seed.
    flipped
        Whether the quaternions at the start have the other sign, which is the same attitude: a law that tells the two
        apart goes another way.
    kept
        Names in the law's memory whose histories are recorded.
    """

    scenario: Scenario
    law: str
    gains: Mapping[str, Any] = field(default_factory=dict)
    seed: int = 0
    craft: int = 1
    flipped: bool = False
    kept: tuple[str, ...] = ()


def from_when(time: FloatArray, values: FloatArray, limit: float) -> float:
    """Return from when on values (T,) at times (T,) [s] stay below a limit [s]; infinity if they do not."""
    above = np.flatnonzero(~(values < limit))
    if len(above) == 0:
        return 0.0
    return float(time[above[-1] + 1]) if above[-1] + 1 < len(time) else float("inf")


@dataclass(frozen=True, eq=False)
class Flight:
    """Time histories of N craft over T control periods.

    Attributes
    ----------
    scenario
        What was flown.
    time
        (T + 1,) [s].
    error
        (T + 1, N) angle between body and reference [deg].
    attitude, reference
        (T + 1, N, 3) short-branch MRPs.
    rate
        (T + 1, N, 3) body rate [rad/s].
    command
        (T, N, m) wheel torques commanded [N m].
    effectiveness, bias
        (T, N, m) the observer's estimates; None if it has none.
    disturbance
        (T, N, 3) the observer's unexplained torque [N m]; None if it has none.
    rate_mismatch
        (T, N, 3) measured minus observed rate [rad/s]; None without an observer.
    identifiable
        (T, N, m) which wheels had sustained torque; None without an observer.
    true_effectiveness, true_bias
        (T, N, m) the truth.
    vibration
        (T, N, 3) the observer's torque of the vibration modes [N m]; None if it has none.
    true_vibration
        (T + 1, N, 3) the truth; zero for a rigid craft.
    modal_energy
        (T + 1, N) energy of the vibration modes [J]; zero for a rigid craft.
    memory
        (T + 1, N, ...) what the plan asked to keep of the law's memory, by name.
    """

    scenario: Scenario
    time: FloatArray
    error: FloatArray
    attitude: FloatArray
    reference: FloatArray
    rate: FloatArray
    command: FloatArray
    true_effectiveness: FloatArray
    true_bias: FloatArray
    true_vibration: FloatArray
    modal_energy: FloatArray
    effectiveness: FloatArray | None = None
    bias: FloatArray | None = None
    disturbance: FloatArray | None = None
    vibration: FloatArray | None = None
    rate_mismatch: FloatArray | None = None
    identifiable: FloatArray | None = None
    memory: Mapping[str, FloatArray] = field(default_factory=dict)

    def settling(self, angle: float, craft: int = 0) -> float:
        """Return when the error of a craft falls below an angle [deg] for good [s]; infinity if it never does."""
        return from_when(self.time, self.error[:, craft], angle)

    def steady(self, window: float = 10.0) -> float:
        """Return the largest error in the last ``window`` seconds [deg], of all craft."""
        return float(self.error[self.time >= self.time[-1] - window].max())

    def spent(self, commanded: bool = False) -> FloatArray:
        """Return the integral of the squared torques of the first craft's wheels, (T + 1,) [N^2 m^2 s].

        They are those that the wheels apply, faults included, or those that the law commands.
        """
        torque = self.command[:, 0]
        if not commanded:
            torque = self.true_effectiveness[:, 0] * torque + self.true_bias[:, 0]
        spent = np.cumsum((torque**2).sum(axis=1)) * self.scenario.control_period
        return np.concatenate(([0.0], spent))

    def energy(self, until: float = np.inf, commanded: bool = False) -> float:
        """Return the same up to a time [s]."""
        return float(self.spent(commanded)[self.time <= until + 1e-9][-1])

    def speed(self) -> FloatArray:
        """Return the magnitude of the first craft's rate, (T + 1,) [deg/s]."""
        speed: FloatArray = np.degrees(np.linalg.norm(self.rate[:, 0], axis=1))
        return speed

    def path_ratio(self) -> FloatArray:
        """Return the angle turned over the shortest one, (N,), for a reference at rest."""
        speed = np.linalg.norm(self.rate[1:], axis=2)
        ratio: FloatArray = np.degrees(speed.sum(axis=0) * self.scenario.control_period) / self.error[0]
        return ratio

    def margin(self, bound: PrescribedBound, craft: int = 0) -> FloatArray:
        """Return how far inside a bound a craft is, (T + 1,): the least share of its width; negative outside.

        For a reference at the identity.
        """
        least: FloatArray = bound.margin(self.attitude[:, craft], self.time).min(axis=1)
        return least

    def component_accuracy(self, window: float = 10.0) -> FloatArray:
        """Return the largest |sigma_i - sigma_d,i| of the last ``window`` seconds, (3,), as the angle 4 atan [deg]."""
        late = self.time >= self.time[-1] - window
        difference = np.abs(self.attitude[late] - self.reference[late]).max(axis=(0, 1))
        accuracy: FloatArray = np.degrees(4.0 * np.arctan(difference))
        return accuracy

    def chatter(self) -> float:
        """Return the total variation of the commands of the first craft per second [N m/s], mean over the wheels."""
        variation = np.abs(np.diff(self.command[:, 0], axis=0)).sum(axis=0).mean()
        return float(variation / self.time[-1])

    def saturated(self) -> float:
        """Return the share of time that the wheels of the first craft are commanded their limit."""
        limits = self.scenario.spacecraft.wheels.torque_limits
        return float((np.abs(self.command[:, 0]) >= limits * (1.0 - 1e-9)).mean())

    def estimate_error(self, window: float = 10.0) -> FloatArray:
        """Return the largest |e^ - e| of each wheel of the first craft in the last ``window`` seconds, (m,)."""
        if self.effectiveness is None:
            raise ValueError("effectiveness must have been estimated to have an error, got None")
        late = self.time[:-1] >= self.time[-1] - window
        worst: FloatArray = np.abs(self.effectiveness - self.true_effectiveness)[late, 0].max(axis=0)
        return worst


def fly(plan: Plan) -> Flight:
    """Fly a plan and record everything."""
    scenario, steps, craft = plan.scenario, plan.scenario.horizon, plan.craft
    simulator = Simulator(scenario, craft)
    law: Baseline = baselines.make(plan.law, scenario, craft, **plan.gains)
    episodes = scenario.draw(plan.seed, craft)
    if plan.flipped:
        start = episodes.initial.copy()
        start["attitude"] *= -1.0
        episodes = replace(episodes, initial=start)
    simulator.reset(episodes)
    wheels = scenario.spacecraft.wheels.count
    error, rate = np.empty((steps + 1, craft)), np.empty((steps + 1, craft, 3))
    attitude, reference = np.empty((steps + 1, craft, 4)), np.empty((steps + 1, craft, 4))
    command = np.empty((steps, craft, wheels))
    pull, energy = np.empty((steps + 1, craft, 3)), np.empty((steps + 1, craft))
    estimates: dict[str, list[Any]] = {name: [] for name in _ESTIMATES}
    memory: dict[str, list[FloatArray]] = {name: [] for name in plan.kept}
    for step in range(steps + 1):
        state = simulator.state
        attitude[step], rate[step], reference[step] = state.attitude, state.rate, simulator.reference_attitude
        pull[step], energy[step] = simulator.vibration_torque, simulator.modal_energy
        error[step] = np.degrees(angle_between(state.attitude, simulator.reference_attitude))
        for name, history in memory.items():
            history.append(law.memory[name])
        if step == steps:
            break
        measurement = simulator.measurement(truth=law.information == "oracle")
        command[step] = law.act(measurement)
        estimate = law.estimate
        if estimate is not None:
            for name in _ESTIMATES[:-1]:
                estimates[name].append(getattr(estimate, name))
            if law.memory.has("rate_mismatch"):
                estimates["rate_mismatch"].append(law.memory["rate_mismatch"])
        simulator.step(command[step])
    true_effectiveness, true_bias = _truth(scenario, plan, steps)
    kept = {name: np.array(rows) for name, rows in estimates.items() if rows and rows[0] is not None}
    return Flight(
        scenario=scenario,
        time=np.arange(steps + 1, dtype=np.float64) * scenario.control_period,
        error=error,
        attitude=mrp_from_quaternion(attitude),
        reference=mrp_from_quaternion(reference),
        rate=rate,
        command=command,
        true_effectiveness=true_effectiveness,
        true_bias=true_bias,
        true_vibration=pull,
        modal_energy=energy,
        memory={name: np.array(history) for name, history in memory.items()},
        **kept,
    )


def _truth(scenario: Scenario, plan: Plan, steps: int) -> tuple[FloatArray, FloatArray]:
    """Return effectiveness and bias (T, N, m) at the start of every period; no stuck or rubbing wheels."""
    drawn = scenario.draw(plan.seed, plan.craft).drawn_faults
    time = np.arange(steps, dtype=np.float64) * scenario.control_period
    nothing = np.zeros((steps, scenario.spacecraft.wheels.count))
    effects = [
        fault_effect(drawn.take(np.full(steps, craft)), time, scenario.spacecraft.wheels, nothing, nothing)
        for craft in range(plan.craft)
    ]
    effectiveness = np.stack([effect.effectiveness for effect in effects], axis=1)
    return effectiveness, np.stack([effect.bias for effect in effects], axis=1)


_ESTIMATES = ("effectiveness", "bias", "disturbance", "vibration", "identifiable", "rate_mismatch")
