"""Estimates of the faults beside the observation: those of an observer, or the truth."""

from typing import Any

import numpy as np

from ftac_gym.baselines import FaultEstimate, observers
from ftac_gym.baselines.components.gyroscopic import GyroscopicModel
from ftac_gym.baselines.controllers.pd import PDDisturbanceObserver
from ftac_gym.baselines.fault_source import FaultSource
from ftac_gym.baselines.memory import Memory
from ftac_gym.baselines.observers.disturbance_observer import DisturbanceObserver
from ftac_gym.baselines.units import PER_LOOP, Scales
from ftac_gym.envs.observation import BOUND, fault_entries, fault_parts
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, positive, require, require_keywords
from ftac_gym.wrappers.transform import BoolArray, Observation, Transform, wrapper

SOURCES = ("none", "truth", "dob", *observers.names())
"""Sources of estimates of the faults."""


class TorqueSource:
    """The disturbance observer of :class:`~ftac_gym.baselines.controllers.pd.PDDisturbanceObserver`."""

    information = "attitude"

    def __init__(
        self, scenario: Scenario, memory: Memory, bandwidth: float = PDDisturbanceObserver.gains.bandwidth
    ) -> None:
        gyroscopic = GyroscopicModel(scenario, telemetry=False)
        unit = PER_LOOP.value(Scales.of(scenario))
        self._observer = DisturbanceObserver(scenario, memory, unit * positive(bandwidth, "bandwidth"), gyroscopic)

    @property
    def estimate(self) -> FaultEstimate:
        """The latest estimate."""
        return FaultEstimate(disturbance=self._observer.disturbance)

    def update(self, measurement: Measurement) -> FaultEstimate:
        """Process a measurement and return the estimate."""
        return FaultEstimate(disturbance=self._observer.update(measurement))


def source_gains(source: str | None) -> dict[str, Any]:
    """Return the default gains of a source of estimates, empty for one without gains."""
    if source == "dob":
        return {"bandwidth": PDDisturbanceObserver.gains.bandwidth}
    return observers.defaults(source) if source in observers.names() else {}


class FaultEstimates(Transform):
    """Append an estimate of the faults to the observation.

    An observer has the nominal spacecraft as its model and processes one measurement per control period. The entries
    are clipped to :data:`~ftac_gym.envs.observation.BOUND`; those of an observer are, as far as it estimates them,

    - torque on the body over the mean torque limit (3);
    - effectiveness of each wheel;
    - bias of each wheel over its torque limit;
    - whether each wheel can be identified (0 or 1);
    - torque of the vibration modes over the mean torque limit (3).

    Parameters
    ----------
    env
        An environment of this package, single or vector.
    source
        None or ``"none"`` for nothing; ``"truth"`` for the entries of the oracle tier
        (:func:`~ftac_gym.envs.observation.fault_parts`); ``"dob"`` for the disturbance observer of the torque on the
        body; or a name of :func:`ftac_gym.baselines.observers.names`.
    **gains
        Gains of the observer.

    Raises
    ------
    TypeError
        If a gain is unknown.
    ValueError
        If the environment is not of this package, or the source or a value is refused.
    """

    def __init__(self, env: Any, source: str | None = None, **gains: Any) -> None:
        super().__init__(env)
        kind = "none" if source is None else source
        require(kind in SOURCES, "source", f"must be None or one of {list(SOURCES)}", source)
        scenario = self.inner.scenario
        self._memory = Memory(self.num_spacecraft)
        self._limits = scenario.spacecraft.wheels.torque_limits
        self._true = kind == "truth"
        self._source: FaultSource | TorqueSource
        if kind == "dob":
            require_keywords(gains, ["bandwidth"], type(self).__name__, "gains of dob")
            self._source = TorqueSource(scenario, self._memory, **gains)
        else:
            observed = kind in observers.names()
            require(observed or not gains, "gains", f"must not be given where source = {kind!r}", gains)
            self._source = FaultSource(scenario, self._memory, kind if observed else "none", gains)
        self.information = "oracle" if self._true else self._source.information
        if self._true:
            self.inner.keep_final_truth = True
            parts = [(length, -bound, bound) for _, length, bound in fault_parts(len(self._limits))]
        else:
            scaled = _scaled(self._source.estimate, self._limits)
            parts = [(item.shape[1], *((0.0, 1.0) if logical else (-BOUND, BOUND))) for item, logical in scaled]
        lengths = np.array([length for length, *_ in parts], dtype=np.int64)
        low, high = np.repeat(np.array([ends for _, *ends in parts]).reshape(-1, 2), lengths, axis=0).T
        self.extend(low, high)
        self._entries = np.zeros((self.num_spacecraft, len(high)))

    @property
    def estimator(self) -> FaultSource | TorqueSource:
        """The source of the estimates, with none of its own for the truth."""
        return self._source

    def observe(self, observation: Observation, mask: BoolArray) -> Observation:
        """Add the estimate at the present measurement, which is new for the spacecraft in the mask (N,)."""
        measurement = self.measure(mask, self._memory.reset, self._true)
        self._entries = np.where(mask[:, None], self._estimate(measurement, mask), self._entries)
        return np.concatenate([observation, self._entries], axis=1, dtype=np.float32)

    def preview(self, observation: Observation, measurement: Measurement) -> Observation:
        """Add the estimate at another measurement."""
        none = np.zeros(self.num_spacecraft, dtype=np.bool_)
        return np.concatenate([observation, self._estimate(measurement, none)], axis=1, dtype=np.float32)

    def _estimate(self, measurement: Measurement, mask: BoolArray) -> FloatArray:
        """Return the entries (N, size) for a measurement, with a change of state for the mask (N,) alone."""
        if self._true:
            assert measurement.truth is not None
            return np.concatenate(fault_entries(measurement.truth, self._limits), axis=1)
        before = self._memory.copy()
        parts = _scaled(self._source.update(measurement), self._limits)
        if not mask.all():
            self._memory.restore(before, ~mask)
        return np.concatenate([np.zeros((self.num_spacecraft, 0)), *(values for values, _ in parts)], axis=1)


def _scaled(estimate: FaultEstimate | None, torque_limits: FloatArray) -> list[tuple[FloatArray, bool]]:
    """Return the scaled parts (N, length) that an estimate has, and whether each is logical."""
    if estimate is None:
        return []
    mean_limit = torque_limits.mean()
    scales = (
        (estimate.disturbance, mean_limit),
        (estimate.effectiveness, 1.0),
        (estimate.bias, torque_limits),
        (estimate.identifiable, 1.0),
        (estimate.vibration, mean_limit),
    )
    return [
        (np.clip(values / scale, -BOUND, BOUND), values.dtype == np.bool_)
        for values, scale in scales
        if values is not None
    ]


FaultEstimateObservation = wrapper("FaultEstimateObservation", FaultEstimates)
