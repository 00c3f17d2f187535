"""An agent that is told of the faults: what an observer makes of them, the truth, or nothing."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np

from ftac_gym.baselines import FaultEstimate, observers
from ftac_gym.baselines.components.gyroscopic import GyroscopicModel
from ftac_gym.baselines.fault_source import FaultSource
from ftac_gym.baselines.memory import Memory
from ftac_gym.baselines.observers.disturbance_observer import DisturbanceObserver
from ftac_gym.envs.observation import BOUND, fault_entries, fault_parts
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, require
from ftac_gym.wrappers.stage import BoolArray, Observation, Stage, StageWrapper, VectorStageWrapper

SOURCES = ("none", "truth", "dob", *observers.names())
"""Where an estimate of the faults can come from."""


class _Source(Protocol):
    @property
    def information(self) -> str:
        """The tier of information that it needs."""

    @property
    def estimate(self) -> FaultEstimate | None:
        """The latest estimate; None for none."""

    def update(self, measurement: Measurement) -> FaultEstimate | None:
        """Take in a measurement and return the estimate."""


class _TorqueSource:
    """The disturbance observer of :class:`~ftac_gym.baselines.controllers.pd.PDDisturbanceObserver`."""

    information = "attitude"

    def __init__(self, scenario: Scenario, memory: Memory, bandwidth: float = 4.5602) -> None:
        gyroscopic = GyroscopicModel(scenario, telemetry=False)
        self._observer = DisturbanceObserver(scenario, memory, bandwidth, gyroscopic)

    @property
    def estimate(self) -> FaultEstimate:
        """The latest estimate."""
        return FaultEstimate(disturbance=self._observer.disturbance)

    def update(self, measurement: Measurement) -> FaultEstimate:
        """Take in a measurement and return the estimate."""
        return FaultEstimate(disturbance=self._observer.update(measurement))


def _source(kind: str, scenario: Scenario, memory: Memory, gains: Mapping[str, Any]) -> _Source:
    if kind == "dob":
        try:
            return _TorqueSource(scenario, memory, **gains)
        except TypeError as error:
            raise ValueError(f"gains of dob: {error}") from None
    observed = kind in observers.names()
    require(observed or not gains, "gains", f"must not be given where source = {kind!r}", dict(gains))
    return FaultSource(scenario, memory, kind if observed else "none", gains)


class _EstimateStage(Stage):
    """What is known of the faults of N craft."""

    def __init__(self, env: Any, source: str | None = None, **gains: Any) -> None:
        super().__init__(env)
        kind = "none" if source is None else source
        require(kind in SOURCES, "source", f"must be None or one of {list(SOURCES)}", source)
        scenario = self.inner.scenario
        self._memory = Memory(self.num_spacecraft)
        self._source = _source(kind, scenario, self._memory, gains)
        self._limits = scenario.spacecraft.wheels.torque_limits
        self._true = kind == "truth"
        if self._true:
            self.inner.keep_final_truth = True
            bounds = [np.full(length, bound) for _, length, bound in fault_parts(len(self._limits))]
            high = np.concatenate(bounds)
            low = -high
        else:
            parts = _scaled(self._source.estimate, self._limits)
            ends = [np.full(values.shape[1], 1.0 if logical else BOUND) for values, logical in parts]
            signs = [0.0 if logical else -1.0 for _, logical in parts]
            high = np.concatenate([np.zeros(0), *ends])
            low = np.concatenate([np.zeros(0), *(sign * end for sign, end in zip(signs, ends, strict=True))])
        self.extend(low, high)
        self._entries = np.zeros((self.num_spacecraft, len(high)))

    @property
    def information(self) -> str:
        """The tier of information: oracle for the truth, else that of the observer."""
        return "oracle" if self._true else self._source.information

    def observe(self, observation: Observation, mask: BoolArray) -> Observation:
        """Add what is known at the present measurement, which is new for the craft in the mask (N,)."""
        measurement = self.inner.measurement(truth=self._true)
        started = self.started(measurement, mask)
        if started.any():
            self._memory.reset(started)
        self._entries = np.where(mask[:, None], self._known(measurement, mask), self._entries)
        return np.concatenate([observation, self._entries], axis=1, dtype=np.float32)

    def preview(self, observation: Observation, measurement: Measurement) -> Observation:
        """Add what would be known at another measurement."""
        nobody = np.zeros(self.num_spacecraft, dtype=np.bool_)
        return np.concatenate([observation, self._known(measurement, nobody)], axis=1, dtype=np.float32)

    def _known(self, measurement: Measurement, mask: BoolArray) -> FloatArray:
        """Return the entries (N, size) for a measurement, moving on for the craft in the mask (N,) alone."""
        if self._true:
            assert measurement.truth is not None
            return np.concatenate(fault_entries(measurement.truth, self._limits), axis=1)
        before = self._memory.copy()
        parts = _scaled(self._source.update(measurement), self._limits)
        if not mask.all():
            self._memory.restore(before, ~mask)
        return np.concatenate([np.zeros((self.num_spacecraft, 0)), *(values for values, _ in parts)], axis=1)


def _scaled(estimate: FaultEstimate | None, torque_limits: FloatArray) -> list[tuple[FloatArray, bool]]:
    """Return the scaled parts (N, length) of an estimate that there are, and whether each is a yes or no."""
    if estimate is None:
        return []
    mean_limit = torque_limits.mean()
    known = (
        (estimate.disturbance, mean_limit),
        (estimate.effectiveness, 1.0),
        (estimate.bias, torque_limits),
        (estimate.identifiable, 1.0),
        (estimate.vibration, mean_limit),
    )
    return [
        (np.clip(values / scale, -BOUND, BOUND), values.dtype == np.bool_)
        for values, scale in known
        if values is not None
    ]


class VectorFaultEstimateObservation(VectorStageWrapper):
    """:class:`FaultEstimateObservation` for N craft; every craft's observer is reset with its episode."""

    stage_type = _EstimateStage


class FaultEstimateObservation(StageWrapper):
    """Append what is known of the faults to the observation.

    An observer knows the nominal craft and takes in one measurement per control period. Of what it estimates, in this
    order: torque on the body over the mean torque limit (3), effectiveness of each wheel, bias of each over its torque
    limit, whether each can be identified (0 or 1), torque of the vibration modes over the mean torque limit (3).
    Entries are clipped to :data:`~ftac_gym.envs.observation.BOUND`. Given a vector environment, the constructor returns
    a :class:`VectorFaultEstimateObservation`.

    Parameters
    ----------
    env
        An environment of this package, single or vector.
    source
        None or ``"none"`` for nothing; ``"truth"`` for what the oracle tier tells
        (:func:`~ftac_gym.envs.observation.fault_parts`); ``"dob"`` for the disturbance observer of the torque on the
        body; or a name of :func:`ftac_gym.baselines.observers.names`.
    **gains
        Gains of the observer.

    Raises
    ------
    ValueError
        If the environment is not of this package, or the source or a gain is refused.
    """

    vector_type = VectorFaultEstimateObservation

    def __init__(self, env: Any, source: str | None = None, **gains: Any) -> None:
        super().__init__(env, source=source, **gains)
