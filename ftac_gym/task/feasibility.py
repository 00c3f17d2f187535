"""Can the remaining wheels surely do the task? A label per episode, so that impossible draws count against nobody.

The label is careful: an episode without it may still be flown by luck, when faults do not act together or end in time.
The rule looks at the wheels as they are in the worst moment of each fault, and is the same for every policy:

1. Torque. A wheel that still obeys offers its effectiveness times its torque limit either way; any combination of the
   uncommanded torques (bias, hard-over, friction) and of the disturbance must lie inside the torque envelope of what is
   offered, scaled down to leave ``TORQUE_RESERVE`` of it for control.
2. Momentum. The wheels that obey must be able to hold, in any direction, the momentum of body and wheels at the start
   and what the disturbance can add. A wheel that no longer obeys but has a torque of its own ends at its momentum limit
   at the latest; what it pours into the body comes on top.
3. Time. A turn about the axis of the initial error, as fast as torque and momentum allow, must fit in before the final
   ``success.hold`` seconds: either before the first fault with the healthy wheels, or between the onset of a fault and
   the next with what all faults together leave, as if nothing had been done before. Moving references are not asked
   this.

Both envelopes are zonotopes, sum_j [-r_j, r_j] D[:, j], and a vector t lies inside one exactly if
|n.t| <= sum_j r_j |n.D[:, j]| for the normal n of every pair of wheel axes. A locked or dead wheel holds a torque or a
momentum that the policy chose, which no label can know; it is counted as giving and holding nothing. A seized wheel
too: its momentum is part of the total. Delays and faults of the sensors take away neither torque nor momentum and are
not looked at; nor are the power limit and the saturation of a healthy wheel within the episode.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations

import numpy as np
import numpy.typing as npt

from ftac_gym.attitude import cross, quaternion_error, rotation_vector_from_quaternion
from ftac_gym.spacecraft.wheel_array import WheelArray
from ftac_gym.utils.parameters import FloatArray, Matrix

BoolArray = npt.NDArray[np.bool_]
Records = npt.NDArray[np.void]

UNLIMITED = 1e12
"""Stands for the torque or momentum of a wheel without a limit: infinite times zero would be undefined."""

ROUNDING = 1e-9
"""Relative tolerance: a load exactly on the envelope is inside."""

TORQUE_RESERVE = 0.2
"""Share of the torque envelope that must stay free for control."""


def envelope_normals(axes: FloatArray) -> FloatArray:
    """Return the unit normals of the facets of a wheel array's envelope.

    Parameters
    ----------
    axes
        (3, m) wheel axes.

    Returns
    -------
    Array (facets, 3), one row for each pair of axes that are not parallel.
    """
    first, second = np.array(list(combinations(range(axes.shape[1]), 2)), dtype=int).reshape(-1, 2).T
    normals = cross(axes.T[first], axes.T[second])
    lengths = np.linalg.norm(normals, axis=1)
    distinct = lengths > 1e-9
    units: FloatArray = normals[distinct] / lengths[distinct, None]
    return units


class Envelope:
    """The zonotopes sum_j [-r_j, r_j] D[:, j] of a wheel array, for any reach r of the wheels.

    A *set* of vectors is a point (N, 3), give or take a box in body axes of half-widths ``margin`` (N, 3), an interval
    along each wheel axis of half-width ``wheel_margin`` (N, m), and a ball of radius ``radius`` (N,).

    Parameters
    ----------
    axes
        (3, m) wheel axes.
    """

    def __init__(self, axes: FloatArray) -> None:
        self._axes = axes
        self._normals = envelope_normals(axes).T
        self._across = np.abs(axes.T @ self._normals)

    def room(
        self,
        point: FloatArray,
        margin: FloatArray,
        reach: FloatArray,
        wheel_margin: FloatArray | float = 0.0,
        radius: FloatArray | float = 0.0,
    ) -> tuple[FloatArray, FloatArray]:
        """Return what a set leaves free along each normal, and the envelope itself, both (N, facets)."""
        support = np.minimum(reach, UNLIMITED) @ self._across
        # The vector of the set that is farthest along a normal, whichever it is.
        farthest = np.abs(point @ self._normals) + margin @ np.abs(self._normals) + np.reshape(radius, (-1, 1))
        if isinstance(wheel_margin, np.ndarray):
            farthest = farthest + wheel_margin @ self._across
        return support - farthest, support

    def contains(
        self,
        point: FloatArray,
        margin: FloatArray,
        reach: FloatArray,
        wheel_margin: FloatArray | float = 0.0,
        radius: FloatArray | float = 0.0,
    ) -> BoolArray:
        """Tell whether sets lie inside (N,); never if the wheels that can give anything do not span space."""
        free, support = self.room(point, margin, reach, wheel_margin, radius)
        gram = np.einsum("nj,ij,kj->nik", (reach > 0.0).astype(float), self._axes, self._axes)
        inside: BoolArray = np.all(free >= -ROUNDING * support, axis=1) & (np.linalg.eigvalsh(gram)[:, 0] > 1e-9)
        return inside

    def times(self, free: FloatArray, direction: FloatArray) -> FloatArray:
        """Return how many times a vector (N, 3) fits into what is free along each normal (N, facets), (N,)."""
        needed = np.abs(direction @ self._normals)
        with np.errstate(divide="ignore", invalid="ignore"):
            fits = np.where(needed > 1e-12, np.maximum(free, 0.0) / needed, np.inf)
        most: FloatArray = fits.min(axis=1, initial=np.inf)
        return most


@lru_cache(maxsize=16)
def envelope_of(axes: Matrix) -> Envelope:
    """Return the envelope of wheels with these axes."""
    return Envelope(np.array(axes))


@dataclass(frozen=True, eq=False)
class Demand:
    """What N episodes ask of the wheels.

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
        When the turn is asked for [s].
    deadline
        When it must be done [s].
    duration
        Length of the episode [s]; later onsets do not count.
    """

    disturbance: FloatArray
    momentum: FloatArray
    effort: FloatArray
    angle: FloatArray
    rate: FloatArray
    start: float
    deadline: float
    duration: float

    @classmethod
    def of_episodes(
        cls,
        initial: Records,
        inertia: Records,
        torque: tuple[Records, Records],
        set_points: Records,
        wheels: WheelArray,
        *,
        turning: bool,
        hold: float,
        duration: float,
    ) -> Demand:
        """Return the demand of drawn episodes: of several set points it takes the last turn.

        Parameters
        ----------
        initial, inertia, set_points
            Records of the initial state (N,), INERTIA (N,) and SET_POINT (N, points).
        torque
            DISTURBANCE records (N,) and HARMONIC records (N, harmonics).
        wheels
            The wheel array.
        turning
            Whether the turn counts; a moving reference asks for none.
        hold
            Seconds on target that the end of an episode must have [s].
        duration
            Length of the episode [s].
        """
        disturbance, harmonics = torque
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
            start=float(set_points["time"][0, -1]),
            deadline=duration - min(hold, duration),
            duration=duration,
        )

    def turning_time(self, acceleration: FloatArray, fastest: FloatArray) -> FloatArray:
        """Return how long stopping and turning take (N,) [s] for what is at hand: (N,) [rad/s^2] and (N,) [rad/s]."""
        with np.errstate(divide="ignore", invalid="ignore"):
            direct = 2.0 * np.sqrt(self.angle / acceleration)
            coasting = self.angle / fastest + fastest / acceleration
            stopping = self.rate / acceleration
            time: FloatArray = np.where(self.angle * acceleration <= fastest**2, direct, coasting) + stopping
        return np.where((acceleration > 0.0) & (fastest > 0.0), time, np.inf)


def label(faults: np.ndarray, wheels: WheelArray, demand: Demand) -> BoolArray:
    """Label episodes as feasible.

    Parameters
    ----------
    faults
        FAULT records (N, m, layers).
    wheels
        The wheel array.
    demand
        What the episodes ask.

    Returns
    -------
    Array (N,) of booleans.
    """
    duration, axes = demand.duration, wheels.axis_matrix
    acting = faults["onset"] < duration
    weakest = faults["effectiveness"] - np.abs(faults["effectiveness_amplitude"])
    effectiveness = np.where(acting, np.maximum(weakest, 0.0), 1.0).prod(axis=2)
    obeys = (effectiveness > 0.0) & ~(acting & (faults["brake"] > 0.0)).any(axis=2)
    effectiveness = np.where(obeys, effectiveness, 0.0)
    length = np.clip(np.minimum(faults["recovery"], duration) - np.minimum(faults["onset"], duration), 0.0, None)
    swing = np.abs(faults["bias_amplitude"]) * length ** faults["bias_exponent"]
    first, last = faults["bias"], faults["bias"] + faults["bias_slope"] * length
    # Faults of one wheel or of several need not act at the same time: each is counted from nothing to its worst.
    highest = np.where(acting, np.maximum(np.maximum(first, last) + swing, 0.0), 0.0).sum(axis=2)
    lowest = np.where(acting, np.minimum(np.minimum(first, last) - swing, 0.0), 0.0).sum(axis=2)

    envelope, nothing, rubbing = envelope_of(wheels.axes), np.zeros((1, 3)), friction_margin(faults, wheels, acting)
    limits = (1.0 - TORQUE_RESERVE) * np.minimum(wheels.torque_limits, UNLIMITED)
    capacity = np.minimum(wheels.momentum_limits, UNLIMITED)
    offered, half = effectiveness * limits, 0.5 * (highest - lowest) + rubbing
    load = 0.5 * (highest + lowest) @ axes.T
    controllable = envelope.contains(load, demand.disturbance, offered, half)

    # A wheel that does not obey pours its uncommanded torque into the body until its momentum limit stops it.
    poured_up = np.where(obeys, 0.0, np.minimum(highest * length.max(axis=2), capacity))
    poured_down = np.where(obeys, 0.0, np.maximum(lowest * length.max(axis=2), -capacity))
    poured, poured_half = 0.5 * (poured_up + poured_down) @ axes.T, 0.5 * (poured_up - poured_down)
    storable = np.where(obeys, capacity, 0.0)
    held = envelope.contains(poured, nothing, storable, poured_half, demand.momentum)

    struck = acting & (faults["kind"] > 0) & (faults["delay"] == 0)
    # The onsets in their order, and behind each the time until the next, or the deadline.
    onsets = np.sort(np.where(struck, faults["onset"], np.inf).reshape(len(faults), -1), axis=1)
    following = np.minimum(np.pad(onsets, ((0, 0), (0, 1)), constant_values=np.inf), demand.deadline)
    smooth = friction_margin(faults, wheels, np.zeros_like(acting))
    before = demand.turning_time(
        envelope.times(envelope.room(nothing, demand.disturbance, limits, smooth)[0], demand.effort),
        envelope.times(envelope.room(nothing, nothing, capacity, 0.0, demand.momentum)[0], demand.effort),
    )
    after = demand.turning_time(
        envelope.times(envelope.room(load, demand.disturbance, offered, half)[0], demand.effort),
        envelope.times(envelope.room(poured, nothing, storable, poured_half, demand.momentum)[0], demand.effort),
    )
    early = demand.start + before <= following[:, 0]
    late = (np.maximum(onsets, demand.start) + after[:, None] <= following[:, 1:]).any(axis=1)
    feasible: BoolArray = controllable & held & (early | late)
    return feasible


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
