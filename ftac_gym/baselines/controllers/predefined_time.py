"""Predefined-time sliding mode for a sampled craft with small wheels."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from ftac_gym.attitude import angular_velocity_from_mrp, mrp_curvature, mrp_derivative
from ftac_gym.baselines.components.predefined_time_gain import PredefinedTime, PredefinedTimeSliding
from ftac_gym.baselines.components.reaching import switching
from ftac_gym.baselines.controllers.relative import RelativeController
from ftac_gym.baselines.gains import Range, SearchSpace
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, fields_named, non_negative, positive, require


class PredefinedTimeController(RelativeController):
    """The law of Cao, Gong and Han 2022 for control at some 10 Hz.

    With the error MRP sigma, V_a = |sigma|^2 / 2, s = sigma' + f_a sigma and V_b = |s|^2 / 2:

        w_e' = -G^-1 (G' w_e + (f_a sigma)' + f_b s + a tanh(s / layer))

    f_a and f_b are infinite at zero in the paper. Here each is regularised so that it is the gain there that is given
    (``position_gain``, ``rate_gain``), which sampling limits; T1 + T2 is no bound any more, and was none with wheels
    that saturate. The switching term is an acceleration, which always opposes s, with a layer that adds no more than a
    tenth of the rate gain.

    Parameters
    ----------
    scenario, num_spacecraft
        As for every baseline.
    faults, observer
        Where the estimates of the faults come from.
    position_exponent, rate_exponent
        h1, h2.
    position_time, rate_time
        T1, T2 [s].
    position_gain, rate_gain
        f_a and f_b at zero [1/s]; the second above the first, and well below two over the control period.
    switching_gain
        a [1/s^2]; zero leaves the switching term out.
    attitude_filter_time
        Time constant of the attitude filter [s]; zero for none.

    Raises
    ------
    ValueError
        If a gain breaks a rule.
    """

    search_space: ClassVar[SearchSpace] = {
        "position_exponent": Range(0.05, 0.35),
        "rate_exponent": Range(0.05, 0.5),
        "position_time": Range(5.0, 100.0, log=True),
        "rate_time": Range(0.5, 50.0, log=True),
        "position_share": Range(0.1, 0.8),
        "rate_gain": Range(0.5, 8.0),
        "switching_gain": Range(1e-6, 1e-2, log=True),
        "attitude_filter_time": Range(0.1, 5.0),
    }
    shares: ClassVar = {"position_share": ("position_gain", "rate_gain")}

    def __init__(
        self,
        scenario: Scenario,
        num_spacecraft: int = 1,
        faults: str = "none",
        observer: Mapping[str, Any] | None = None,
        position_exponent: float = 0.25,
        rate_exponent: float = 0.2,
        position_time: float = 30.0,
        rate_time: float = 5.0,
        position_gain: float = 1.0,
        rate_gain: float = 4.0,
        switching_gain: float = 1e-4,
        attitude_filter_time: float = 1.0,
    ) -> None:
        super().__init__(
            scenario, num_spacecraft, faults=faults, observer=observer, attitude_filter_time=attitude_filter_time
        )
        rule = f"must be below rate_gain = {rate_gain!r}"
        require(positive(position_gain, "position_gain") < rate_gain, "position_gain", rule, position_gain)
        with fields_named("position_"):
            position = PredefinedTime.with_gain(position_exponent, position_time, position_gain)
        with fields_named("rate_"):
            rate = PredefinedTime.with_gain(rate_exponent, rate_time, rate_gain)
        self._sliding = PredefinedTimeSliding(position, rate)
        self._switching_gain = non_negative(switching_gain, "switching_gain")
        self._layer = max(10.0 * switching_gain / rate_gain, 1e-300)

    def _variable(self, measurement: Measurement, error: FloatArray, rate_error: FloatArray) -> FloatArray:
        return self._sliding.variable(error, mrp_derivative(error, rate_error))

    def _acceleration(self, measurement: Measurement, error: FloatArray, rate_error: FloatArray) -> FloatArray:
        speed = mrp_derivative(error, rate_error)
        variable, wanted = self._sliding.demand(error, speed, mrp_curvature(error, speed, rate_error))
        if self._switching_gain > 0.0:
            wanted += self._switching_gain * switching(variable, self._layer)
        return -angular_velocity_from_mrp(error, wanted)
