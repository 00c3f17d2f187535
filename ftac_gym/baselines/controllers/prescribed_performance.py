"""Prescribed performance for a sampled spacecraft with small wheels."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from ftac_gym.baselines.components.error_transformation import Transformed
from ftac_gym.baselines.components.reaching import PowerReaching
from ftac_gym.baselines.controllers.prescribed import PrescribedError, PrescribedGains
from ftac_gym.baselines.controllers.relative import RelativeController, RelativeGains
from ftac_gym.baselines.gains import Range, changed, parameter
from ftac_gym.baselines.rules import interval
from ftac_gym.baselines.units import ACCELERATION, PER_LOOP, SPEED
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.prescribed_bound import PrescribedBound
from ftac_gym.utils.parameters import FloatArray, non_negative, positive

DECAY = 0.3409
"""Decay of the bounds [W], where the scenario prescribes none."""


@dataclass(frozen=True)
class PrescribedPerformanceGains(RelativeGains, PrescribedGains):
    """Gains of :class:`PrescribedPerformance`."""

    attitude_gain: float = parameter(0.4261, "k1", SPEED, positive, Range(0.085, 17.0, log=True))
    rate_gain: float = parameter(0.4, "k2", PER_LOOP, non_negative, Range(0.06, 1.6, log=True))
    rate_power_gain: float = parameter(
        0.03818, "tau2, at s = W", ACCELERATION, non_negative, Range(4e-3, 4.0, log=True)
    )
    power: float = parameter(0.3, "g", "", interval(0.0, 1.0))
    bound: Mapping[str, Any] | None = changed(
        PrescribedGains,
        "bound",
        unit={"decay": SPEED, "factor_decay": SPEED},
        search={
            "initial": Range(1.05, 10.0, log=True),
            "final": Range(1e-4, 0.3, log=True),
            "decay": Range(0.085, 4.3, log=True),
        },
    )
    margin: float = changed(PrescribedGains, "margin", 0.05, search=Range(1e-4, 0.3, log=True))


class PrescribedPerformance(RelativeController):
    """The error transformation of Chen et al. 2018 for sampled control.

    With epsilon, r and theta of :class:`~ftac_gym.baselines.components.error_transformation.ErrorTransformation` for
    the error MRP sigma_e, which is always on the short branch::

        a    = G^-1 r^-1 [-k1 epsilon - theta]
        s    = w_e - a
        w_e' = -k2 s - tau2 sig(s / W)^g

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
        own: PrescribedPerformanceGains = self.scheduled
        speed = self.scales.speed
        self._reaching = PowerReaching(own.rate_gain, own.rate_power_gain * speed**-own.power, own.power)
        if self.scenario.prescribed_bound is None:
            own = replace(own, bound={"decay": DECAY * speed, **(own.bound or {})})
        self._error = PrescribedError(self.scenario, self.memory, own)

    @property
    def bound(self) -> PrescribedBound:
        """The bounds, not mirrored."""
        return self._error.bound

    def _surface(self, error: FloatArray, rate_error: FloatArray, transformed: Transformed) -> FloatArray:
        return rate_error - transformed.rate(error, -self.scheduled.attitude_gain * transformed.error)

    def _variable(self, measurement: Measurement, error: FloatArray, rate_error: FloatArray) -> FloatArray:
        return self._surface(error, rate_error, self._error.peek(error, measurement.time)[0])

    def _acceleration(self, measurement: Measurement, error: FloatArray, rate_error: FloatArray) -> FloatArray:
        return self._reaching(self._surface(error, rate_error, self._error.update(error, measurement.time)))
