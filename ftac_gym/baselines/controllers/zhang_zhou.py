"""What the two controllers of Zhang and Zhou 2019 share."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from ftac_gym.baselines.components.allocation import limit_each
from ftac_gym.baselines.components.anti_saturation import AntiSaturation
from ftac_gym.baselines.components.radial_basis import RadialBasisNetwork
from ftac_gym.baselines.components.reaching import ExponentialReaching
from ftac_gym.baselines.controllers.fault_tolerant import FaultTolerantController
from ftac_gym.baselines.estimate import FaultEstimate
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, fields_named, non_negative


class ZhangZhou(FaultTolerantController):
    """Reaching law, network, anti-saturation system and allocation; the surface and the rest are the law's own.

    Parameters
    ----------
    scenario, num_spacecraft
        As for every baseline.
    faults, observer
        See :class:`~ftac_gym.baselines.controllers.fault_tolerant.FaultTolerantController`.
    reaching_linear, reaching_switching
        e1 (or e3) [1/s] and e2 (or e4) [rad/s^2] of the exponential reaching law.
    reaching_floor, reaching_steepness, reaching_power
        d0, alpha and P0 of its denominator N.
    layer
        Boundary layer of every sign [rad/s]; zero takes the sign, as printed.
    network_gain
        mu3 (or theta2), learning gain of the network; zero switches it off.
    anti_saturation
        Gains of :class:`~..components.anti_saturation.AntiSaturation`; None leaves it out, since all it adds is
        a dependence on the integrator's step.

    Raises
    ------
    ValueError
        If a gain breaks a rule.
    """

    allocation_power: ClassVar[float] = 2.0

    def __init__(
        self,
        scenario: Scenario,
        num_spacecraft: int,
        faults: str,
        observer: Mapping[str, Any] | None,
        reaching_linear: float,
        reaching_switching: float,
        reaching_floor: float,
        reaching_steepness: float,
        reaching_power: int,
        layer: float,
        network_gain: float,
        anti_saturation: Mapping[str, Any] | None,
    ) -> None:
        super().__init__(scenario, num_spacecraft, faults=faults, observer=observer)
        self._layer = non_negative(layer, "layer")
        with fields_named("reaching_"):
            self._reaching = ExponentialReaching(
                reaching_linear, reaching_switching, reaching_floor, reaching_steepness, reaching_power, layer
            )
        self._network = RadialBasisNetwork(self.memory, network_gain, self._inverse_inertia, self._period)
        self._auxiliary = None
        if anti_saturation is not None:
            to_acceleration = self._inverse_inertia @ self._axes_transposed.T
            with fields_named("anti_saturation."):
                self._auxiliary = AntiSaturation(self.memory, self._period, to_acceleration, **anti_saturation)

    def _command(self, measurement: Measurement, variable: FloatArray, acceleration: FloatArray) -> FloatArray:
        """Return limited wheel torques (N, m) [N m].

        Parameters
        ----------
        measurement
            The measurement.
        variable
            s (N, 3) [rad/s].
        acceleration
            All that the law asks for but the gyroscopic torque, faults, network and auxiliary system, (N, 3) [rad/s^2].
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
