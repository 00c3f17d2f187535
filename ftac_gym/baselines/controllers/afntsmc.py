"""The adaptive non-singular terminal sliding mode of Lu and Xia 2013, comparator of Ma, Wang and Wang 2023."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ftac_gym.baselines.components.adaptation import LeakyAdaptation
from ftac_gym.baselines.components.reaching import PowerReaching
from ftac_gym.baselines.components.rows import dot
from ftac_gym.baselines.components.surfaces import NonsingularTerminalSurface
from ftac_gym.baselines.controllers.hybrid import HybridController, HybridGains, Lifted
from ftac_gym.baselines.gains import Range, changed, parameter
from ftac_gym.baselines.rules import interval
from ftac_gym.task.measurement import Measurement
from ftac_gym.utils.parameters import FloatArray, fields_named, non_negative, positive


@dataclass(frozen=True)
class AFNTSMCGains(HybridGains):
    """Gains of :class:`AFNTSMC`."""

    hysteresis: float | None = changed(HybridGains, "hysteresis", None, meaning="eta. None, as printed, unwinds")
    linear: float = parameter(1.0, "k2", "rad/s", non_negative, Range(0.005, 1.0, log=True))
    terminal: float = parameter(1.0, "k3", "rad/s", non_negative, Range(0.005, 1.0, log=True))
    exponent: float = parameter(0.6, "nu = nu1 / nu2", "", interval(0.0, 1.0), Range(0.5, 0.95))
    bound: float = parameter(1e-3, "epsilon of the surface", "", positive, Range(1e-3, 0.2, log=True))
    reaching_linear: float = parameter(20.0, "tau", "N m s/rad", non_negative, Range(1.0, 100.0, log=True))
    reaching_power_gain: float = parameter(10.0, "beta_0", "", non_negative, Range(1e-3, 10.0, log=True))
    reaching_exponent: float = parameter(0.5, "chi_0", "", interval(0.0, 1.0))
    adaptation: float = parameter(6.0, "n1 = n2", "", non_negative, Range(1e-4, 6.0, log=True))
    forgetting: float = parameter(0.35, "e3 = e4", "1/s", non_negative)
    width: float = parameter(0.16, "e5 = e6", "", positive)
    initial_bound: float = parameter(0.1, "psi(0) = phi(0)", "", non_negative)


class AFNTSMC(HybridController):
    """Eqs. (45)-(52) of Ma et al. 2023.

    ::

        S = w_e + k2 e_v + k3 S_au(e_v),  S_au = sig(e)^nu outside |e| = bound, a parabola inside
        u = -tau S - b0 sig(S)^x0 - X S,  X_i = (psi_i / e5^2 + phi_i |xi|^2 / e6^2) / 2
        psi_i' = -e3 psi_i + n1 S_i^2 / (2 e5^2)
        phi_i' = -e4 phi_i + n2 S_i^2 |xi|^2 / (2 e6^2),  |xi| = max(|w|^2, |w|)

    with e3 = e4, e5 = e6 and n1 = n2, as all their values are. The paper tests S with the power on the whole axis for
    being zero as well; a sampled S never is. There is no feed-forward: X covers the torque along the reference. The law
    goes to e_4 = 1, the long way round if the quaternion starts with e_4 < 0; ``hysteresis`` removes that.
    """

    gains = AFNTSMCGains()

    def _build(self) -> None:
        super()._build()
        own = self.gains
        self._surface = NonsingularTerminalSurface(own.linear, own.terminal, own.exponent, own.bound)
        self._reaching = PowerReaching(own.reaching_linear, own.reaching_power_gain, own.reaching_exponent)
        self._half = 0.5 / own.width**2
        with fields_named(leak="forgetting"):
            self._still, self._turning = (
                LeakyAdaptation(self.memory, name, 3, own.adaptation, own.forgetting, self._period, own.initial_bound)
                for name in ("bound_at_rest", "bound_in_motion")
            )

    def _variable(self, lifted: Lifted) -> FloatArray:
        return lifted.motion.rate_error + self._surface(lifted.logic * lifted.error[:, 1:])[0]

    def sliding_variable(self, measurement: Measurement) -> FloatArray:
        """Return S (N, 3) [rad/s] at a measurement, for its unfiltered attitude."""
        return self._variable(self._lifted(measurement, move_on=False))

    def act(self, measurement: Measurement) -> FloatArray:
        """Return the wheel torques to command, (N, wheels) [N m]."""
        variable = self._variable(self._lifted(measurement, move_on=True))
        square = dot(measurement.rate, measurement.rate)
        growth = np.maximum(square * square, square)
        adaptive = self._half * (self._still.value + self._turning.value * growth)
        torque = self._reaching(variable) - adaptive * variable
        drive = self._half * variable * variable
        self._still.update(drive)
        self._turning.update(drive * growth)
        return self._to_wheels(torque)
