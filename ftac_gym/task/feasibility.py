"""Feasibility of episodes: whether the remaining wheels can surely do the task.

The label is conservative: an episode without it may still succeed, when faults do not act together or end in time. The
rule takes the wheels as they are in the worst moment of each fault, and is the same for every policy:

1. Torque. A wheel that follows commands offers its effectiveness times its torque limit either way. Scaled down
   to leave ``TORQUE_RESERVE`` of it for control, the envelope of these torques must contain all others. They are any
   combination of the uncommanded torques (bias, hard-over, friction) and of the disturbance.
2. Momentum. The wheels that follow commands must be able to hold the largest total momentum, in any direction. It is
   that of body and wheels at the start and the largest that the disturbance can add. A wheel that follows none but has
   a torque of its own ends at its momentum limit at the latest; the momentum that it adds to the body comes on top.
3. Time. A turn about the axis of the initial error, as fast as torque and momentum allow, must fit in before the final
   ``success.hold`` seconds. It may come before the first fault, with the healthy wheels. Or it may come between the
   onset of a fault and the next, as a whole, with the capacity that all faults together leave. Moving references have
   no such rule.

A locked wheel or an outage holds a torque or a momentum that the policy chose and that no label can predict; it counts
as giving and holding nothing. So does a seized wheel: its momentum is part of the total. Delays and faults of the
sensors take away neither torque nor momentum and are left out. The power limit and the saturation of a healthy wheel
within the episode are left out too.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ftac_gym.attitude import quaternion_error, rotation_vector_from_quaternion
from ftac_gym.spacecraft.envelope import UNLIMITED, Envelope, Load, envelope_of
from ftac_gym.spacecraft.wheel_array import WheelArray
from ftac_gym.task.episodes import Episodes
from ftac_gym.utils.parameters import FloatArray

BoolArray = npt.NDArray[np.bool_]
Records = npt.NDArray[np.void]

TORQUE_RESERVE = 0.2
"""Share of the torque envelope that must stay free for control."""


@dataclass(frozen=True, eq=False)
class Demand:
    """Demand of N episodes on the wheels.

    Attributes
    ----------
    disturbance
        (N, 3) largest external torque on each axis [N m].
    momentum
        (N,) largest magnitude of the momentum of body and wheels together [N m s].
    effort
        (N, 3) torque for one rad/s^2 about the axis of the turn, which is also the momentum for one rad/s, [kg m^2].
    angle
        (N,) angle to turn through [rad].
    rate
        (N,) body rate at the start [rad/s].
    start
        (N,) earliest time of the turn [s].
    deadline
        Latest end of the turn [s].
    duration
        Length of the episode [s]; later onsets do not count.
    """

    disturbance: FloatArray
    momentum: FloatArray
    effort: FloatArray
    angle: FloatArray
    rate: FloatArray
    start: FloatArray
    deadline: float
    duration: float

    @classmethod
    def of_episodes(cls, episodes: Episodes, wheels: WheelArray, turning: bool, hold: float, duration: float) -> Demand:
        """Return the demand of drawn episodes: of several set points it takes the last turn.

        Parameters
        ----------
        episodes
            The episodes.
        wheels
            The wheel array.
        turning
            Whether the turn counts; it does not for a moving reference.
        hold
            Time on target at the end of an episode that success asks for [s].
        duration
            Length of the episode [s].
        """
        initial, inertia, set_points = episodes.initial, episodes.inertia, episodes.set_points
        disturbance, harmonics = episodes.disturbance, episodes.harmonics
        largest = np.abs(disturbance["constant"]) + np.hypot(harmonics["sine"], harmonics["cosine"]).sum(axis=1)
        fastest = np.sum(initial["rate"] ** 2, axis=1) + disturbance["rate_offset"]
        largest = largest * np.where(disturbance["rate_scaled"] > 0.5, fastest, 1.0)[:, None]
        body = np.einsum("nij,nj->ni", inertia["constant"], initial["rate"])
        total = body + initial["wheel_momentum"] @ wheels.axis_matrix.T if wheels.momentum_coupling else body
        points = set_points["attitude"]
        before = points[:, -2] if points.shape[1] > 1 else initial["attitude"]
        turn = rotation_vector_from_quaternion(quaternion_error(before, points[:, -1]))
        angle = np.linalg.norm(turn, axis=1) if turning else np.zeros(len(turn))
        # An episode without a turn may have any axis.
        axis = np.where(angle[:, None] > 1e-9, turn / np.maximum(angle, 1e-9)[:, None], (1.0, 0.0, 0.0))
        return cls(
            disturbance=largest,
            momentum=np.linalg.norm(total, axis=1) + np.linalg.norm(largest, axis=1) * duration,
            effort=np.einsum("nij,nj->ni", inertia["constant"], axis),
            angle=angle,
            rate=np.linalg.norm(initial["rate"], axis=1),
            start=set_points["time"][:, -1],
            deadline=duration - min(hold, duration),
            duration=duration,
        )

    def turning_time(
        self, envelope: Envelope, torque: Load, offered: FloatArray, momentum: Load, storable: FloatArray
    ) -> FloatArray:
        """Return the time to stop and to turn (N,) [s].

        Parameters
        ----------
        envelope
            Of the wheels.
        torque, offered
            Torques beside that of the turn, and the torque of each wheel (N, m) [N m].
        momentum, storable
            Momenta beside that of the turn, and the capacity of each wheel (N, m) [N m s].
        """
        acceleration = envelope.multiples(self.effort, torque, offered)
        fastest = envelope.multiples(self.effort, momentum, storable)
        with np.errstate(divide="ignore", invalid="ignore"):
            direct = 2.0 * np.sqrt(self.angle / acceleration)
            coasting = self.angle / fastest + fastest / acceleration
            stopping = self.rate / acceleration
            time: FloatArray = np.where(self.angle * acceleration <= fastest**2, direct, coasting) + stopping
        return np.where((acceleration > 0.0) & (fastest > 0.0), time, np.inf)


def feasibility_labels(faults: Records, wheels: WheelArray, demand: Demand) -> BoolArray:
    """Label episodes as feasible.

    Parameters
    ----------
    faults
        FAULT records (N, m, layers).
    wheels
        The wheel array.
    demand
        Demand of the episodes.

    Returns
    -------
    Array (N,) of booleans.
    """
    duration, axes = demand.duration, wheels.axis_matrix
    acting = faults["onset"] < duration
    weakest = faults["effectiveness"] - np.abs(faults["effectiveness_amplitude"])
    effectiveness = np.where(acting, np.maximum(weakest, 0.0), 1.0).prod(axis=2)
    commanded = (effectiveness > 0.0) & ~(acting & (faults["brake"] > 0.0)).any(axis=2)
    effectiveness = np.where(commanded, effectiveness, 0.0)
    length = np.clip(np.minimum(faults["recovery"], duration) - np.minimum(faults["onset"], duration), 0.0, None)
    swing = np.abs(faults["bias_amplitude"]) * length ** faults["bias_exponent"]
    first, last = faults["bias"], faults["bias"] + faults["bias_slope"] * length
    # Faults of one wheel or of several need not act at the same time: each counts from nothing to its worst.
    highest = np.where(acting, np.maximum(np.maximum(first, last) + swing, 0.0), 0.0).sum(axis=2)
    lowest = np.where(acting, np.minimum(np.minimum(first, last) - swing, 0.0), 0.0).sum(axis=2)

    envelope, nothing = envelope_of(wheels.axes), np.zeros((1, 3))
    limits = (1.0 - TORQUE_RESERVE) * np.minimum(wheels.torque_limits, UNLIMITED)
    capacity = np.minimum(wheels.momentum_limits, UNLIMITED)
    offered, half = effectiveness * limits, 0.5 * (highest - lowest) + friction_margin(faults, wheels, acting)
    torque = Load(0.5 * (highest + lowest) @ axes.T, demand.disturbance, half)
    # A wheel that follows no command adds its torque to the body until its momentum limit stops it.
    up = np.where(commanded, 0.0, np.minimum(highest * length.max(axis=2), capacity))
    down = np.where(commanded, 0.0, np.maximum(lowest * length.max(axis=2), -capacity))
    storable = np.where(commanded, capacity, 0.0)
    momentum = Load(0.5 * (up + down) @ axes.T, nothing, 0.5 * (up - down), demand.momentum)
    possible = envelope.contains(torque, offered) & envelope.contains(momentum, storable)

    affected = acting & (faults["kind"] > 0) & (faults["delay"] == 0)
    # The onsets in their order, and behind each the time until the next, or the deadline.
    onsets = np.sort(np.where(affected, faults["onset"], np.inf).reshape(len(faults), -1), axis=1)
    following = np.minimum(np.pad(onsets, ((0, 0), (0, 1)), constant_values=np.inf), demand.deadline)
    smooth = friction_margin(faults, wheels, np.zeros_like(acting))
    healthy = Load(nothing, demand.disturbance, smooth), limits, Load(nothing, radius=demand.momentum), capacity
    early = demand.start + demand.turning_time(envelope, *healthy) <= following[:, 0]
    after = demand.turning_time(envelope, torque, offered, momentum, storable)
    late = (np.maximum(onsets, demand.start[:, None]) + after[:, None] <= following[:, 1:]).any(axis=1)
    return possible & (early | late)


def friction_margin(faults: np.ndarray, wheels: WheelArray, acting: BoolArray) -> FloatArray:
    """Return the largest friction of each wheel, (N, m) [N m].

    The dry part counts at breakaway, the viscous part at the momentum limit; without a limit it is left out.
    """
    rise: FloatArray = np.where(acting, np.maximum(faults["friction_forward"], faults["friction_backward"]), 1.0).prod(
        axis=2
    )
    margin = np.zeros_like(rise)
    for wheel, friction in enumerate(wheels.frictions):
        if friction is not None:
            fastest = wheels.momentum_limits[wheel] / wheels.spin_inertias[wheel]
            viscous = friction.viscous * fastest if np.isfinite(fastest) else 0.0
            margin[:, wheel] = (friction.breakaway or 0.0) * rise[:, wheel] + viscous
    return margin
