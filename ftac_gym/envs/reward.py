"""The reward: a sum of named terms, computed from the true state.

With theta the true pointing error [rad], w_e the true rate error, u the wheel commands over their limits:

================ ===========================================================================================
``progress``     weight (theta before - theta): over an episode it only counts where the craft ends
``precision``    - weight log10(1 + theta / (cone / 5)): every decade of pointing error counts the same
``rate``         - weight |w_e|^2
``effort``       - weight mean(u^2)
``smoothness``   - weight mean((u - u before)^2)
``on_target``    weight, while inside the success cone and slow
``tumble``       - weight, once, when the episode ends by tumbling
``vibration``    - weight times the energy of the vibration modes [J]
================ ===========================================================================================
"""

from __future__ import annotations

import dataclasses
import math
from functools import reduce
from operator import add
from typing import Any

import numpy as np
import numpy.typing as npt
from numba import njit

from ftac_gym.dynamics import Simulator
from ftac_gym.task.objective import RewardWeights
from ftac_gym.task.scenario import success_steps
from ftac_gym.utils.parameters import FloatArray

TERMS = ("progress", "precision", "rate", "effort", "smoothness", "on_target", "tumble", "vibration")


def total(terms: Any) -> Any:
    """Return the sum of terms, numbers or arrays (N,), added in their order, which NumPy's sum is not for one craft."""
    return reduce(add, terms)


class Reward:
    """Rewards of N craft; its state is the last error and command, and how long each craft has been on target.

    Parameters
    ----------
    simulator
        Where the true state comes from.
    """

    def __init__(self, simulator: Simulator) -> None:
        scenario = simulator.scenario
        weights = {item.name: getattr(scenario.reward, item.name) for item in dataclasses.fields(RewardWeights)}
        self._weights = np.array([weights[name] for name in TERMS])
        self._vibration = weights["vibration"]
        self._simulator = simulator
        self._torque_limits = scenario.spacecraft.wheels.torque_limits
        self._cone = scenario.success.angle
        self._slow = scenario.success.rate
        self._tumble_rate = scenario.tumble_rate if scenario.tumble_rate is not None else math.inf
        self._hold = success_steps(scenario)
        count, wheels = simulator.num_spacecraft, len(self._torque_limits)
        self._last_command = np.zeros((count, wheels))
        self._on_target = np.zeros(count, dtype=np.int64)
        self._angle = np.zeros(count)
        self._rate = np.zeros(count)

    def update(self, craft: npt.NDArray[np.int64]) -> tuple[FloatArray, npt.NDArray[np.bool_]]:
        """Evaluate the control period that has just ended, or note the start of an episode, for the listed craft.

        Returns
        -------
        Terms (terms, N) and whether each craft tumbles (N,); zero at the start of an episode and for other craft.
        """
        simulator = self._simulator
        terms = np.zeros((len(TERMS), simulator.num_spacecraft))
        tumbling = np.zeros(simulator.num_spacecraft, dtype=np.bool_)
        _reward(
            craft, simulator.ticks, simulator.state.attitude, simulator.state.rate, simulator.last_command,
            simulator.reference_attitude, simulator.reference_rate, self._torque_limits, self._weights, self._cone,
            self._slow, self._tumble_rate, self._last_command, self._on_target, self._angle, self._rate, terms,
            tumbling,
        )  # fmt: skip
        if self._vibration > 0.0 and simulator.scenario.spacecraft.modes:
            moving = craft[simulator.ticks[craft] > 0]
            terms[-1, moving] = -self._vibration * simulator.modal_energy[moving]
        return terms, tumbling

    @property
    def attitude_error(self) -> FloatArray:
        """(N,) true pointing error [rad]."""
        return self._angle

    @property
    def rate_error(self) -> FloatArray:
        """(N,) magnitude of the true rate error [rad/s]."""
        return self._rate

    @property
    def success(self) -> npt.NDArray[np.bool_]:
        """(N,) whether the craft has been on target for the time that success asks for."""
        return self._on_target >= self._hold


@njit(cache=True, nogil=True, error_model="numpy")
def _reward(
    craft: Any,
    ticks: Any,
    attitude: Any,
    rate: Any,
    command: Any,
    reference_attitude: Any,
    reference_rate: Any,
    torque_limits: Any,
    weights: Any,
    cone: float,
    slow: float,
    tumble_rate: float,
    last_command: Any,
    on_target: Any,
    angle: Any,
    rate_error: Any,
    terms: Any,
    tumbling: Any,
) -> None:
    wheels = torque_limits.shape[0]
    for index in range(craft.shape[0]):
        i = craft[index]
        a, b, c, d = (
            reference_attitude[i, 0],
            -reference_attitude[i, 1],
            -reference_attitude[i, 2],
            -reference_attitude[i, 3],
        )
        p, x, y, z = attitude[i, 0], attitude[i, 1], attitude[i, 2], attitude[i, 3]
        scalar = a * p - b * x - c * y - d * z
        ex = a * x + b * p + c * z - d * y
        ey = a * y + c * p + d * x - b * z
        ez = a * z + d * p + b * y - c * x
        theta = 2.0 * math.atan2(math.sqrt(ex * ex + ey * ey + ez * ez), abs(scalar))
        vx, vy, vz = reference_rate[i, 0], reference_rate[i, 1], reference_rate[i, 2]
        # C(q_e) v = v - 2 q0 (e x v) + 2 e x (e x v)
        cx, cy, cz = ey * vz - ez * vy, ez * vx - ex * vz, ex * vy - ey * vx
        wx = rate[i, 0] - vx - 2.0 * (ey * cz - ez * cy - scalar * cx)
        wy = rate[i, 1] - vy - 2.0 * (ez * cx - ex * cz - scalar * cy)
        wz = rate[i, 2] - vz - 2.0 * (ex * cy - ey * cx - scalar * cz)
        slip = math.sqrt(wx * wx + wy * wy + wz * wz)
        spin = math.sqrt(rate[i, 0] * rate[i, 0] + rate[i, 1] * rate[i, 1] + rate[i, 2] * rate[i, 2])
        good = theta < cone and slip < slow
        tumbling[i] = ticks[i] > 0 and spin > tumble_rate
        effort, change = 0.0, 0.0
        for j in range(wheels):
            level = command[i, j] / torque_limits[j]
            step = (command[i, j] - last_command[i, j]) / torque_limits[j]
            effort += level * level / wheels
            change += step * step / wheels
            last_command[i, j] = command[i, j]
        if ticks[i] == 0:
            on_target[i] = 0
        else:
            on_target[i] = on_target[i] + 1 if good else 0
            terms[0, i] = weights[0] * (angle[i] - theta)
            terms[1, i] = -weights[1] * math.log10(1.0 + 5.0 * theta / cone)
            terms[2, i] = -weights[2] * slip * slip
            terms[3, i] = -weights[3] * effort
            terms[4, i] = -weights[4] * change
            terms[5, i] = weights[5] if good else 0.0
            terms[6, i] = -weights[6] if tumbling[i] else 0.0
        angle[i] = theta
        rate_error[i] = slip
