"""Torque of each wheel from its own tachometer: a fault estimate from telemetry alone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ftac_gym.baselines.estimate import FaultEstimate
from ftac_gym.baselines.gains import Gains, Range, parameter
from ftac_gym.baselines.observers.observer import FaultObserver
from ftac_gym.baselines.units import PER_LOOP
from ftac_gym.task.measurement import Measurement
from ftac_gym.utils.parameters import FloatArray, positive


@dataclass(frozen=True)
class TachometerGains(Gains):
    """Gains of :class:`Tachometer`."""

    bandwidth: float = parameter(2.0, "Bandwidth of the low-pass", PER_LOOP, positive, Range(0.1, 10.0, log=True))


class Tachometer(FaultObserver):
    """Uncommanded torque of each wheel from the change of its measured momentum.

    Over a period T a wheel gave the body -(h_k - h_{k-1}) / T; its difference from the command u_{k-1} is low-passed.
    It contains a bias, a locked wheel's torque, friction, and the part of the command that a weak wheel did not give.
    It needs the telemetry tier. Momentum that leaves through the bearings is not distinguished, and torques on the body
    that come from no wheel are not estimated.
    """

    gains = TachometerGains()
    information: ClassVar[str] = "telemetry"

    def _build(self) -> None:
        super()._build()
        self._gain = 1.0 - np.exp(-self.physical.bandwidth * self._scenario.control_period)
        wheels = self._scenario.spacecraft.wheels.count
        self._memory.add("wheel_bias", (wheels,))
        self._memory.add("last_momentum", (wheels,))
        self._memory.add("tachometer_fresh", (1,), initial=True)

    @property
    def estimate(self) -> FaultEstimate:
        """The latest estimate."""
        return FaultEstimate(bias=self._memory["wheel_bias"])

    def update(self, measurement: Measurement, command: FloatArray, dt: float) -> FaultEstimate:
        """Take in a measurement and the command (N, m) [N m] of the period dt [s] that ends with it."""
        memory, momentum = self._memory, measurement.wheel_momentum
        excess = (memory["last_momentum"] - momentum) / dt - command
        change = np.where(memory["tachometer_fresh"], 0.0, excess - memory["wheel_bias"])
        memory["wheel_bias"], memory["last_momentum"] = memory["wheel_bias"] + self._gain * change, momentum
        memory["tachometer_fresh"] = np.zeros_like(memory["tachometer_fresh"])
        return self.estimate
