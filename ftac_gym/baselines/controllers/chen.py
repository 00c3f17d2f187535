"""What the schemes of Chen et al. 2018 share: the attitude error in MRPs, on either branch."""

from __future__ import annotations

import numpy as np

from ftac_gym.baselines.components.double_cover import HybridError
from ftac_gym.baselines.controllers.direct import DirectController
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, require


class ChenController(DirectController):
    """A law on sigma of the attitude error and w, for a reference at rest.

    Parameters
    ----------
    scenario, num_spacecraft
        As for every baseline.
    shadow_switch
        Whether sigma changes to its shadow, -sigma/|sigma|^2, beyond 180 degrees. Without, sigma starts as the
        quaternion does and goes to zero from there, the long way round from beyond; infinite at 360 degrees.
    attitude_filter_time
        Time constant of the attitude filter [s]; zero uses the star tracker as it comes.

    Raises
    ------
    ValueError
        If the reference moves, or a gain breaks a rule.
    """

    def __init__(
        self, scenario: Scenario, num_spacecraft: int, shadow_switch: bool, attitude_filter_time: float
    ) -> None:
        rule = "must be at rest: this law has no term for a reference rate"
        require(not scenario.reference.moving, "reference", rule, type(scenario.reference).__name__)
        super().__init__(scenario, num_spacecraft, attitude_filter_time)
        self._hybrid = None if shadow_switch else HybridError(self.memory, None)

    def _sigma(self, attitude: FloatArray, measurement: Measurement, move_on: bool) -> FloatArray:
        """Return sigma (N, 3) of the rotation from the reference to an attitude (N, 4)."""
        error = self._motion(attitude, measurement, short_way=self._hybrid is None).error
        if self._hybrid is not None:
            error, _ = self._hybrid.update(error) if move_on else self._hybrid.peek(error)
        # At 360 degrees, where sigma is infinite, the direction is that of rounding errors.
        sigma: FloatArray = error[:, 1:] / np.maximum(1.0 + error[:, :1], 1e-12)
        return sigma
