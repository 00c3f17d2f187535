"""The saturated hybrid output feedback of Xia and Su 2018, comparator of Ma, Wang and Wang 2023."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ftac_gym.attitude import cross
from ftac_gym.baselines.components.reaching import saturation
from ftac_gym.baselines.controllers.hybrid import HybridController, HybridGains
from ftac_gym.baselines.gains import Range, parameter
from ftac_gym.baselines.rules import choice
from ftac_gym.task.measurement import Measurement
from ftac_gym.utils.parameters import FloatArray, positive


@dataclass(frozen=True)
class SHOPDPlusGains(HybridGains):
    """Gains of :class:`SHOPDPlus`."""

    gain: float = parameter(30.0, "k4", "N m", positive, Range(0.05, 30.0, log=True))
    damping: float = parameter(8.0, "k5", "N m", positive, Range(0.05, 30.0, log=True))
    filter_rate: float = parameter(1.0, "A, the same on each axis", "1/s", positive, Range(0.05, 5.0, log=True))
    filter_gain: float = parameter(3.0, "B, the same on each axis", "", positive, Range(0.5, 100.0, log=True))
    filter_start: str = parameter("matched", "Start of the filter: v = 0, or q_c = 0", rule=choice("matched", "zero"))


class SHOPDPlus(HybridController):
    """Proportional-derivative control without a rate: Eqs. (53)-(55) of Ma et al. 2023.

    ::

        u = -k4 h e_v - k5 (e_4 I + [e_v x])' sat(v) + (C w_d) x J C w_d + J C w_d'
        v = q_c + B e_v,  q_c' = -A v

    The second term has no h: its filter is driven by e_v. (55) is stepped exactly for an error held over the period.
    q_c(0) is not printed; with q_c(0) = 0 the torque starts with B e_v(0) in it, with v = 0 ("matched") without.
    The attitude filter uses the gyros, which the law itself does not.
    """

    gains = SHOPDPlusGains()

    def _build(self) -> None:
        super()._build()
        self._decay = math.exp(-self.gains.filter_rate * self._period)
        self.memory.add("filter_state", (3,))
        self.memory.add("filter_started", (1,), initial=self.gains.filter_start == "zero")

    def torque_bound(self, rate: float = 0.0, acceleration: float = 0.0) -> float:
        """Return the bound of every component of the torque [N m]: sqrt(k4^2 + 3 k5^2) + J_M (c1^2 + c2).

        The second term is at most k5 sqrt(3) sqrt(1 - e_i^2). The rows of (e_4 I + [e_v x])' have the length
        sqrt(1 - e_i^2), and no component of sat exceeds one.

        Parameters
        ----------
        rate, acceleration
            c1 [rad/s] and c2 [rad/s^2], the largest magnitudes of the reference's rate and acceleration.
        """
        return math.hypot(self.gains.gain, math.sqrt(3.0) * self.gains.damping) + self._feed_forward_bound(
            rate, acceleration
        )

    def act(self, measurement: Measurement) -> FloatArray:
        """Return the wheel torques to command, (N, wheels) [N m]."""
        memory = self.memory
        motion, error, logic = self._lifted(measurement, move_on=True)
        axis = error[:, 1:]
        driven = self.gains.filter_gain * axis
        state = np.where(memory["filter_started"], memory["filter_state"], -driven)
        value = state + driven
        held = saturation(value, 1.0)
        # (e_4 I + [e_v x])' v = e_4 v - e_v x v
        torque = -self.gains.gain * logic * axis - self.gains.damping * (error[:, :1] * held - cross(axis, held))
        if self._moving:
            torque = torque + self._feed_forward(motion, measurement)
        memory["filter_state"] = self._decay * value - driven
        memory["filter_started"] = np.ones_like(memory["filter_started"])
        return self._to_wheels(torque)
