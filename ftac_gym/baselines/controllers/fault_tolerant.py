"""What the fault-tolerant laws share: where they get the faults from, and how they reach the wheels."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from ftac_gym.baselines import observers
from ftac_gym.baselines.baseline import Baseline
from ftac_gym.baselines.components.allocation import EffectivenessAllocation, MinimaxAllocation
from ftac_gym.baselines.components.gyroscopic import GyroscopicModel
from ftac_gym.baselines.estimate import FaultEstimate
from ftac_gym.baselines.fault_source import FaultSource
from ftac_gym.baselines.gains import SearchSpace
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, fields_named, require


class FaultTolerantLaw(Baseline):
    """A law that acts on an estimate of the faults.

    Parameters
    ----------
    scenario, num_spacecraft
        As for every baseline.
    faults
        ``"none"``, the name of an observer (:mod:`ftac_gym.baselines.observers`), or ``"oracle"``.
    observer
        Gains of the observer that differ from its own.
    smallest_effectiveness
        An effectiveness believed smaller counts as this in the allocation.

    Raises
    ------
    ValueError
        If the source of faults is unknown, its gains are refused, or the law cannot use what it estimates.
    """

    allocation_power: ClassVar[float] = 1.0
    """Exponent of the allocation, see :class:`~ftac_gym.baselines.components.allocation.EffectivenessAllocation`."""
    takes_torques: ClassVar[bool] = False
    """Whether the law takes off a torque on the body that an observer of torques sees; else it asks for the wheels'."""

    def __init__(
        self,
        scenario: Scenario,
        num_spacecraft: int = 1,
        faults: str = "none",
        observer: Mapping[str, Any] | None = None,
        smallest_effectiveness: float = 0.05,
    ) -> None:
        super().__init__(scenario, num_spacecraft)
        rule = "must be an observer of single wheels: this law takes no torque on the body off"
        require(self.takes_torques or faults not in observers.OF_TORQUES, "faults", rule, faults)
        craft = scenario.spacecraft
        self._inertia = craft.inertia_matrix
        self._inverse_inertia: FloatArray = np.linalg.inv(self._inertia).astype(np.float64)
        axes = craft.wheels.axis_matrix
        self._axes_transposed = axes.T.copy()
        self._torque_limits = craft.wheels.torque_limits
        self._period = scenario.control_period
        self._gyroscopic = GyroscopicModel(scenario, telemetry=False)
        with fields_named(smallest="smallest_effectiveness"):
            self._allocation = EffectivenessAllocation(axes, self.allocation_power, smallest_effectiveness)
        self._minimax = MinimaxAllocation(craft.wheels)
        self._faults = FaultSource(scenario, self.memory, faults, observer)
        self.information = self._faults.information

    @classmethod
    def space(cls, **gains: Any) -> SearchSpace:
        """Return where a tuner looks: the gains of the law, and those of its observer if it has one."""
        kind = gains.get("faults", "none")
        if kind not in observers.names():
            return cls.search_space
        parts = {f"observer.{name}": item for name, item in observers.search_space(kind).items()}
        return {**cls.search_space, **parts}

    @abstractmethod
    def sliding_variable(self, measurement: Measurement) -> FloatArray:
        """Return s (N, 3) at a measurement, without moving on."""

    @property
    def estimate(self) -> FaultEstimate | None:
        """The latest estimate of the observer, or the truth of an oracle; None without either."""
        return self._faults.estimate

    def _to_wheels(self, torque: FloatArray, estimate: FaultEstimate | None) -> FloatArray:
        """Return wheel torques (N, m) [N m], not limited, that give a torque (N, 3) in spite of the faults believed."""
        if estimate is None:
            return self._allocation(torque, None)
        if estimate.bias is not None:
            torque = torque - estimate.bias @ self._axes_transposed
        return self._allocation(torque, estimate.effectiveness)

    def _to_wheels_evenly(self, torque: FloatArray, estimate: FaultEstimate | None) -> FloatArray:
        """Return wheel torques (N, m) [N m], not limited, likewise, with the smallest largest share of a limit.

        What this lacks through wheels that are believed weak is given to the others.
        """
        if estimate is None:
            return self._minimax(torque)
        if estimate.bias is not None:
            torque = torque - estimate.bias @ self._axes_transposed
        elif estimate.disturbance is not None:
            # An observer that knows no biases has them, and all else, in the torque that keeps it on the measured rate.
            torque = torque - estimate.disturbance
        if estimate.vibration is not None:
            torque = torque - estimate.vibration
        command = self._minimax(torque)
        if estimate.effectiveness is None:
            return command
        missing = torque - (np.clip(estimate.effectiveness, 0.0, 1.0) * command) @ self._axes_transposed
        return command + self._allocation(missing, estimate.effectiveness)
