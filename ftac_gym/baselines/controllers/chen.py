"""Base of the schemes of Chen et al. 2018: the attitude error in MRPs, on either branch."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ftac_gym.baselines.components.double_cover import HybridError
from ftac_gym.baselines.controllers.direct import DirectController
from ftac_gym.baselines.gains import Range, parameter
from ftac_gym.baselines.observers.attitude_filter import AttitudeFilterGains
from ftac_gym.task.measurement import Measurement
from ftac_gym.utils.parameters import FloatArray, flag, non_negative, positive


@dataclass(frozen=True)
class ChenGains(AttitudeFilterGains):
    """Gains of :class:`ChenController`."""

    shadow_switch: bool = parameter(True, "Whether sigma changes to its shadow beyond 180 degrees", rule=flag)


@dataclass(frozen=True)
class ChenFuzzyGains(ChenGains):
    """Gains of the backstepping with a fuzzy system, of M1 and M2."""

    attitude_gain: float = parameter(0.1, "k1", "1/s", positive, Range(0.01, 1.0, log=True))
    rate_gain: float = parameter(0.8, "k2", "1/s", positive, Range(0.2, 8.0, log=True))
    fuzzy_width: float = parameter(0.5, "h", "", positive)
    fuzzy_gain: float = parameter(2.0, "lambda. Zero for no fuzzy system", "", non_negative)
    fuzzy_leak: float = parameter(0.001, "m1", "1/s", non_negative)


class ChenController(DirectController):
    """A controller on sigma of the attitude error and w, for a reference at rest.

    With ``shadow_switch`` sigma changes to its shadow, -sigma/``|sigma|^2``, beyond 180 degrees. Without it sigma
    starts with the sign of the quaternion and goes to zero from there, from beyond 180 degrees the long way round. It
    is then infinite at 360 degrees.

    Raises
    ------
    ValueError
        If the reference moves, or a gain breaks a rule.
    """

    gains = ChenGains()
    rest_only: ClassVar[str] = "this law has no term for a reference rate"

    def _build(self) -> None:
        super()._build()
        self._hybrid = None if self.gains.shadow_switch else HybridError(self.memory, None)

    def _sigma(self, measurement: Measurement, move_on: bool) -> FloatArray:
        """Return sigma (N, 3) of the rotation from the reference; the memory changes only if it moves on."""
        error = self._motion(measurement, move_on, short_way=self._hybrid is None).error
        if self._hybrid is not None:
            error, _ = self._hybrid.update(error) if move_on else self._hybrid.peek(error)
        # At 360 degrees, where sigma is infinite, the direction is that of rounding errors.
        return error[:, 1:] / np.maximum(1.0 + error[:, :1], 1e-12)
