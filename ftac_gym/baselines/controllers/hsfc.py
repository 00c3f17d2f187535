"""The hybrid attitude saturation and fault-tolerant control of Ma, Wang and Wang 2023."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ftac_gym.baselines.components.reaching import saturation, soft_sign
from ftac_gym.baselines.components.rows import dot, length
from ftac_gym.baselines.controllers.hybrid import HybridController, HybridGains, Lifted
from ftac_gym.baselines.gains import Range, SearchSpace, parameter
from ftac_gym.baselines.rules import choice, interval
from ftac_gym.task.measurement import Measurement
from ftac_gym.utils.parameters import FloatArray, non_negative, positive

SMALLEST_GAMMA = 1e-100
"""Smallest g: its square is still a number, and S / (``|S|`` + g^2 delta) is zero at S = 0 instead of 0 / 0."""


@dataclass(frozen=True)
class HSFCGains(HybridGains):
    """Gains of :class:`HSFC`."""

    gain: float = parameter(5.0, "k", "N m", positive, Range(0.05, 10.0, log=True))
    attitude_gain: float = parameter(5.0, "k1, which acts through g' only", "", non_negative)
    adaptation: float = parameter(0.01, "alpha", "", non_negative, Range(1e-4, 1.0, log=True))
    smoothing: float = parameter(0.05, "delta", "", interval(0.0, 1.0), Range(1e-3, 0.9, log=True))
    smallest_effectiveness: float = parameter(0.2, "g0. One leaves u2 out", "", interval(0.0, 1.0, closed=True))
    compensation: str = parameter(
        "norm",
        "Form of the fault term u2",
        rule=choice("norm", "componentwise", "sliding"),
    )
    layer: float = parameter(0.005, "epsilon of the saturation function. Zero takes the sign", "rad/s", non_negative)
    initial_gamma: float = parameter(
        2.5, "g(0)", "(rad/s)^(1/2)", interval(0.0, 1.0 / SMALLEST_GAMMA), Range(0.1, 2.5, log=True)
    )
    gamma_floor: float = parameter(0.0, "Lower bound of g", "", non_negative, Range(0.1, 1.5, log=True))


class _Errors(NamedTuple):
    """h e_v, w_e and S (N, 3), h e_4 (N, 1)."""

    turn: FloatArray
    scalar: FloatArray
    rate: FloatArray
    variable: FloatArray


class HSFC(HybridController):
    """Eqs. (14)-(20), (43), corrected.

    With the error quaternion (e_v, e_4), the logic variable h and the adaptive gain g ("gamma")::

        S    = w_e + h g^2 e_v
        u1_i = -k S_i / (|S_i| + g^2 delta) + [(C w_d) x J C w_d + J C w_d']_i
        u2_i = -(1 - g0)/g0 |u1| sat(w_e,i / layer)
        g'   = alpha g / (1 + 2 alpha k1 (1 - h e_4))
               { k sum_i [h e_i w_e,i / (|S_i| + g^2 delta) - |w_e,i| (1 + delta) / (|w_e,i| + g^2 (1 + delta))]
                 - k1/2 h e_v'S }
        u    = u1 + u2

    (18) is meant component by component. (19) uses the norm ``|u1|``, which makes u2 a brake that overrules u1 wherever
    (1 - g0)/g0 ``|u1|`` > ``|u1_i|``: the body then creeps with rates within the layer. ``"componentwise"`` takes
    ``|u1_i|``, with which the bound (21) holds as well; ``"sliding"`` takes sat(S_i / layer) for sat(w_e,i / layer).

    The paper also lists a gain k2, which occurs nowhere.

    g stays positive, above 1e-100. It is stepped as g exp(T g'/g), which is exact while g'/g is constant.
    g can go to zero, and the attitude feedback with it: V of the paper's proof vanishes for g = 0, w_e = 0 and any
    attitude. ``gamma_floor`` is the smallest change that prevents this.
    """

    gains = HSFCGains()

    def _build(self) -> None:
        super()._build()
        effectiveness = self.gains.smallest_effectiveness
        self._share = (1.0 - effectiveness) / effectiveness
        self._floor = max(self.gains.gamma_floor, SMALLEST_GAMMA)
        self.memory.add("gamma", (1,), initial=max(self.gains.initial_gamma, self._floor))

    @classmethod
    def space(cls, **gains: Any) -> SearchSpace:
        """Return the ranges that a tuner searches: that of the floor only for a variant with a floor."""
        return {name: item for name, item in cls.search_space.items() if name != "gamma_floor" or name in gains}

    def torque_bound(self, rate: float = 0.0, acceleration: float = 0.0) -> float:
        """Return the bound of every component of the torque [N m], for all errors.

        With f = J_M (c1^2 + c2), ``|u1_i|`` <= k + f and ``|u1|`` <= sqrt(3) k + f, hence
        k + f + (1 - g0)/g0 (sqrt(3) k + f); printed is (k + f)/g0, Eq. (21), which holds for ``"componentwise"``.

        Parameters
        ----------
        rate, acceleration
            c1 [rad/s] and c2 [rad/s^2], the largest magnitudes of the reference's rate and acceleration.
        """
        follow = self._feed_forward_bound(rate, acceleration)
        counted = 1.0 if self.gains.compensation == "componentwise" else math.sqrt(3.0)
        gain = self.gains.gain
        return gain + follow + self._share * (counted * gain + follow)

    def _errors(self, lifted: Lifted) -> _Errors:
        turned = lifted.logic * lifted.error
        turn, rate = turned[:, 1:], lifted.motion.rate_error
        return _Errors(turn, turned[:, :1], rate, rate + self.memory["gamma"] ** 2 * turn)

    def sliding_variable(self, measurement: Measurement) -> FloatArray:
        """Return S (N, 3) [rad/s] at a measurement, for its unfiltered attitude."""
        return self._errors(self._lifted(measurement, move_on=False)).variable

    def act(self, measurement: Measurement) -> FloatArray:
        """Return the wheel torques to command, (N, wheels) [N m]."""
        lifted = self._lifted(measurement, move_on=True)
        errors = self._errors(lifted)
        soft = self.memory["gamma"] ** 2 * self.gains.smoothing
        torque = -self.gains.gain * soft_sign(errors.variable, soft)
        if self._moving:
            torque = torque + self._feed_forward(lifted.motion, measurement)
        if self._share > 0.0:
            torque = torque - self._share * self._fault_torque(torque, errors)
        self._adapt(errors, soft)
        return self._to_wheels(torque)

    def _fault_torque(self, torque: FloatArray, errors: _Errors) -> FloatArray:
        """Return -u2 g0 / (1 - g0) (N, 3) [N m] for u1 (N, 3)."""
        if self.gains.compensation == "componentwise":
            return np.abs(torque) * saturation(errors.rate, self.gains.layer)
        along = errors.rate if self.gains.compensation == "norm" else errors.variable
        norm = length(torque)
        return norm * saturation(along, self.gains.layer)

    def _adapt(self, errors: _Errors, soft: FloatArray) -> None:
        """Move the adaptive gain on by one period."""
        own, gamma = self.gains, self.memory["gamma"]
        speed = np.abs(errors.rate)
        far = gamma**2 * (1.0 + own.smoothing)
        closing = errors.turn * errors.rate / (np.abs(errors.variable) + soft)
        each = closing - speed * (1.0 + own.smoothing) / (speed + far)
        along = dot(errors.turn, errors.variable)
        drive = own.gain * each.sum(axis=1, keepdims=True) - 0.5 * own.attitude_gain * along
        weight = own.adaptation / (1.0 + (2.0 * own.adaptation * own.attitude_gain) * (1.0 - errors.scalar))
        self.memory["gamma"] = np.maximum(gamma * np.exp(self._period * weight * drive), self._floor)
