"""The fuzzy adaptive sliding-mode controller of Li, Xu and Chang 2023."""

from __future__ import annotations

from dataclasses import dataclass

from ftac_gym.baselines.components.relative_motion import RelativeMotion
from ftac_gym.baselines.components.rows import length
from ftac_gym.baselines.components.takagi_sugeno import TriangularSets
from ftac_gym.baselines.controllers.flexible import FlexibleController, ScheduledGains, scheduled_feedback
from ftac_gym.baselines.gains import Range, changed, parameter
from ftac_gym.task.measurement import Measurement
from ftac_gym.utils.parameters import FloatArray, flag, non_negative, positive


@dataclass(frozen=True)
class FuzzySMCGains(ScheduledGains):
    """Gains of :class:`FuzzySMC`."""

    faults: str = changed(ScheduledGains, "faults", "fafeo")
    feedback_share: float = parameter(1.0, "Factor on K_i", "", positive, Range(0.8, 40.0, log=True))
    linear: float = parameter(0.2, "sigma_1", "N m s/rad", non_negative)
    switching: float = parameter(0.15, "sigma_2", "N m", non_negative, Range(1e-4, 0.1, log=True))
    layer: float = parameter(1e-4, "sigma_2'", "rad/s", positive, Range(1e-4, 0.1, log=True))
    scheduled: bool = parameter(True, "Whether K_i is that of the active rules. Else their mean", rule=flag)


class FuzzySMC(FlexibleController):
    """Eqs. (39), (40), (64) of Li et al. 2023.

    ::

        torque = sum h_i K_i s - sigma_1 s - sigma_2 s / (|s| + layer) - g(s) - f^ - d^,  s = w_e + beta q_ev

    The blend of D_2i over the rules is exact inside their sector, so that d^ is the vibration torque itself.

    Raises
    ------
    ValueError
        If the spacecraft is rigid, a gain breaks a rule, or K_i leaves an unstable s for this spacecraft.
    """

    gains = FuzzySMCGains()

    def _build(self) -> None:
        super()._build()
        own = self.gains
        feedback = scheduled_feedback(self.scenario, own.design, own.feedback_share, own.scheduled)
        self._membership = TriangularSets()
        self._feedback = feedback.reshape(len(feedback), 9)

    def _torque(self, measurement: Measurement, motion: RelativeMotion, variable: FloatArray) -> FloatArray:
        gains = (self._membership(measurement.rate) @ self._feedback).reshape(-1, 3, 3)
        size = length(variable)
        torque: FloatArray = (gains @ variable[:, :, None])[:, :, 0]
        own = self.gains
        torque -= (own.linear + own.switching / (size + own.layer)) * variable
        return torque - self._nonlinear_torque(measurement, motion)
