"""Prescribed performance for a sampled craft with small wheels."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from ftac_gym.baselines.components.error_transformation import Transformed
from ftac_gym.baselines.components.reaching import PowerReaching
from ftac_gym.baselines.controllers.prescribed import PrescribedError
from ftac_gym.baselines.controllers.relative import RelativeController
from ftac_gym.baselines.gains import Range, SearchSpace
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.prescribed_bound import PrescribedBound
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, fields_named, positive


class PrescribedPerformance(RelativeController):
    """The error transformation of Chen et al. 2018 for control at some 10 Hz.

    With epsilon, r and theta of :class:`~..components.error_transformation.ErrorTransformation` for the error
    MRP sigma_e, which is always on the short branch:

        a    = G^-1 r^-1 [-k1 epsilon - theta]
        s    = w_e - a
        w_e' = -k2 s - tau2 sig(s)^g

    What differs from the paper's law, and why:

    - No command filter: sampled, it is what loses the craft; the paper's law does not use the derivative either.
    - The bounds are the same on both sides, so that epsilon = 0 is sigma_e = 0, and wide enough at the start for every
      attitude, unless the scenario prescribes others.
    - The gyroscopic torque and the reference's motion are fed forward; there is no fuzzy system.

    Parameters
    ----------
    scenario, num_spacecraft
        As for every baseline.
    faults, observer
        Where the estimates of the faults come from.
    attitude_gain, rate_gain
        k1, k2 [1/s].
    rate_power_gain, power
        tau2, g.
    bound
        Fields of the :class:`~ftac_gym.task.prescribed_bound.PrescribedBound` that differ from the scenario's.
    mirror, margin
        See :class:`~ftac_gym.baselines.controllers.prescribed.PrescribedError`.
    attitude_filter_time
        Time constant of the attitude filter [s]; zero for none.

    Raises
    ------
    ValueError
        If a gain breaks a rule; :meth:`act` if a craft starts outside its bounds.
    """

    search_space: ClassVar[SearchSpace] = {
        "attitude_gain": Range(0.01, 2.0, log=True),
        "rate_gain": Range(0.3, 8.0, log=True),
        "rate_power_gain": Range(1e-4, 0.1, log=True),
        "margin": Range(1e-4, 0.3, log=True),
        "bound.initial": Range(1.05, 10.0, log=True),
        "bound.final": Range(1e-4, 0.3, log=True),
        "bound.decay": Range(0.01, 0.5, log=True),
        "attitude_filter_time": Range(0.1, 5.0),
    }

    def __init__(
        self,
        scenario: Scenario,
        num_spacecraft: int = 1,
        faults: str = "none",
        observer: Mapping[str, Any] | None = None,
        attitude_gain: float = 0.05,
        rate_gain: float = 2.0,
        rate_power_gain: float = 1e-3,
        power: float = 0.3,
        bound: Mapping[str, Any] | None = None,
        mirror: bool = False,
        margin: float = 0.05,
        attitude_filter_time: float = 1.0,
    ) -> None:
        super().__init__(
            scenario, num_spacecraft, faults=faults, observer=observer, attitude_filter_time=attitude_filter_time
        )
        self._attitude_gain = positive(attitude_gain, "attitude_gain")
        with fields_named("rate_", linear="rate_gain", exponent="power"):
            self._reaching = PowerReaching(rate_gain, rate_power_gain, power)
        self._error = PrescribedError(scenario, self.memory, bound, mirror, margin)

    @property
    def bound(self) -> PrescribedBound:
        """The bounds, not mirrored."""
        return self._error.bound

    def _slid(self, error: FloatArray, rate_error: FloatArray, transformed: Transformed) -> FloatArray:
        return rate_error - transformed.rate(error, -self._attitude_gain * transformed.error)

    def _variable(self, measurement: Measurement, error: FloatArray, rate_error: FloatArray) -> FloatArray:
        return self._slid(error, rate_error, self._error.peek(error, measurement.time)[0])

    def _acceleration(self, measurement: Measurement, error: FloatArray, rate_error: FloatArray) -> FloatArray:
        return self._reaching(self._slid(error, rate_error, self._error.update(error, measurement.time)))
