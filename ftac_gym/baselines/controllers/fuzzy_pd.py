"""PD control on the fuzzy observer: the first comparator of Li, Xu and Chang 2023."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from ftac_gym.baselines.components.relative_motion import RelativeMotion
from ftac_gym.baselines.controllers.flexible import FlexibleController
from ftac_gym.baselines.gains import Range, SearchSpace
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, positive, require

COMPENSATIONS = ("printed", "gyroscopic")


class FuzzyPD(FlexibleController):
    """Eq. (69) of Li et al. 2023: torque = -k_p q_ev - k_d w_e - f^ - d^ - (what is compensated).

    Printed, all of g(s) is compensated, which adds (J - delta' delta) beta / 2 to the damping: with the paper's numbers
    three to five times k_d. The gyroscopic variant takes off w x J w and the acceleration of the reference alone.

    Parameters
    ----------
    scenario, num_spacecraft
        As for every baseline.
    faults, observer
        See :class:`~ftac_gym.baselines.controllers.fault_tolerant.FaultTolerantController`.
    position_gain, rate_gain
        k_p [N m] and k_d [N m s].
    compensation
        ``"printed"`` or ``"gyroscopic"``.
    slope
        beta of g(s) [rad/s].
    limit, short_way, attitude_filter_time
        See :class:`~ftac_gym.baselines.controllers.flexible.FlexibleController`.

    Raises
    ------
    ValueError
        If a gain breaks a rule.
    """

    search_space: ClassVar[SearchSpace] = {
        "position_gain": Range(0.1, 500.0, log=True),
        "rate_gain": Range(1.0, 1000.0, log=True),
        "attitude_filter_time": Range(0.0, 5.0),
    }

    def __init__(
        self,
        scenario: Scenario,
        num_spacecraft: int = 1,
        faults: str = "fafeo",
        observer: Mapping[str, Any] | None = None,
        position_gain: float = 20.0,
        rate_gain: float = 60.0,
        compensation: str = "printed",
        slope: float = 2.0,
        limit: str = "each",
        short_way: bool = True,
        attitude_filter_time: float = 0.0,
    ) -> None:
        super().__init__(scenario, num_spacecraft, faults, observer, slope, limit, short_way, attitude_filter_time)
        require(compensation in COMPENSATIONS, "compensation", f"must be one of {list(COMPENSATIONS)}", compensation)
        self._position_gain = positive(position_gain, "position_gain")
        self._rate_gain = positive(rate_gain, "rate_gain")
        self._whole = compensation == "printed"

    def _torque(self, measurement: Measurement, motion: RelativeMotion, variable: FloatArray) -> FloatArray:
        torque = -self._position_gain * motion.error[:, 1:] - self._rate_gain * motion.rate_error
        if self._whole:
            return torque - self._nonlinear_torque(measurement, motion)
        return torque + self._gyroscopic_torque(measurement, motion)
