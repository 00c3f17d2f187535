"""A robust adaptive fixed-time sliding-mode control: the family of Esmaeilzadeh, Golestani and Mobayen 2021."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ftac_gym.attitude import cross
from ftac_gym.baselines.components.adaptation import LeakyAdaptation
from ftac_gym.baselines.components.relative_motion import RelativeMotion
from ftac_gym.baselines.components.surfaces import NonsingularTerminalSurface, signed_power
from ftac_gym.baselines.controllers.flexible import FlexibleController, FlexibleGains
from ftac_gym.baselines.gains import Range, fixed, parameter
from ftac_gym.baselines.rules import at_least, interval
from ftac_gym.task.measurement import Measurement
from ftac_gym.utils.parameters import FloatArray, fields_named, non_negative, positive


@dataclass(frozen=True)
class RAFTSMCClassGains(FlexibleGains):
    """Gains of :class:`RAFTSMCClass`."""

    faults: str = fixed("none")
    observer: None = fixed(None)
    slope: float = fixed(0.0)
    first: float = parameter(0.2, "k1", "rad/s", non_negative, Range(0.01, 1.0, log=True))
    second: float = parameter(0.2, "k2", "rad/s", non_negative, Range(0.01, 1.0, log=True))
    first_exponent: float = parameter(1.2, "r1", "", at_least(1.0))
    second_exponent: float = parameter(0.6, "r2", "", interval(0.0, 1.0))
    bound: float = parameter(0.01, "phi", "", positive)
    reaching_high: float = parameter(
        20.0, "kappa_a", "N m per power of rad/s", non_negative, Range(1.0, 300.0, log=True)
    )
    reaching_low: float = parameter(8.0, "kappa_b", "N m per power of rad/s", non_negative, Range(0.1, 30.0, log=True))
    high_exponent: float = parameter(1.5, "r3", "", at_least(1.0))
    low_exponent: float = parameter(0.6, "r4", "", interval(0.0, 1.0))
    adaptation: float = parameter(1.0, "g1 = g2", "N m s^-1 per rad/s", non_negative, Range(1e-3, 10.0, log=True))
    forgetting: float = parameter(0.1, "p1 = p2", "", non_negative)
    layer: float = parameter(0.01, "e", "rad/s", positive, Range(1e-3, 0.3, log=True))


class RAFTSMCClass(FlexibleController):
    """A fixed-time terminal surface, a two-power reaching law and an adaptive bound.

    ::

        S = w_e + k1 sig(q_ev)^r1 + k2 S_au(q_ev),  S_au = sig(q)^r2 outside |q| = phi, a parabola inside
        torque = w x J w + feed-forward - J_q c'(q_ev) q_ev'
                 - kappa_a sig(S)^r3 - kappa_b sig(S)^r4 - rho^ S / (|S| + e)
        rho^ = c1 + c2 |w|,  c_i' = g_i (|w|^(i-1) |S| - p_i c_i)

    with J_q = J - delta' delta and c the part of S that depends on the attitude. Surface and numbers are those that Li
    et al. 2023 print; l1 = 8.8 and l2 = -252 there are what makes the parabola smooth. The law behind them was not
    available: reaching and adaptation are of its class, with the gains at the places that fit their names best.
    """

    gains = RAFTSMCClassGains()

    def _build(self) -> None:
        super()._build()
        own = self.gains
        self._terminal = NonsingularTerminalSurface(0.0, own.second, own.second_exponent, own.bound)
        with fields_named(leak="adaptation times forgetting"):
            leak = own.forgetting * own.adaptation
            self._bounds = LeakyAdaptation(self.memory, "bounds", 2, own.adaptation, leak, self._period)

    def _surface(self, error: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return c(q_ev) and its slope, each (N, 3)."""
        value, slope = self._terminal(error)
        gain, power = self.gains.first, self.gains.first_exponent
        value = value + gain * signed_power(error, power)
        return value, slope + (gain * power) * np.abs(error) ** (power - 1.0)

    def _variable(self, motion: RelativeMotion) -> FloatArray:
        """Return S (N, 3) [rad/s]."""
        return motion.rate_error + self._surface(motion.error[:, 1:])[0]

    def _torque(self, measurement: Measurement, motion: RelativeMotion, variable: FloatArray) -> FloatArray:
        scalar, vector = motion.error[:, :1], motion.error[:, 1:]
        turning = 0.5 * (scalar * motion.rate_error + cross(vector, motion.rate_error))
        _, slope = self._surface(vector)
        size = np.linalg.norm(variable, axis=1, keepdims=True)
        speed = np.linalg.norm(measurement.rate, axis=1, keepdims=True)
        growth = np.concatenate([np.ones_like(speed), speed], axis=1)
        adaptive = (self._bounds.value * growth).sum(axis=1, keepdims=True)
        self._bounds.update(growth * size)
        own = self.gains
        reaching = own.reaching_high * signed_power(variable, own.high_exponent)
        reaching += own.reaching_low * signed_power(variable, own.low_exponent)
        torque = self._gyroscopic_torque(measurement, motion) - (slope * turning) @ self._quick_inertia
        torque -= reaching + adaptive / (size + own.layer) * variable
        return torque
