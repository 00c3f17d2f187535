"""Estimates of observers along a rollout."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ftac_gym import baselines
from ftac_gym.baselines import Baseline, observers
from ftac_gym.baselines.fault_source import FaultSource
from ftac_gym.baselines.memory import Memory
from ftac_gym.baselines.registry import known_names
from ftac_gym.dynamics import Simulator
from ftac_gym.evaluation.metrics import Rollout
from ftac_gym.evaluation.truth import command_in_effect
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, broken, require

_PARTS = ("effectiveness", "bias", "identifiable", "disturbance", "vibration")


@dataclass(frozen=True, eq=False)
class EstimateHistory:
    """Estimates of an observer along a rollout of N spacecraft with m wheels; None for parts that it does not have.

    Attributes
    ----------
    history
        The rollout.
    effectiveness
        (T + 1, N, m) estimate for each wheel at each measurement.
    bias
        (T + 1, N, m) [N m].
    identifiable
        (T + 1, N, m) True for wheels with enough torque so far to identify their effectiveness.
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
        """Estimated torque on the body that commands and modes do not explain, (T + 1, N, 3) [N m].

        Zero for observers without such an estimate.
        """
        command = command_in_effect(self.history)
        wheels = np.zeros_like(command)
        if self.effectiveness is not None:
            wheels += (self.effectiveness - 1.0) * command
        if self.bias is not None:
            wheels += self.bias
        torque: FloatArray = wheels @ self.history.scenario.spacecraft.wheels.axis_matrix.T
        return torque if self.disturbance is None else torque + self.disturbance


def estimates_along(history: Rollout, source: Any, gains: str = "default", **changes: Any) -> EstimateHistory:
    """Return the estimates of an observer along a recorded rollout.

    The rollout is repeated from its commands, and the observer takes its measurements: any observer can be applied to
    any rollout. The observer inside the baseline of the rollout has the same estimates as then.

    Parameters
    ----------
    history
        The rollout.
    source
        Name or class of a baseline with an observer inside, or name of an observer
        (:func:`ftac_gym.baselines.observers.names`).
    gains
        ``"default"`` or ``"tuned"``, as for :func:`ftac_gym.baselines.make`; only the default for an observer or a
        custom class.
    **changes
        Gains that differ from these.

    Raises
    ------
    ValueError
        If the source or a gain is unknown, it does not fit the rollout's scenario, or it has no estimate.
    """
    scenario, count = history.scenario, history.command.shape[1]
    observer = _observer(scenario, count, source, gains, changes)
    update = observer.update if isinstance(observer, FaultSource) else observer.act
    stored: dict[str, list[Any]] = {name: [] for name in _PARTS}
    for simulator in replay(history):
        update(simulator.measurement(truth=observer.information == "oracle"))
        require(observer.estimate is not None, "source", "must have an observer of faults", source)
        for name, rows in stored.items():
            rows.append(getattr(observer.estimate, name))
    # The parts that an observer has are the same at every measurement.
    parts = {name: None if rows[0] is None else np.array(rows) for name, rows in stored.items()}
    return EstimateHistory(history, **parts)


def _observer(
    scenario: Scenario, count: int, source: Any, gains: str, changes: dict[str, Any]
) -> Baseline | FaultSource:
    named = isinstance(source, str) and baselines.is_baseline(source)
    if named or (isinstance(source, type) and issubclass(source, Baseline)):
        return baselines.build(source, scenario, count, gains, **changes)
    require(gains == "default", "gains", "must be 'default' unless source is a baseline of this package", gains)
    if not isinstance(source, str) or source not in observers.names():
        known = f"{known_names(str(source))} or an observer ({', '.join(observers.names())})"
        raise broken("source", f"must be a Baseline class, {known}", source)
    return FaultSource(scenario, Memory(count), source, changes)


def replay(history: Rollout) -> Iterator[Simulator]:
    """Repeat a rollout from its commands, and yield its simulator at each of the T + 1 times.

    A rollout records the truth; the simulator has the rest, such as measurements.
    """
    simulator = Simulator(history.scenario, history.command.shape[1])
    simulator.reset(history.episodes)
    yield simulator
    for command in history.command:
        simulator.step(command)
        yield simulator
