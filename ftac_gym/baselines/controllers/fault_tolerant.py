"""Base of the fault-tolerant controllers: the source of the fault estimate, and the allocation to the wheels."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ftac_gym.baselines import observers
from ftac_gym.baselines.baseline import Baseline
from ftac_gym.baselines.components.allocation import EffectivenessAllocation, MinimaxAllocation
from ftac_gym.baselines.components.gyroscopic import GyroscopicModel
from ftac_gym.baselines.estimate import FaultEstimate
from ftac_gym.baselines.fault_source import FaultSource
from ftac_gym.baselines.gains import Gains, SearchSpace, parameter
from ftac_gym.baselines.rules import interval, mapping
from ftac_gym.task.measurement import Measurement
from ftac_gym.utils.parameters import FloatArray, require


@dataclass(frozen=True)
class FaultTolerantGains(Gains):
    """Gains of :class:`FaultTolerantController`."""

    faults: str = parameter("none", 'Source of the faults: ``"none"``, the name of an observer, or ``"oracle"``')
    observer: Mapping[str, Any] | None = parameter(None, "Changed gains of the observer", rule=mapping)
    smallest_effectiveness: float = parameter(
        0.05, "Lower bound of the estimated effectiveness", "", interval(0.0, 1.0, closed=True)
    )


class FaultTolerantController(Baseline):
    """A controller that acts on an estimate of the faults.

    Raises
    ------
    ValueError
        If the source of faults is unknown, its gains are refused, or the controller cannot use what it estimates.
    """

    gains = FaultTolerantGains()
    allocation_power: ClassVar[float] = 1.0
    """Exponent of the allocation, see :class:`~ftac_gym.baselines.components.allocation.EffectivenessAllocation`."""
    takes_torques: ClassVar[bool] = False
    """True for a controller that subtracts an estimated torque on the body; else it needs estimates of the wheels."""

    def _build(self) -> None:
        super()._build()
        faults, rule = (
            self.gains.faults,
            "must be an observer of single wheels: this law takes no torque on the body off",
        )
        require(self.takes_torques or faults not in observers.OF_TORQUES, "faults", rule, faults)
        self._inverse_inertia: FloatArray = np.linalg.inv(self._inertia).astype(np.float64)
        axes = self.scenario.spacecraft.wheels.axis_matrix
        self._axes_transposed = axes.T.copy()
        self._gyroscopic = GyroscopicModel(self.scenario, telemetry=False)
        self._allocation = EffectivenessAllocation(axes, self.allocation_power, self.gains.smallest_effectiveness)
        self._minimax = MinimaxAllocation(self.scenario.spacecraft.wheels)
        self._faults = FaultSource(self.scenario, self.memory, faults, self.gains.observer)
        # An observer of the attitude tier takes nothing from a baseline whose estimators have telemetry.
        if self._faults.information != "attitude":
            self.information = self._faults.information

    @classmethod
    def space(cls, **gains: Any) -> SearchSpace:
        """Return the ranges that a tuner searches: those of the controller, and those of its observer if it has one."""
        kind = gains.get("faults", "none")
        if kind not in observers.names():
            return cls.search_space
        parts = {f"observer.{name}": item for name, item in observers.search_space(kind).items()}
        return {**cls.search_space, **parts}

    @abstractmethod
    def sliding_variable(self, measurement: Measurement) -> FloatArray:
        """Return s (N, 3) at a measurement; the memory is unchanged."""

    @property
    def estimate(self) -> FaultEstimate | None:
        """The latest estimate of the observer, or the truth of an oracle; None without either."""
        return self._faults.estimate

    def _to_wheels(self, torque: FloatArray, estimate: FaultEstimate | None) -> FloatArray:
        """Return wheel torques (N, m) [N m], not limited, that give a torque (N, 3) under the estimated faults."""
        if estimate is None:
            return self._allocation(torque, None)
        if estimate.bias is not None:
            torque = torque - estimate.bias @ self._axes_transposed
        return self._allocation(torque, estimate.effectiveness)

    def _to_wheels_evenly(self, torque: FloatArray, estimate: FaultEstimate | None) -> FloatArray:
        """Return the same with the smallest largest share of a limit.

        The torque that weak wheels fail to give by their estimated effectiveness is added by the others.
        """
        if estimate is None:
            return self._minimax(torque)
        if estimate.bias is not None:
            torque = torque - estimate.bias @ self._axes_transposed
        elif estimate.disturbance is not None:
            # An observer without biases has them, and all else, in the torque that keeps it at the measured rate.
            torque = torque - estimate.disturbance
        if estimate.vibration is not None:
            torque = torque - estimate.vibration
        command = self._minimax(torque)
        if estimate.effectiveness is None:
            return command
        missing = torque - (np.clip(estimate.effectiveness, 0.0, 1.0) * command) @ self._axes_transposed
        return command + self._allocation(missing, estimate.effectiveness)
