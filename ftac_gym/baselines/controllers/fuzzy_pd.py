"""PD control with the fuzzy observer: the first comparator of Li, Xu and Chang 2023."""

from __future__ import annotations

from dataclasses import dataclass

from ftac_gym.baselines.components.relative_motion import RelativeMotion
from ftac_gym.baselines.controllers.flexible import FlexibleController, FlexibleGains
from ftac_gym.baselines.gains import Range, changed, parameter
from ftac_gym.baselines.rules import choice
from ftac_gym.task.measurement import Measurement
from ftac_gym.utils.parameters import FloatArray, positive


@dataclass(frozen=True)
class FuzzyPDGains(FlexibleGains):
    """Gains of :class:`FuzzyPD`."""

    faults: str = changed(FlexibleGains, "faults", "fafeo")
    position_gain: float = parameter(20.0, "k_p", "N m", positive, Range(0.1, 500.0, log=True))
    rate_gain: float = parameter(60.0, "k_d", "N m s", positive, Range(1.0, 1000.0, log=True))
    compensation: str = parameter("printed", "Compensated terms", rule=choice("printed", "gyroscopic"))


class FuzzyPD(FlexibleController):
    """Eq. (69) of Li et al. 2023: torque = -k_p q_ev - k_d w_e - f^ - d^ - (the compensated terms).

    Printed, all of g(s) is compensated, which adds (J - delta' delta) beta / 2 to the damping: with the paper's numbers
    three to five times k_d. The gyroscopic variant compensates w x J w and the acceleration of the reference alone.
    """

    gains = FuzzyPDGains()

    def _torque(self, measurement: Measurement, motion: RelativeMotion, variable: FloatArray) -> FloatArray:
        torque = -self.gains.position_gain * motion.error[:, 1:] - self.gains.rate_gain * motion.rate_error
        if self.gains.compensation == "printed":
            return torque - self._nonlinear_torque(measurement, motion)
        return torque + self._gyroscopic_torque(measurement, motion)
