"""Reward of one control period, a sum of named terms computed from the true state; no step is worth less than zero.

Here theta is the true pointing error [rad] and w_e the true rate error [rad/s]. The wheel commands over their limits
are u, and e is the energy of the vibration modes [J].

================ ==================================================================================================
``pointing``     weight (1 - log(1 + theta / theta_0) / log(1 + pi / theta_0)), theta_0 = cone / 5
``effort``       minus weight ``pointing`` mean(u^2)
``smoothness``   minus weight ``pointing`` mean((u - u before)^2) / 4
``rate``         minus weight ``pointing`` q / (1 + q), q = (``|w_e|`` / ``rate_scale``)^2
``vibration``    minus weight ``pointing`` q / (1 + q), q = e / ``vibration_scale``
``on_target``    weight, while inside the success cone and slow
``progress``     weight (``discount`` phi - phi before), phi = pi - theta, 0 once the spacecraft tumbles
================ ==================================================================================================

``pointing`` is 1 without an error and 0 at 180 deg, and every decade between counts nearly the same. The four costs are
shares of it, with weights that add up to at most 1. Without ``progress`` no step is thus negative, and ending an
episode early never pays. ``progress`` is potential-based shaping (Ng, Harada and Russell 1999): with the discount of
the learner it changes no optimal policy. Its potential is zero in the state in which a tumble ends, as that result asks
for episodes (Grzes 2017). It is off by default, and the only term that can make a step negative.
"""

import math
from functools import reduce
from operator import add
from typing import Any

import numpy as np
import numpy.typing as npt

from ftac_gym.attitude import mrp_from_quaternion, quaternion_error
from ftac_gym.dynamics import Simulator
from ftac_gym.task.objective import COSTS
from ftac_gym.task.scenario import success_steps
from ftac_gym.utils import algebra
from ftac_gym.utils.algebra import add3, norm3, relative_quaternion, rotation_change, row3
from ftac_gym.utils.compiling import entry_point
from ftac_gym.utils.parameters import FloatArray

TERMS = ("pointing", *COSTS, "on_target", "progress")

REWARD_KEYS = tuple(f"reward/{name}" for name in TERMS)
"""Keys of the terms in ``info``."""

_VIBRATION = TERMS.index("vibration")


def total(terms: Any) -> Any:
    """Return the sum of terms, numbers or arrays (N,), added in their order; NumPy's sum has another for N = 1."""
    return reduce(add, terms)


class Reward:
    """Rewards of N spacecraft; the state is the last error and command, and each one's periods on target.

    Parameters
    ----------
    simulator
        Source of the true state.
    """

    def __init__(self, simulator: Simulator) -> None:
        scenario, count = simulator.scenario, simulator.num_spacecraft
        self._simulator = simulator
        self._vibration = scenario.reward.vibration
        self._vibration_scale = scenario.reward.vibration_scale
        torque_limits = scenario.spacecraft.wheels.torque_limits
        self._constants = (
            torque_limits,
            np.array([getattr(scenario.reward, name) for name in TERMS]),
            scenario.reward.rate_scale,
            scenario.reward.discount,
            scenario.success.angle,
            scenario.success.rate,
            scenario.success.largest_error,
            math.inf if scenario.tumble_rate is None else scenario.tumble_rate,
        )
        bounds = scenario.cost_bounds
        self._bound = scenario.prescribed_bound if bounds.angle is None else None
        cone = scenario.success.angle if bounds.angle is None else bounds.angle
        self._bounds = math.inf if self._bound is not None else cone, bounds.torque
        self._last_command = np.zeros((count, len(torque_limits)))
        # Flags of the window's control periods: 1 on target, 2 beyond the largest error. It is written in a circle.
        self._window = np.zeros((count, success_steps(scenario)), dtype=np.uint8)
        self._held = np.zeros((count, 2), dtype=np.int64)
        self.periods_on_target = np.zeros(count, dtype=np.int64)
        """(N,) control periods on target so far."""
        self.attitude_error: FloatArray = np.zeros(count)
        """(N,) true pointing error [rad]."""
        self.rate_error: FloatArray = np.zeros(count)
        """(N,) magnitude of the true rate error [rad/s]."""
        self.outside: npt.NDArray[np.bool_] = np.zeros(count, dtype=np.bool_)
        """(N,) whether the period was outside the bounds on pointing error and wheel commands."""

    def update(self, rows: npt.NDArray[np.int64]) -> tuple[FloatArray, npt.NDArray[np.bool_]]:
        """Evaluate the control period that has just ended, or the start of an episode, for the listed spacecraft.

        Returns
        -------
        Terms (terms, N) and the mask of those that tumble (N,); zero at the start of an episode and in other rows.
        """
        simulator = self._simulator
        terms = np.zeros((len(TERMS), simulator.num_spacecraft))
        tumbling = np.zeros(simulator.num_spacecraft, dtype=np.bool_)
        _reward(
            rows, simulator.ticks, simulator.state.attitude, simulator.state.rate, simulator.last_command,
            simulator.reference_attitude, simulator.reference_rate, *self._constants, *self._bounds,
            self._last_command, self._window, self._held, self.periods_on_target, self.outside, self.attitude_error,
            self.rate_error, terms, tumbling,
        )  # fmt: skip
        if self._bound is not None:
            moving = rows[simulator.ticks[rows] > 0]
            error = quaternion_error(simulator.state.attitude[moving], simulator.reference_attitude[moving])
            margin = self._bound.margin(mrp_from_quaternion(error), simulator.time[moving])
            self.outside[moving] |= (margin < 0.0).any(axis=1)
        if self._vibration > 0.0 and simulator.scenario.spacecraft.modes:
            moving = rows[simulator.ticks[rows] > 0]
            ratio = simulator.modal_energy[moving] / self._vibration_scale
            cost = self._vibration * terms[0, moving] * (ratio / (1.0 + ratio))
            terms[_VIBRATION, moving] = -np.minimum(cost, total(terms[:_VIBRATION, moving]))
        return terms, tumbling

    @property
    def success(self) -> npt.NDArray[np.bool_]:
        """(N,) mask of the spacecraft for which an episode that ended now would be a success."""
        window, success = self._window.shape[1], self._simulator.scenario.success
        reached: npt.NDArray[np.bool_] = success.reached(
            window, self._simulator.ticks, self._held[:, 0], self._held[:, 1]
        )
        return reached


@entry_point(algebra, contract=False)
def _reward(
    rows: Any,
    ticks: Any,
    attitude: Any,
    rate: Any,
    command: Any,
    reference_attitude: Any,
    reference_rate: Any,
    torque_limits: Any,
    weights: Any,
    rate_scale: float,
    discount: float,
    cone: float,
    largest_rate: float,
    largest_error: float,
    tumble_rate: float,
    bound: float,
    torque_bound: float,
    last_command: Any,
    window: Any,
    held: Any,
    periods_on_target: Any,
    outside: Any,
    attitude_error: Any,
    rate_error: Any,
    terms: Any,
    tumbling: Any,
) -> None:
    """Evaluate all terms but that of the vibration modes; the rows of ``terms`` are those of TERMS."""
    wheels, length = torque_limits.shape[0], window.shape[1]
    scale = 0.2 * cone
    decades = math.log(1.0 + math.pi / scale)
    for index in range(rows.shape[0]):
        i = rows[index]
        scalar, x, y, z = relative_quaternion(reference_attitude, attitude, i)
        theta = 2.0 * math.atan2(norm3((x, y, z)), abs(scalar))
        spin, reference = row3(rate, i), row3(reference_rate, i)
        slip = norm3(add3(add3(spin, -1.0, reference), -1.0, rotation_change(scalar, (x, y, z), reference)))
        good = theta < cone and slip < largest_rate
        tumbling[i] = ticks[i] > 0 and norm3(spin) > tumble_rate
        effort, change, highest = 0.0, 0.0, 0.0
        for j in range(wheels):
            level = command[i, j] / torque_limits[j]
            step = (command[i, j] - last_command[i, j]) / torque_limits[j]
            highest = max(highest, abs(level))
            effort += level * level / wheels
            change += step * step / wheels
            last_command[i, j] = command[i, j]
        if ticks[i] == 0:
            held[i, 0], held[i, 1], periods_on_target[i], outside[i] = 0, 0, 0, False
        else:
            place = (ticks[i] - 1) % length
            if ticks[i] > length:
                held[i, 0] -= window[i, place] & 1
                held[i, 1] -= window[i, place] >> 1
            beyond = theta > largest_error
            window[i, place] = (1 if good else 0) + (2 if beyond else 0)
            held[i, 0] += good
            held[i, 1] += beyond
            periods_on_target[i] += good
            outside[i] = theta >= bound or highest >= torque_bound
            pointing = weights[0] * max(0.0, 1.0 - math.log(1.0 + theta / scale) / decades)
            ratio = (slip / rate_scale) ** 2
            # Both potentials leave out the part that cancels for a discount of one.
            ahead = -math.pi if tumbling[i] else discount * (math.pi - theta) - math.pi
            terms[0, i] = pointing
            # No cost is more than what the terms before it leave: rounding must not make a step negative.
            left = pointing
            for term, share in ((1, effort), (2, 0.25 * change), (3, ratio / (1.0 + ratio))):
                cost = min(weights[term] * pointing * share, left)
                terms[term, i] = -cost
                left -= cost
            terms[5, i] = weights[5] if good else 0.0
            terms[6, i] = weights[6] * (ahead + attitude_error[i])
        attitude_error[i] = theta
        rate_error[i] = slip
