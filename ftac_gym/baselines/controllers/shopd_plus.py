"""The saturated hybrid output feedback of Xia and Su 2018, comparator of Ma, Wang and Wang 2023."""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np

from ftac_gym.attitude import cross
from ftac_gym.baselines.components.reaching import saturation
from ftac_gym.baselines.controllers.hybrid import HybridController
from ftac_gym.baselines.gains import Range, SearchSpace
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, positive, require

STARTS = ("matched", "zero")
"""How the filter starts: with v = 0, or with q_c = 0."""


class SHOPDPlus(HybridController):
    """Proportional-derivative control without a rate: Eqs. (53)-(55) of Ma et al. 2023.

        u = -k4 h e_v - k5 (e_4 I + [e_v x])' sat(v) + (C w_d) x J C w_d + J C w_d'
        v = q_c + B e_v,  q_c' = -A v

    The second term has no h: its filter is driven by e_v. (55) is stepped exactly for an error held over the period.
    q_c(0) is not printed; with q_c(0) = 0 the torque starts with B e_v(0) in it, with v = 0 ("matched") without.

    Parameters
    ----------
    scenario, num_spacecraft
        As for every baseline.
    gain, damping
        k4, k5 [N m].
    filter_rate
        A [1/s], the same on each axis.
    filter_gain
        B, the same on each axis.
    filter_start
        One of :data:`STARTS`.
    hysteresis
        eta; not printed. None keeps h at 1, which unwinds.
    attitude_filter_time
        Time constant of the attitude filter [s]; zero for none. It uses the gyros, which the law itself does not.

    Raises
    ------
    ValueError
        If a gain breaks a rule.
    """

    search_space: ClassVar[SearchSpace] = {
        "gain": Range(0.05, 30.0, log=True),
        "damping": Range(0.05, 30.0, log=True),
        "filter_rate": Range(0.05, 5.0, log=True),
        "filter_gain": Range(0.5, 100.0, log=True),
        "attitude_filter_time": Range(0.0, 5.0),
    }

    def __init__(
        self,
        scenario: Scenario,
        num_spacecraft: int = 1,
        gain: float = 30.0,
        damping: float = 8.0,
        filter_rate: float = 1.0,
        filter_gain: float = 3.0,
        filter_start: str = "matched",
        hysteresis: float | None = 0.1,
        attitude_filter_time: float = 0.0,
    ) -> None:
        super().__init__(scenario, num_spacecraft, hysteresis, attitude_filter_time)
        self._gain, self._damping = positive(gain, "gain"), positive(damping, "damping")
        self._kept = math.exp(-positive(filter_rate, "filter_rate") * self._period)
        self._filter_gain = positive(filter_gain, "filter_gain")
        require(filter_start in STARTS, "filter_start", f"must be one of {list(STARTS)}", filter_start)
        self._matched = filter_start == "matched"
        self.memory.add("filter_state", (3,))
        self.memory.add("filter_started", (1,), initial=not self._matched)

    def torque_bound(self, rate: float = 0.0, acceleration: float = 0.0) -> float:
        """Return what no component of the torque exceeds [N m]: sqrt(k4^2 + 3 k5^2) + J_M (c1^2 + c2).

        The second term is at most k5 sqrt(3) sqrt(1 - e_i^2), since the rows of (e_4 I + [e_v x])' have the length
        sqrt(1 - e_i^2) and no component of sat exceeds one.

        Parameters
        ----------
        rate, acceleration
            c1 [rad/s] and c2 [rad/s^2], the largest magnitudes of the reference's rate and acceleration.
        """
        return math.hypot(self._gain, math.sqrt(3.0) * self._damping) + self._feed_forward_bound(rate, acceleration)

    def act(self, measurement: Measurement) -> FloatArray:
        """Return the wheel torques to command, (N, wheels) [N m]."""
        memory = self.memory
        motion = self._motion(self._filter.update(measurement), measurement, short_way=False)
        error, logic = self._hybrid.update(motion.error)
        axis = error[:, 1:]
        driven = self._filter_gain * axis
        state = np.where(memory["filter_started"], memory["filter_state"], -driven)
        value = state + driven
        held = saturation(value, 1.0)
        # (e_4 I + [e_v x])' v = e_4 v - e_v x v
        torque = -self._gain * logic * axis - self._damping * (error[:, :1] * held - cross(axis, held))
        if self._moving:
            torque = torque + self._feed_forward(motion, measurement)
        memory["filter_state"] = self._kept * value - driven
        memory["filter_started"] = np.ones_like(memory["filter_started"])
        return self._to_wheels(torque)
