"""Source of the fault estimate of a fault-tolerant controller: none, an observer, or the truth."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ftac_gym.baselines import observers
from ftac_gym.baselines.estimate import FaultEstimate
from ftac_gym.baselines.memory import Memory
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import require


class FaultSource:
    """The estimate that a controller acts on.

    Parameters
    ----------
    scenario
        The task.
    memory
        Store of the observer's state.
    kind
        ``"none"`` (every wheel is taken for healthy), the name of an observer, or ``"oracle"`` (the truth).
    gains
        Gains of the observer that differ from its own.

    Raises
    ------
    ValueError
        If the kind is unknown, or gains are given without an observer.
    """

    def __init__(self, scenario: Scenario, memory: Memory, kind: str, gains: Mapping[str, Any] | None = None) -> None:
        known = ["none", "oracle", *observers.names()]
        require(kind in known, "faults", f"must be one of {known}", kind)
        observed = kind in observers.names()
        require(observed or not gains, "observer", f"must not have gains where faults = {kind!r}", gains)
        self._observer = observers.make(kind, scenario, memory, **(gains or {})) if observed else None
        self._kind = kind
        self._period = scenario.control_period
        self._memory = memory
        if kind == "oracle":
            wheels = scenario.spacecraft.wheels.count
            memory.add("effectiveness", (wheels,), initial=1.0)
            memory.add("bias", (wheels,))

    @property
    def information(self) -> str:
        """The tier of information: oracle for the truth, else that of the observer, else attitude."""
        if self._observer is not None:
            return observers.information(self._kind)
        return "oracle" if self._kind == "oracle" else "attitude"

    @property
    def estimate(self) -> FaultEstimate | None:
        """The latest estimate of the observer, or the truth; None for healthy wheels."""
        if self._observer is not None:
            return self._observer.estimate
        if self._kind == "oracle":
            effectiveness, bias = self._memory["effectiveness"], self._memory["bias"]
            return FaultEstimate(None, effectiveness, bias, np.ones(effectiveness.shape, dtype=np.bool_))
        return None

    def update(self, measurement: Measurement) -> FaultEstimate | None:
        """Take in a measurement and return the estimate for the controller; None for healthy wheels."""
        if self._observer is not None:
            return self._observer.update(measurement, measurement.command_in_effect, self._period)
        if self._kind == "oracle":
            truth = measurement.truth
            if truth is None:
                raise ValueError("measurement must hold the truth for an oracle: measurement(truth=True), got None")
            self._memory["effectiveness"], self._memory["bias"] = truth.effectiveness, truth.bias
        return self.estimate
