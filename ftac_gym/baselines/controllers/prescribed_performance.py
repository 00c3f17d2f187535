"""Prescribed performance for a sampled spacecraft with small wheels."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ftac_gym.baselines.components.error_transformation import Transformed
from ftac_gym.baselines.components.reaching import PowerReaching
from ftac_gym.baselines.controllers.prescribed import PrescribedError, PrescribedGains
from ftac_gym.baselines.controllers.relative import RelativeController, RelativeGains
from ftac_gym.baselines.gains import Range, changed, parameter
from ftac_gym.baselines.rules import interval
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.prescribed_bound import PrescribedBound
from ftac_gym.utils.parameters import FloatArray, non_negative, positive


@dataclass(frozen=True)
class PrescribedPerformanceGains(RelativeGains, PrescribedGains):
    """Gains of :class:`PrescribedPerformance`."""

    attitude_gain: float = parameter(0.05, "k1", "1/s", positive, Range(0.01, 2.0, log=True))
    rate_gain: float = parameter(2.0, "k2", "1/s", non_negative, Range(0.3, 8.0, log=True))
    rate_power_gain: float = parameter(1e-3, "tau2", "", non_negative, Range(1e-4, 0.1, log=True))
    power: float = parameter(0.3, "g", "", interval(0.0, 1.0))
    bound: Mapping[str, Any] | None = changed(
        PrescribedGains,
        "bound",
        search={
            "initial": Range(1.05, 10.0, log=True),
            "final": Range(1e-4, 0.3, log=True),
            "decay": Range(0.01, 0.5, log=True),
        },
    )
    margin: float = changed(PrescribedGains, "margin", 0.05, search=Range(1e-4, 0.3, log=True))


class PrescribedPerformance(RelativeController):
    """The error transformation of Chen et al. 2018 for sampled control at about 10 Hz.

    With epsilon, r and theta of :class:`~ftac_gym.baselines.components.error_transformation.ErrorTransformation` for
    the error MRP sigma_e, which is always on the short branch::

        a    = G^-1 r^-1 [-k1 epsilon - theta]
        s    = w_e - a
        w_e' = -k2 s - tau2 sig(s)^g

    Differences from the paper's law, with reasons:

    - No command filter: sampled, it destabilises the loop; the paper's law does not use the derivative either.
    - The bounds are the same on both sides, so that epsilon = 0 is sigma_e = 0. They are wide enough at the start for
      every attitude, unless the scenario prescribes others.
    - The gyroscopic torque and the reference's motion are fed forward; there is no fuzzy system.

    Raises
    ------
    ValueError
        If a gain breaks a rule; ``act`` if a spacecraft starts outside its bounds.
    """

    gains = PrescribedPerformanceGains()

    def _build(self) -> None:
        super()._build()
        own = self.gains
        self._reaching = PowerReaching(own.rate_gain, own.rate_power_gain, own.power)
        self._error = PrescribedError(self.scenario, self.memory, own)

    @property
    def bound(self) -> PrescribedBound:
        """The bounds, not mirrored."""
        return self._error.bound

    def _surface(self, error: FloatArray, rate_error: FloatArray, transformed: Transformed) -> FloatArray:
        return rate_error - transformed.rate(error, -self.gains.attitude_gain * transformed.error)

    def _variable(self, measurement: Measurement, error: FloatArray, rate_error: FloatArray) -> FloatArray:
        return self._surface(error, rate_error, self._error.peek(error, measurement.time)[0])

    def _acceleration(self, measurement: Measurement, error: FloatArray, rate_error: FloatArray) -> FloatArray:
        return self._reaching(self._surface(error, rate_error, self._error.update(error, measurement.time)))
