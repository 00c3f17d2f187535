"""The fuzzy adaptive sliding-mode controller of Li, Xu and Chang 2023."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from ftac_gym.baselines.components.relative_motion import RelativeMotion
from ftac_gym.baselines.components.takagi_sugeno import TriangularSets
from ftac_gym.baselines.controllers.flexible import FlexibleController, scheduled_feedback
from ftac_gym.baselines.gains import Range, SearchSpace
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, non_negative, positive


class FuzzySMC(FlexibleController):
    """Eqs. (39), (40), (64) of Li et al. 2023.

        torque = sum h_i K_i s - sigma_1 s - sigma_2 s / (|s| + layer) - g(s) - f^ - d^,  s = w_e + beta q_ev

    The blend of D_2i over the rules is exact inside their sector, so that d^ is the vibration torque itself.

    Parameters
    ----------
    scenario, num_spacecraft
        As for every baseline.
    faults, observer
        See :class:`~ftac_gym.baselines.controllers.fault_tolerant.FaultTolerantController`.
    design
        Where K_i [N m s/rad] is from: ``"published"`` (the paper's appendix) or ``"solved"`` (its matrix inequalities
        for this spacecraft).
    feedback_share
        Factor on K_i.
    slope
        beta [rad/s].
    linear, switching, layer
        sigma_1 [N m s/rad], sigma_2 [N m], sigma_2' [rad/s].
    scheduled
        Whether K_i is that of the rules that fire; else it is the mean of all, at any rate.
    limit, short_way, attitude_filter_time
        See :class:`~ftac_gym.baselines.controllers.flexible.FlexibleController`.

    Raises
    ------
    ValueError
        If the spacecraft is rigid, a gain breaks a rule, or K_i leaves an unstable s for this spacecraft.
    """

    search_space: ClassVar[SearchSpace] = {
        "feedback_share": Range(0.8, 40.0, log=True),
        "slope": Range(0.05, 2.0, log=True),
        "switching": Range(1e-4, 0.1, log=True),
        "layer": Range(1e-4, 0.1, log=True),
        "attitude_filter_time": Range(0.0, 5.0),
    }

    def __init__(
        self,
        scenario: Scenario,
        num_spacecraft: int = 1,
        faults: str = "fafeo",
        observer: Mapping[str, Any] | None = None,
        design: str = "solved",
        feedback_share: float = 1.0,
        slope: float = 2.0,
        linear: float = 0.2,
        switching: float = 0.15,
        layer: float = 1e-4,
        scheduled: bool = True,
        limit: str = "each",
        short_way: bool = True,
        attitude_filter_time: float = 0.0,
    ) -> None:
        super().__init__(scenario, num_spacecraft, faults, observer, slope, limit, short_way, attitude_filter_time)
        share = positive(feedback_share, "feedback_share")
        feedback = scheduled_feedback(scenario, design, share, scheduled)
        self._membership = TriangularSets()
        self._feedback = feedback.reshape(len(feedback), 9)
        self._linear = non_negative(linear, "linear")
        self._switching = non_negative(switching, "switching")
        self._layer = positive(layer, "layer")

    def _torque(self, measurement: Measurement, motion: RelativeMotion, variable: FloatArray) -> FloatArray:
        gains = (self._membership(measurement.rate) @ self._feedback).reshape(-1, 3, 3)
        size = np.sqrt(np.einsum("ni,ni->n", variable, variable))[:, None]
        torque: FloatArray = (gains @ variable[:, :, None])[:, :, 0]
        torque -= (self._linear + self._switching / (size + self._layer)) * variable
        return torque - self._nonlinear_torque(measurement, motion)
