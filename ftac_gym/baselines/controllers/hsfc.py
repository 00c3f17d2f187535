"""The hybrid attitude saturation and fault-tolerant control of Ma, Wang and Wang 2023."""

from __future__ import annotations

import math
from typing import Any, ClassVar, NamedTuple

import numpy as np

from ftac_gym.baselines.components.reaching import saturation, soft_sign
from ftac_gym.baselines.components.relative_motion import RelativeMotion
from ftac_gym.baselines.controllers.hybrid import HybridController
from ftac_gym.baselines.gains import Range, SearchSpace
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, finite, non_negative, positive, require, within

COMPENSATIONS = ("norm", "componentwise", "sliding")
"""Forms of the fault term: as printed; with each component's own |u1_i|; along S instead of w_e."""


SMALLEST_GAMMA = 1e-100
"""Its square is still a number, and S / (|S| + g^2 delta) zero where S is, instead of 0 / 0."""


class _Errors(NamedTuple):
    """h e_v, w_e and S (N, 3), h e_4 (N, 1)."""

    turn: FloatArray
    scalar: FloatArray
    rate: FloatArray
    variable: FloatArray


class HSFC(HybridController):
    """Eqs. (14)-(20), (43), corrected.

    With the error quaternion (e_v, e_4), the logic variable h and the adaptive gain g ("gamma"):

        S    = w_e + h g^2 e_v
        u1_i = -k S_i / (|S_i| + g^2 delta) + [(C w_d) x J C w_d + J C w_d']_i
        u2_i = -(1 - g0)/g0 |u1| sat(w_e,i / layer)
        g'   = alpha g / (1 + 2 alpha k1 (1 - h e_4))
               { k sum_i [h e_i w_e,i / (|S_i| + g^2 delta) - |w_e,i| (1 + delta) / (|w_e,i| + g^2 (1 + delta))]
                 - k1/2 h e_v'S }
        u    = u1 + u2

    (18) is meant component by component. (19) uses the norm |u1|, which makes u2 a brake that overrules u1 wherever
    (1 - g0)/g0 |u1| > |u1_i|: the body then creeps with rates within the layer. ``"componentwise"`` takes |u1_i|, with
    which the bound (21) is right, too; ``"sliding"`` takes sat(S_i / layer) for sat(w_e,i / layer).

    g stays positive, above 1e-100 in numbers: it is stepped as g exp(T g'/g), which is exact while g'/g is constant.
    Nothing keeps g from going to zero, and with it the wish to turn at all: V of the paper's proof vanishes for g = 0,
    w_e = 0 and any attitude. ``gamma_floor`` is the one line that mends this.

    Parameters
    ----------
    scenario, num_spacecraft
        As for every baseline.
    gain
        k [N m].
    attitude_gain
        k1; it only acts through g'. The paper also lists a k2, which occurs nowhere.
    adaptation
        alpha.
    smoothing
        delta, within (0, 1) as the paper says.
    smallest_effectiveness
        g0, within (0, 1]; 1 leaves u2 out.
    compensation
        One of :data:`COMPENSATIONS`.
    layer
        epsilon of the saturation function [rad/s]; zero takes the sign.
    initial_gamma
        g(0) [(rad/s)^(1/2)].
    gamma_floor
        g is kept at or above this; zero is the print.
    hysteresis
        eta; not printed. None keeps h at 1, which unwinds.
    attitude_filter_time
        Time constant of the attitude filter [s]; zero for none.

    Raises
    ------
    ValueError
        If a gain breaks a rule.
    """

    search_space: ClassVar[SearchSpace] = {
        "gain": Range(0.05, 10.0, log=True),
        "adaptation": Range(1e-4, 1.0, log=True),
        "smoothing": Range(1e-3, 0.9, log=True),
        "initial_gamma": Range(0.1, 2.5, log=True),
        "gamma_floor": Range(0.1, 1.5, log=True),
        "attitude_filter_time": Range(0.0, 5.0),
    }

    def __init__(
        self,
        scenario: Scenario,
        num_spacecraft: int = 1,
        gain: float = 5.0,
        attitude_gain: float = 5.0,
        adaptation: float = 0.01,
        smoothing: float = 0.05,
        smallest_effectiveness: float = 0.2,
        compensation: str = "norm",
        layer: float = 0.005,
        initial_gamma: float = 2.5,
        gamma_floor: float = 0.0,
        hysteresis: float | None = 0.1,
        attitude_filter_time: float = 0.0,
    ) -> None:
        super().__init__(scenario, num_spacecraft, hysteresis, attitude_filter_time)
        self._gain = positive(gain, "gain")
        self._attitude_gain = non_negative(attitude_gain, "attitude_gain")
        self._adaptation = non_negative(adaptation, "adaptation")
        self._smoothing = within(smoothing, 0.0, 1.0, "smoothing")
        effectiveness = finite(smallest_effectiveness, "smallest_effectiveness")
        require(0.0 < effectiveness <= 1.0, "smallest_effectiveness", "must lie within (0, 1]", smallest_effectiveness)
        require(compensation in COMPENSATIONS, "compensation", f"must be one of {list(COMPENSATIONS)}", compensation)
        self._share = (1.0 - effectiveness) / effectiveness
        self._compensation = compensation
        self._layer = non_negative(layer, "layer")
        self._floor = max(non_negative(gamma_floor, "gamma_floor"), SMALLEST_GAMMA)
        start = max(within(initial_gamma, 0.0, 1.0 / SMALLEST_GAMMA, "initial_gamma"), self._floor)
        self.memory.add("gamma", (1,), initial=start)

    @classmethod
    def space(cls, **gains: Any) -> SearchSpace:
        """Return where a tuner looks: for a floor only in the variant that has one."""
        return {name: item for name, item in cls.search_space.items() if name != "gamma_floor" or name in gains}

    def torque_bound(self, rate: float = 0.0, acceleration: float = 0.0) -> float:
        """Return what no component of the torque exceeds [N m], whatever the errors.

        With f = J_M (c1^2 + c2), |u1_i| <= k + f and |u1| <= sqrt(3) k + f, hence
        k + f + (1 - g0)/g0 (sqrt(3) k + f); printed is (k + f)/g0, Eq. (21), which holds for ``"componentwise"``.

        Parameters
        ----------
        rate, acceleration
            c1 [rad/s] and c2 [rad/s^2], the largest magnitudes of the reference's rate and acceleration.
        """
        follow = self._feed_forward_bound(rate, acceleration)
        counted = 1.0 if self._compensation == "componentwise" else math.sqrt(3.0)
        return self._gain + follow + self._share * (counted * self._gain + follow)

    def _errors(self, motion: RelativeMotion, lifted: tuple[FloatArray, FloatArray]) -> _Errors:
        error, logic = lifted
        turned = logic * error
        turn = turned[:, 1:]
        return _Errors(turn, turned[:, :1], motion.rate_error, motion.rate_error + self.memory["gamma"] ** 2 * turn)

    def sliding_variable(self, measurement: Measurement) -> FloatArray:
        """Return S (N, 3) [rad/s] at a measurement, for its unfiltered attitude."""
        motion = self._motion(measurement.attitude, measurement, short_way=False)
        return self._errors(motion, self._hybrid.peek(motion.error)).variable

    def act(self, measurement: Measurement) -> FloatArray:
        """Return the wheel torques to command, (N, wheels) [N m]."""
        motion = self._motion(self._filter.update(measurement), measurement, short_way=False)
        errors = self._errors(motion, self._hybrid.update(motion.error))
        soft = self.memory["gamma"] ** 2 * self._smoothing
        torque = -self._gain * soft_sign(errors.variable, soft)
        if self._moving:
            torque = torque + self._feed_forward(motion, measurement)
        if self._share > 0.0:
            torque = torque - self._share * self._fault_torque(torque, errors)
        self._adapt(errors, soft)
        return self._to_wheels(torque)

    def _fault_torque(self, torque: FloatArray, errors: _Errors) -> FloatArray:
        """Return -u2 g0 / (1 - g0) (N, 3) [N m] for u1 (N, 3)."""
        if self._compensation == "componentwise":
            componentwise: FloatArray = np.abs(torque) * saturation(errors.rate, self._layer)
            return componentwise
        along = errors.rate if self._compensation == "norm" else errors.variable
        norm = np.sqrt(np.einsum("ni,ni->n", torque, torque))[:, None]
        braking: FloatArray = norm * saturation(along, self._layer)
        return braking

    def _adapt(self, errors: _Errors, soft: FloatArray) -> None:
        """Move the adaptive gain on by one period."""
        gamma = self.memory["gamma"]
        speed = np.abs(errors.rate)
        far = gamma**2 * (1.0 + self._smoothing)
        closing = errors.turn * errors.rate / (np.abs(errors.variable) + soft)
        each = closing - speed * (1.0 + self._smoothing) / (speed + far)
        along = np.einsum("ni,ni->n", errors.turn, errors.variable)[:, None]
        drive = self._gain * each.sum(axis=1, keepdims=True) - 0.5 * self._attitude_gain * along
        weight = self._adaptation / (1.0 + (2.0 * self._adaptation * self._attitude_gain) * (1.0 - errors.scalar))
        self.memory["gamma"] = np.maximum(gamma * np.exp(self._period * weight * drive), self._floor)
