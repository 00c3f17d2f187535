"""Wheel torques that a reference requires: inverse dynamics, without any controller."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ftac_gym import attitude as attitudes
from ftac_gym.baselines.components.allocation import MinimaxAllocation, pseudo_inverse
from ftac_gym.faults import fault_effect
from ftac_gym.spacecraft.wheel_array import WheelArray
from ftac_gym.task.episodes import Episodes
from ftac_gym.task.references import ReferenceKind
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray, require

ALLOCATIONS = ("minimax", "pseudo_inverse")
"""Ways to share a torque among the wheels: least largest command, or least sum of squares."""


@dataclass(frozen=True, eq=False)
class Motion:
    """The reference of one episode at T moments.

    Attributes
    ----------
    rate
        (T, 3) rate of the reference frame, in its own axes [rad/s].
    acceleration
        (T, 3) its derivative [rad/s^2].
    """

    rate: FloatArray
    acceleration: FloatArray


def reference_motion(episodes: Episodes, time: FloatArray) -> Motion:
    """Return the motion of the reference of the first episode.

    A set point is at rest; the jump from one to the next is left out, since no finite torque follows it.

    Parameters
    ----------
    episodes
        Drawn episodes, of which the first is evaluated.
    time
        (T,) time of the episode [s].
    """
    record = episodes.reference[0]
    if record["kind"] == ReferenceKind.SET_POINTS:
        return Motion(np.zeros((len(time), 3)), np.zeros((len(time), 3)))
    if record["kind"] == ReferenceKind.SAMPLED:
        sampled: Any = Scenario.from_json(episodes.scenario_json).reference
        return Motion(*sampled.motion(time)[1:])
    frequency = record["frequency"]
    angle = time[:, None] * frequency + record["phase"]
    value = record["constant"] + record["amplitude"] * np.sin(angle)
    first = record["amplitude"] * frequency * np.cos(angle)
    if record["kind"] == ReferenceKind.RATE_PROFILE:
        return Motion(value, first)
    second = -record["amplitude"] * frequency**2 * np.sin(angle)
    return Motion(
        attitudes.angular_velocity_from_mrp(value, first),
        attitudes.angular_acceleration_from_mrp(value, first, second),
    )


def required_torque(scenario: Scenario, time: npt.ArrayLike, disturbance: bool = False, seed: int = 0) -> FloatArray:
    """Return the torque on the body for following the reference exactly.

    It is J w_d' + w_d x J w_d with the nominal inertia J.

    Parameters
    ----------
    scenario
        The task; its wheels must be ideal torquers, without ``momentum_coupling``.
    time
        (T,) time of the episode [s].
    disturbance
        Whether the wheels also compensate the external torque.
    seed
        Seed of the episode, where the reference or the external torque is random.

    Returns
    -------
    Array (T, 3), in body axes [N m].

    Raises
    ------
    ValueError
        If the stored momentum enters the gyroscopic torque, or the times are not a list of finite numbers.
    """
    moments = np.asarray(time, dtype=np.float64)
    valid = moments.ndim == 1 and moments.size > 0 and bool(np.isfinite(moments).all())
    require(valid, "time", "must be a list of finite numbers", time)
    coupled = scenario.spacecraft.wheels.momentum_coupling
    require(not coupled, "momentum_coupling", "must be False: stored momentum is not followed here", coupled)
    episodes = scenario.draw(seed, 1)
    motion, inertia = reference_motion(episodes, moments), scenario.spacecraft.inertia_matrix
    torque: FloatArray = motion.acceleration @ inertia + attitudes.cross(motion.rate, motion.rate @ inertia)
    if disturbance:
        torque = torque - _external(episodes, moments, motion.rate)
    return torque


def peak_wheel_torque(
    scenario: Scenario,
    allocation: str = "minimax",
    disturbance: bool = False,
    faults: bool = False,
    time: npt.ArrayLike | None = None,
    seed: int = 0,
) -> float:
    """Return the largest wheel torque for following the reference exactly.

    A reference that needs more than the torque limit cannot be followed by any controller; with ``"minimax"`` the
    converse holds too, moment by moment, for wheels with equal limits.

    Parameters
    ----------
    scenario
        The task; its wheels must be ideal torquers, without ``momentum_coupling``.
    allocation
        Way to share the torque among the wheels, one of :data:`ALLOCATIONS`; both ignore the torque limits.
    disturbance
        Whether the wheels also compensate the external torque.
    faults
        Whether to allocate to the wheels with their true faults. The result is then the largest *command*. A wheel
        without effectiveness is left out.
    time
        (T,) moments [s]; None for the start of the episode and the end of each of its control periods.
    seed
        Seed of the episode, where anything is random.

    Returns
    -------
    The torque [N m].

    Raises
    ------
    ValueError
        If the allocation is unknown, the times are not a list of finite numbers, or the stored momentum enters the
        gyroscopic torque. Also if the remaining wheels do not span space.
    """
    require(allocation in ALLOCATIONS, "allocation", f"must be one of {list(ALLOCATIONS)}", allocation)
    every = scenario.control_period * np.arange(scenario.horizon + 1, dtype=np.float64)
    moments = every if time is None else np.asarray(time, np.float64)
    torque = required_torque(scenario, moments, disturbance, seed)
    wheels = scenario.spacecraft.wheels
    effectiveness: FloatArray = np.ones((len(moments), wheels.count))
    if faults:
        drawn = scenario.draw(seed, 1).drawn_faults.take(np.zeros(len(moments), dtype=np.int64))
        zero = np.zeros_like(effectiveness)
        effect = fault_effect(drawn, moments, wheels, zero, zero)
        effectiveness, torque = effect.effectiveness, torque - effect.bias @ wheels.axis_matrix.T
    # Moments with the same effectiveness share an allocation.
    states, inverse = np.unique(effectiveness, axis=0, return_inverse=True)
    groups = (torque[inverse == index] for index in range(len(states)))
    commands = (_commands(wheels, state, allocation, group) for state, group in zip(states, groups, strict=True))
    return float(max(np.abs(command).max() for command in commands))


def _commands(wheels: WheelArray, effectiveness: FloatArray, allocation: str, torque: FloatArray) -> FloatArray:
    """Return the commands (n, working) of the working wheels for torques on the body (n, 3)."""
    works = effectiveness > 0.0
    share, axes = effectiveness[works], wheels.axis_matrix[:, works]
    if allocation == "pseudo_inverse":
        return torque @ pseudo_inverse(axes * share).T
    # With a limit equal to the effectiveness, the used share of the limit is the command.
    minimax = MinimaxAllocation(WheelArray(tuple(map(tuple, axes.tolist())), tuple(share.tolist())))
    return minimax(torque) / share


def _external(episodes: Episodes, time: FloatArray, rate: FloatArray) -> FloatArray:
    """Return the external torque of the first episode (T, 3) [N m], for body rates (T, 3) [rad/s]."""
    steady, torque = episodes.disturbance[0], np.zeros((len(time), 3))
    torque += steady["constant"]
    for harmonic in episodes.harmonics[0]:
        angle = time[:, None] * harmonic["frequency"]
        torque += harmonic["sine"] * np.sin(angle) + harmonic["cosine"] * np.cos(angle)
    if steady["rate_scaled"] > 0.5:
        torque *= np.sum(rate**2, axis=1, keepdims=True) + steady["rate_offset"]
    return torque
