"""The interface of every fault observer."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, ClassVar

from ftac_gym.baselines.estimate import FaultEstimate
from ftac_gym.baselines.memory import Memory
from ftac_gym.baselines.tunable import Tunable
from ftac_gym.baselines.units import Scales, factors_of, has_units, physical
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray


class FaultObserver(Tunable, ABC):
    """An estimator of faults from the measurements and the commands, built from the scenario's nominal parameters.

    Parameters
    ----------
    scenario
        The task.
    memory
        Store of the state.
    **gains
        Gains that differ from the defaults.

    Raises
    ------
    TypeError
        If a gain is unknown.
    ValueError
        If a gain breaks a rule.
    """

    information: ClassVar[str] = "attitude"
    """Tier of the information that it needs."""

    def __init__(self, scenario: Scenario, memory: Memory, **gains: Any) -> None:
        super().__init__(**gains)
        self._scenario, self._memory = scenario, memory
        self.physical: Any = self.gains
        """The gains in SI units."""
        if has_units(self.gains):
            self.physical = physical(self.gains, factors_of(self.gains, Scales.of(scenario)))
        self._axes_transposed: FloatArray = scenario.spacecraft.wheels.axis_matrix.T.copy()
        self._build()

    def _build(self) -> None:
        """Build the parts from the gains and the scenario, and add their state to the memory."""

    @abstractmethod
    def update(self, measurement: Measurement, command: FloatArray, dt: float) -> FaultEstimate:
        """Take in a measurement and the command (N, m) [N m] of the period dt [s] that ends with it."""

    @property
    @abstractmethod
    def estimate(self) -> FaultEstimate:
        """The latest estimate; after a reset, the initial one."""
