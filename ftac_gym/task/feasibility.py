"""Feasibility of episodes: whether a controller with the truth and all faults in advance passes them.

An episode earns the label by a flight on a coarse grid of times (:mod:`ftac_gym.task.feasible_flight`). Its controller
is given the truth and all faults in advance. The flight has what decides feasibility:

1. Torque. In each step every wheel has bounds from its effectiveness, bias, friction, power limit and momentum limit at
   that time, along its true axis. An outage leaves a wheel its momentum, and a seizure gives it to the body.
2. Momentum. The torques add up to the momenta of the wheels, and these to the gyroscopic torque w x (J w + D h). Wheels
   with redundancy give up momentum that no torque needs. So the wheels must hold the total momentum at every attitude
   on the way and at the target, and a slow turn needs a torque too.
3. Time. The turn is as fast as braking with the torque of later times allows. It is about the axis of the error, or a
   tilt of the stored momentum with a turn about it (:mod:`ftac_gym.task.feasible_path`). The label
   asks for success as the evaluation does: ``success.share`` of the times of the last ``success.hold`` seconds on
   target, and none beyond ``success.limit`` cones.
4. Following. A moving reference takes its torque and momentum first.

Each of :data:`PLANS` is a flight; one success is enough. They use :data:`TORQUE_SHARE` of the torque limits.

The label answers for the best of all controllers, not for a typical one. It counts a locked wheel as one that was
commanded to give no torque at the onset, or the torque that balances a bias; a controller that turns at full torque
then keeps that torque. The last plans prepare the momenta for a wheel that will run away
(:mod:`ftac_gym.task.feasible_foresight`). Where the wheels span no space to the end of an episode, the drift may pass
the target in the window of success.

Left out are the faults of the sensors, delays of commands, sensor noise, flexible modes, lag, dead-band and the rate
of tumbling.

No label is exact: an episode without it may be passed by a path that none of the plans takes. The numbers are in the
documentation, from ``benchmarks/feasible.py``.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from ftac_gym.attitude import angular_velocity_from_mrp, quaternion_from_mrp
from ftac_gym.spacecraft.envelope import UNLIMITED, envelope_normals
from ftac_gym.spacecraft.wheel_array import WheelArray
from ftac_gym.task.feasible_flight import PLAN, flown
from ftac_gym.task.feasible_torque import CAPACITY
from ftac_gym.task.references import ReferenceKind
from ftac_gym.task.sampled_reference import SampledReference
from ftac_gym.utils.parameters import FloatArray

if TYPE_CHECKING:
    from ftac_gym.task.episodes import Episodes
    from ftac_gym.task.scenario import Scenario

PLANS = np.array(
    [
        (0.9, 0.4, 0, 0, 0),
        (0.6, 0.7, 0, 0, 0),
        (0.8, 0.2, 0, 0, 0),
        (0.9, 0.4, 1, 0, 0),
        (0.9, 0.4, 0, 1, 0),
        (0.7, 0.5, 0, 1, 0),
        (0.6, 0.95, 0, 0, 0),
        (0.9, 0.8, 0, 0, 1),
        (0.6, 0.95, 0, 0, 1),
    ],
    PLAN,
)
"""Ways to turn: fast, with more and with less gyroscopic torque, the long way round, prepared for the faults. The last
ones have nearly all torque as gyroscopic torque; two of them tilt the stored momentum."""

TORQUE_SHARE = 0.97
"""Share of the torque limits that the flights use."""

LONGEST_STEP = 1.0
"""Longest step of the flights [s], unless they would have more than :data:`MOST_STEPS`."""

FEWEST_STEPS, MOST_STEPS = 120, 480
"""Least and largest number of steps of a flight."""


def feasibility_labels(scenario: Scenario, episodes: Episodes) -> npt.NDArray[np.bool_]:
    """Label episodes as feasible in a scenario, (N,)."""
    return plan_numbers(scenario, episodes) >= 0


def plan_numbers(scenario: Scenario, episodes: Episodes) -> npt.NDArray[np.int64]:
    """Return the number of the first of :data:`PLANS` that flies each episode with success, or -1, (N,)."""
    return flights(scenario, episodes)[0]


def flights(scenario: Scenario, episodes: Episodes) -> tuple[npt.NDArray[np.int64], FloatArray, FloatArray]:
    """Fly episodes for their labels.

    Returns
    -------
    The numbers of :func:`plan_numbers`; the times (T,) of the flights [s]; and the path (T, 6 + m) of the last flight:
    turn [rad] and rate [rad/s] in the frame of the reference, body axes, and momenta of the wheels [N m s].
    """
    wheels, success, duration = scenario.spacecraft.wheels, scenario.success, scenario.duration
    axes = wheels.axis_matrix.T
    if scenario.misalignment is not None:
        axes = axes + np.transpose(scenario.misalignment)
    normals = facet_normals(axes.T)
    steps = step_count(duration, episodes.reference)
    times = np.linspace(0.0, duration, steps + 1)
    aims, rates = reference_motion(scenario.reference, episodes, times)
    window = int(np.searchsorted(times, duration - min(success.hold, duration) + 1e-9, side="right"))
    goal = np.array([success.angle, success.rate, success.largest_error, 1.0 - success.share])
    numbers = np.empty(len(episodes), dtype=np.int64)
    initial = episodes.initial
    # One layout of the arrays for all callers, as each one is compiled anew.
    tables = map(np.ascontiguousarray, (
        initial["attitude"], initial["rate"], initial["wheel_momentum"], aims, rates, episodes.set_points,
        episodes.inertia, episodes.disturbance, episodes.harmonics, episodes.faults, episodes.switches,
        capacities(wheels), axes, normals, normals @ axes.T, idle_momenta(axes),
    ))  # fmt: skip
    path = np.zeros((steps + 1, 6 + wheels.count))
    flown(*tables, wheels.momentum_coupling, duration / steps, steps, window, goal, PLANS, path, numbers)
    return numbers, times, path


def step_count(duration: float, reference: npt.NDArray[np.void]) -> int:
    """Return the number of steps of flights of a length [s], more for references (N,) that swing fast."""
    swings = duration * float(np.abs(reference["frequency"]).max(initial=0.0))
    fewest = max(FEWEST_STEPS, math.ceil(duration / LONGEST_STEP), math.ceil(4.0 * swings))
    return min(fewest, MOST_STEPS)


def facet_normals(axes: FloatArray) -> FloatArray:
    """Return the normals (facets, 3) of the envelope of wheel axes (3, m), also of a flat one."""
    directions, sizes, _ = np.linalg.svd(axes)
    rank = int((sizes > 1e-6).sum())
    return envelope_normals(np.hstack([axes, directions[:, rank:]]))


def idle_momenta(axes: FloatArray) -> FloatArray:
    """Return (m, m): column j is the momentum of all wheels, with axes (m, 3), that adds up to none and has 1 at j.

    It has the least sum of squares, and is zero where there is none.
    """
    idle = np.eye(len(axes)) - axes @ np.linalg.pinv(axes)
    share = np.diag(idle)
    return np.where(share > 1e-6, idle / np.maximum(share, 1e-6), 0.0)


def capacities(wheels: WheelArray) -> npt.NDArray[np.void]:
    """Return the CAPACITY records (m,) of a wheel array, with :data:`TORQUE_SHARE` of its torque limits."""
    table = np.zeros(wheels.count, CAPACITY)
    table["torque_limit"] = TORQUE_SHARE * np.minimum(wheels.torque_limits, UNLIMITED)
    table["momentum_limit"] = np.minimum(wheels.momentum_limits, UNLIMITED)
    table["power_limit"] = np.minimum(wheels.power_limits, UNLIMITED)
    table["inverse_inertia"] = 1.0 / wheels.spin_inertias
    for record, friction in zip(table, wheels.frictions, strict=True):
        if friction is not None:
            record["coulomb"], record["viscous"] = friction.coulomb, friction.viscous
    return table


def reference_motion(reference: object, episodes: Episodes, times: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return attitudes (N, 4) of the reference at the start, and its rates (N, T, 3) at times (T,) [rad/s].

    The rates are in the reference's own axes; of set points there are none, (N, 0, 3).
    """
    drawn, count = episodes.reference, len(episodes)
    kind = drawn["kind"][0] if count else ReferenceKind.SET_POINTS
    if kind == ReferenceKind.SET_POINTS:
        return np.ascontiguousarray(episodes.set_points["attitude"][:, 0]), np.empty((count, 0, 3))
    if isinstance(reference, SampledReference):
        attitude, rate, _ = reference.motion(times)
        return np.repeat(attitude[:1], count, axis=0), np.repeat(rate[None], count, axis=0)
    angle = drawn["frequency"][:, None] * times[:, None] + drawn["phase"][:, None]
    values = drawn["constant"][:, None] + drawn["amplitude"][:, None] * np.sin(angle)
    if kind == ReferenceKind.RATE_PROFILE:
        return np.ascontiguousarray(drawn["attitude"]), values
    changes = (drawn["amplitude"] * drawn["frequency"])[:, None] * np.cos(angle)
    return quaternion_from_mrp(values[:, 0]), angular_velocity_from_mrp(values, changes)
