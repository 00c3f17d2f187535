"""What the faults of a flight did, and what an observer made of them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ftac_gym import baselines
from ftac_gym.baselines import Baseline, FaultEstimate, observers
from ftac_gym.baselines.fault_source import FaultSource
from ftac_gym.baselines.memory import Memory
from ftac_gym.dynamics import Simulator
from ftac_gym.evaluation.metrics import Rollout
from ftac_gym.faults import FaultEffect, fault_effect
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, require

_PARTS = ("effectiveness", "bias", "identifiable", "disturbance", "vibration")


@dataclass(frozen=True, eq=False)
class EstimateHistory:
    """What an observer believed along a flight of N craft with m wheels; None for what it does not estimate.

    Attributes
    ----------
    history
        The flight.
    effectiveness
        (T + 1, N, m) of each wheel, believed at each measurement.
    bias
        (T + 1, N, m) [N m].
    identifiable
        (T + 1, N, m) whether each wheel had been given enough torque to tell its effectiveness.
    disturbance
        (T + 1, N, 3) torque on the body that neither the commands nor the other estimates explain, in body axes [N m].
    vibration
        (T + 1, N, 3) torque of the vibration modes on the body, in body axes [N m].
    """

    history: Rollout
    effectiveness: FloatArray | None
    bias: FloatArray | None
    identifiable: npt.NDArray[np.bool_] | None
    disturbance: FloatArray | None
    vibration: FloatArray | None

    @property
    def unexplained(self) -> FloatArray:
        """All torque on the body that the commands do not explain but the modes, as believed, (T + 1, N, 3) [N m].

        Zero where an observer says nothing of it.
        """
        command = np.concatenate([np.zeros_like(self.history.command[:1]), self.history.command])
        wheels = np.zeros_like(command)
        if self.effectiveness is not None:
            wheels += (self.effectiveness - 1.0) * command
        if self.bias is not None:
            wheels += self.bias
        torque: FloatArray = wheels @ self.history.scenario.spacecraft.wheels.axis_matrix.T
        return torque if self.disturbance is None else torque + self.disturbance


class _Watch:
    """An observer that is not part of a law."""

    def __init__(self, name: str, scenario: Scenario, count: int, gains: dict[str, Any]) -> None:
        self._source = FaultSource(scenario, Memory(count), name, gains)
        self.information = self._source.information

    def act(self, measurement: Measurement) -> None:
        self._source.update(measurement)

    @property
    def estimate(self) -> FaultEstimate | None:
        return self._source.estimate


def _observer(scenario: Scenario, count: int, source: Any, gains: str, changes: dict[str, Any]) -> Baseline | _Watch:
    named = isinstance(source, str) and baselines.is_baseline(source)
    if named or (isinstance(source, type) and issubclass(source, Baseline)):
        return baselines.make(source, scenario, count, gains, **changes)
    require(gains == "default", "gains", "must be 'default' unless source is a baseline of this package", gains)
    known = f"must be a Baseline class, a baseline ({', '.join(baselines.names())}) "
    known += f"or an observer ({', '.join(observers.names())})"
    require(isinstance(source, str) and source in observers.names(), "source", known, source)
    return _Watch(source, scenario, count, changes)


def estimates_along(history: Rollout, source: Any, gains: str = "default", **changes: Any) -> EstimateHistory:
    """Return what an observer believes along a flight that was recorded.

    The flight is repeated from its commands and the observer watches it, so that any observer may be asked about any
    flight. The observer of the law that flew believes what it believed in flight.

    Parameters
    ----------
    history
        The flight.
    source
        Name or class of a baseline with an observer inside, or name of an observer
        (:func:`ftac_gym.baselines.observers.names`).
    gains
        ``"default"`` or ``"tuned"``, as for :func:`ftac_gym.baselines.make`; only the default for an observer or a
        class of your own.
    **changes
        Gains that differ from these.

    Raises
    ------
    ValueError
        If the source or a gain is unknown, it does not fit the flight's scenario, or it estimates nothing.
    """
    scenario, craft = history.scenario, history.command.shape[1]
    observer = _observer(scenario, craft, source, gains, changes)
    kept: dict[str, list[Any]] = {name: [] for name in _PARTS}
    for simulator in flown_again(history):
        observer.act(simulator.measurement(truth=observer.information == "oracle"))
        estimate = observer.estimate
        require(estimate is not None, "source", "must have an observer of faults", source)
        for name, rows in kept.items():
            rows.append(getattr(estimate, name))
    # The parts that an observer has are the same at every measurement.
    parts = {name: None if rows[0] is None else np.array(rows) for name, rows in kept.items()}
    return EstimateHistory(history, **parts)


def flown_again(history: Rollout) -> Iterator[Simulator]:
    """Repeat a flight from its commands; yield its simulator at each of the T + 1 times.

    A rollout records the truth: this is for what it leaves out, such as measurements.
    """
    simulator = Simulator(history.scenario, history.command.shape[1])
    simulator.reset(history.episodes)
    yield simulator
    for command in history.command:
        simulator.step(command)
        yield simulator


def true_effect(history: Rollout, craft: int = 0) -> FaultEffect:
    """Return what the faults of one craft of a rollout did at each of its T + 1 times."""
    wheels = history.scenario.spacecraft.wheels
    # A locked wheel repeats the torque that it applied last.
    torques = np.vstack([np.zeros((1, wheels.count)), history.applied_torque[:, craft]])
    drawn = history.episodes.drawn_faults.take(np.full(len(history.time), craft))
    return fault_effect(drawn, history.time, wheels, history.wheel_momentum[:, craft], torques)


def unexplained_torque(history: Rollout, craft: int = 0) -> FloatArray:
    """Return the torque on the body, along the nominal wheel axes, that one craft's commands do not explain.

    Returns
    -------
    Array (T + 1, 3) [N m], body axes: at each time that of the control period before it. The external disturbance and
    the vibration are no part of it.
    """
    missing = (history.applied_torque - history.command)[:, craft] @ history.scenario.spacecraft.wheels.axis_matrix.T
    return np.vstack([np.zeros((1, 3)), missing])
