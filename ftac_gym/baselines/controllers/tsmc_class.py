"""A terminal sliding-mode controller: the comparator of Cao, Gong and Han 2022."""

from __future__ import annotations

from dataclasses import dataclass

from ftac_gym.attitude import mrp_derivative
from ftac_gym.baselines.components.reaching import PowerReaching
from ftac_gym.baselines.components.surfaces import FastTerminalSurface
from ftac_gym.baselines.controllers.relative import RelativeController, RelativeGains
from ftac_gym.baselines.gains import Range, changed, parameter
from ftac_gym.baselines.rules import interval
from ftac_gym.task.measurement import Measurement
from ftac_gym.utils.parameters import FloatArray, non_negative, positive


@dataclass(frozen=True)
class TSMCClassGains(RelativeGains):
    """Gains of :class:`TSMCClass`."""

    linear: float = parameter(0.3, "a", "rad/s", non_negative, Range(0.01, 1.0, log=True))
    terminal: float = parameter(0.3, "b", "rad/s", non_negative, Range(0.01, 1.0, log=True))
    exponent: float = parameter(5.0 / 7.0, "p", "", interval(0.0, 1.0), Range(0.5, 0.95))
    guard: float = parameter(0.02, "Guard of the slope", "", positive, Range(1e-5, 0.1, log=True))
    reaching_linear: float = parameter(1.0, "k", "1/s", non_negative, Range(0.1, 8.0, log=True))
    reaching_power_gain: float = parameter(0.2, "l", "", non_negative, Range(1e-3, 1.0, log=True))
    reaching_exponent: float = parameter(0.5, "g", "", interval(0.0, 1.0))
    attitude_filter_time: float = changed(RelativeGains, "attitude_filter_time", 0.0)


class TSMCClass(RelativeController):
    """s = w_e + a sigma + b sig(sigma)^p with s' = -k s - l sig(s)^g.

    The paper gives neither equations nor parameters of the comparator [10] (Zhang, Biggs, Ye and Sun 2020). This is a
    member of its family, finite-time terminal sliding mode in MRPs, with gains of our own.
    """

    gains = TSMCClassGains()

    def _build(self) -> None:
        super()._build()
        own = self.gains
        self._surface = FastTerminalSurface(own.linear, own.terminal, own.exponent, own.guard)
        self._reaching = PowerReaching(own.reaching_linear, own.reaching_power_gain, own.reaching_exponent)

    def _variable(self, measurement: Measurement, error: FloatArray, rate_error: FloatArray) -> FloatArray:
        return rate_error + self._surface(error)[0]

    def _acceleration(self, measurement: Measurement, error: FloatArray, rate_error: FloatArray) -> FloatArray:
        term, slope = self._surface(error)
        return self._reaching(rate_error + term) - slope * mrp_derivative(error, rate_error)
