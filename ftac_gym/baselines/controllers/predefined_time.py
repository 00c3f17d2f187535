"""Predefined-time sliding mode for a sampled spacecraft with small wheels."""

from __future__ import annotations

from dataclasses import dataclass

from ftac_gym.attitude import angular_velocity_from_mrp, mrp_curvature, mrp_derivative
from ftac_gym.baselines.components.predefined_time_gain import PredefinedTime, PredefinedTimeSliding
from ftac_gym.baselines.components.reaching import switching
from ftac_gym.baselines.controllers.relative import RelativeController, RelativeGains
from ftac_gym.baselines.gains import Range, Share, parameter
from ftac_gym.baselines.rules import interval
from ftac_gym.baselines.units import ACCELERATION, PER_LOOP, PER_SPEED, SPEED
from ftac_gym.task.measurement import Measurement
from ftac_gym.utils.parameters import FloatArray, fields_named, non_negative, positive


@dataclass(frozen=True)
class PredefinedTimeGains(RelativeGains):
    """Gains of :class:`PredefinedTimeController`."""

    position_exponent: float = parameter(0.25, "h1", "", interval(0.0, 1.0), Range(0.05, 0.35))
    rate_exponent: float = parameter(0.2, "h2", "", interval(0.0, 1.0), Range(0.05, 0.5))
    position_time: float = parameter(3.52, "T1", PER_SPEED, positive, Range(0.6, 12.0, log=True))
    rate_time: float = parameter(0.5867, "T2", PER_SPEED, positive, Range(0.06, 6.0, log=True))
    position_gain: float = parameter(
        0.2, "f_a at zero", PER_LOOP, positive, Range(0.1, 0.8), share=Share("position_share", of="rate_gain")
    )
    rate_gain: float = parameter(0.8, "f_b at zero", PER_LOOP, positive, Range(0.1, 2.2))
    rate_scale: float = parameter(8.522, "Size of s at which V_b is 1/2", SPEED, positive)
    switching_gain: float = parameter(
        7.263e-3, "a. Zero for none", ACCELERATION, non_negative, Range(7e-5, 0.7, log=True)
    )


class PredefinedTimeController(RelativeController):
    """The law of Cao, Gong and Han 2022 for sampled control.

    With the error MRP sigma, V_a = ``|sigma|^2`` / 2, s = sigma' + f_a sigma and V_b = ``|s / w|^2`` / 2
    with the rate w = ``rate_scale``, 1 1/s on the flagship::

        w_e' = -G^-1 (G' w_e + (f_a sigma)' + f_b s + a tanh(s / layer))

    f_a and f_b are infinite at zero in the paper. Here each is regularised by its gain at zero (``position_gain``,
    ``rate_gain``), which sampling limits: ``rate_gain`` stays well below 2 / L. T1 + T2 is then
    no bound; with saturating wheels it is none in the paper either. The switching term is an acceleration, which always
    opposes s. Its layer adds at most a tenth of the rate gain.
    """

    gains = PredefinedTimeGains()

    def _build(self) -> None:
        super()._build()
        own: PredefinedTimeGains = self.scheduled
        with fields_named("position_"):
            position = PredefinedTime.with_gain(own.position_exponent, own.position_time, own.position_gain)
        with fields_named("rate_"):
            rate = PredefinedTime.with_gain(own.rate_exponent, own.rate_time, own.rate_gain)
        self._sliding = PredefinedTimeSliding(position, rate, own.rate_scale)
        self._layer = max(10.0 * own.switching_gain / own.rate_gain, 1e-300)

    def _variable(self, measurement: Measurement, error: FloatArray, rate_error: FloatArray) -> FloatArray:
        return self._sliding.variable(error, mrp_derivative(error, rate_error))

    def _acceleration(self, measurement: Measurement, error: FloatArray, rate_error: FloatArray) -> FloatArray:
        speed = mrp_derivative(error, rate_error)
        variable, reference = self._sliding.demand(error, speed, mrp_curvature(error, speed, rate_error))
        if self.scheduled.switching_gain > 0.0:
            reference += self.scheduled.switching_gain * switching(variable, self._layer)
        return -angular_velocity_from_mrp(error, reference)
