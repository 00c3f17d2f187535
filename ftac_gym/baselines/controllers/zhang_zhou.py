"""Base of the two controllers of Zhang and Zhou 2019."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from ftac_gym.baselines.components.allocation import limit_each
from ftac_gym.baselines.components.anti_saturation import AntiSaturation
from ftac_gym.baselines.components.radial_basis import RadialBasisNetwork
from ftac_gym.baselines.components.reaching import ExponentialReaching
from ftac_gym.baselines.controllers.fault_tolerant import FaultTolerantController, FaultTolerantGains
from ftac_gym.baselines.estimate import FaultEstimate
from ftac_gym.baselines.gains import Range, fixed, parameter
from ftac_gym.baselines.rules import interval, mapping
from ftac_gym.task.measurement import Measurement
from ftac_gym.utils.parameters import FloatArray, fields_named, non_negative


@dataclass(frozen=True)
class ZhangZhouGains(FaultTolerantGains):
    """Gains of :class:`ZhangZhou`."""

    smallest_effectiveness: float = fixed(0.05)
    linear: float = parameter(0.6, "Linear part of the surface", "rad/s", non_negative, Range(0.01, 1.0, log=True))
    terminal: float = parameter(0.6, "Terminal part of the surface", "rad/s", non_negative, Range(0.01, 1.0, log=True))
    exponent: float = parameter(5.0 / 7.0, "Exponent of the terminal part", "", interval(0.0, 1.0))
    reaching_linear: float = parameter(1.5, "e1 or e3", "1/s", non_negative, Range(0.1, 6.0, log=True))
    reaching_switching: float = parameter(1.5, "e2 or e4", "rad/s^2", non_negative, Range(1e-4, 2.0, log=True))
    reaching_floor: float = parameter(0.5, "d0 of the denominator N", "", interval(0.0, 1.0))
    reaching_steepness: float = parameter(5.0, "alpha of N", "", non_negative)
    reaching_power: int = parameter(1, "P0 of N, a positive integer")
    layer: float = parameter(
        0.05, "Layer of the signs. Zero for none", "rad/s", non_negative, Range(1e-4, 0.5, log=True)
    )
    network_gain: float = parameter(1.0, "mu3 or theta2. Zero for none", "", non_negative, Range(1e-3, 10.0, log=True))
    anti_saturation: Mapping[str, Any] | None = parameter(None, "Gains of the auxiliary system, if any", rule=mapping)


class ZhangZhou(FaultTolerantController):
    """Reaching law, network, anti-saturation system and allocation; a subclass has the surface and the other terms.

    The :class:`~ftac_gym.baselines.components.anti_saturation.AntiSaturation` is left out by default: its only effect
    is a dependence on the integrator's step.
    """

    gains = ZhangZhouGains()
    allocation_power: ClassVar[float] = 2.0

    def _build(self) -> None:
        super()._build()
        own = self.gains
        with fields_named("reaching_"):
            self._reaching = ExponentialReaching(
                own.reaching_linear, own.reaching_switching, own.reaching_floor, own.reaching_steepness,
                own.reaching_power, own.layer,
            )  # fmt: skip
        self._network = RadialBasisNetwork(self.memory, own.network_gain, self._inverse_inertia, self._period)
        self._auxiliary = None
        if own.anti_saturation is not None:
            to_acceleration = self._inverse_inertia @ self._axes_transposed.T
            with fields_named("anti_saturation."):
                self._auxiliary = AntiSaturation(self.memory, self._period, to_acceleration, **own.anti_saturation)

    def _command(self, measurement: Measurement, variable: FloatArray, acceleration: FloatArray) -> FloatArray:
        """Return limited wheel torques (N, m) [N m].

        Parameters
        ----------
        measurement
            The measurement.
        variable
            s (N, 3) [rad/s].
        acceleration
            All terms of the law except gyroscopic torque, faults, network and auxiliary system, (N, 3) [rad/s^2].
        """
        estimate: FaultEstimate | None = self._faults.update(measurement)
        if self._auxiliary is not None:
            acceleration = acceleration - self._auxiliary.correction
        torque = acceleration @ self._inertia - self._network.torque(measurement.rate, variable)
        torque += self._gyroscopic.torque(measurement.rate, measurement.wheel_momentum)
        raw = self._to_wheels(torque, estimate)
        limited = limit_each(raw, self._torque_limits)
        if self._auxiliary is not None:
            self._auxiliary.update(limited - raw, None if estimate is None else estimate.effectiveness)
        return limited
