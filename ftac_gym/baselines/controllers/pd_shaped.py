"""PD control about a slew that leaves the appendages at rest."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from ftac_gym.attitude import (
    cross,
    quaternion_conjugate,
    quaternion_from_rotation_vector,
    quaternion_product,
    rotation_vector_from_quaternion,
)
from ftac_gym.baselines.components.input_shaping import SIGNS, rest_to_rest, shaper_of
from ftac_gym.baselines.controllers.pd import PDDisturbanceObserver, PDDisturbanceObserverGains
from ftac_gym.baselines.gains import Range, changed, parameter
from ftac_gym.baselines.memory import BoolArray
from ftac_gym.baselines.rules import at_most, optional, whole_number
from ftac_gym.task.measurement import Measurement
from ftac_gym.utils.parameters import FloatArray

_FIRST_AXIS = np.array([1.0, 0.0, 0.0])


@dataclass(frozen=True)
class ShapedPDGains(PDDisturbanceObserverGains):
    """Gains of :class:`ShapedPD`."""

    # The prediction has no modes, and the slow return near the target would disturb the shaped end of a slew.
    prediction: bool = changed(PDDisturbanceObserverGains, "prediction", default=False)
    calm_share: float = changed(PDDisturbanceObserverGains, "calm_share", default=0.0, search=None)
    braking_share: float = changed(PDDisturbanceObserverGains, "braking_share", schedule=(0.1, 1.0))
    # Not scheduled: the plan, which is made once for a slew, has the same limit.
    rate_limit: float = changed(
        PDDisturbanceObserverGains,
        "rate_limit",
        meaning="Largest commanded rate, of the turn and of catching up with it",
        schedule=None,
    )
    position_gain: float = changed(PDDisturbanceObserverGains, "position_gain", schedule=(0.1, 0.8))
    acceleration_share: float = parameter(
        0.5, "Share of the acceleration of healthy wheels for turn and stop", "", at_most(1.0), Range(0.2, 0.9)
    )
    order: int = parameter(2, "Order of the shaper of each mode: 1 for ZV, 2 for ZVD", rule=whole_number(1))
    shaped_modes: int | None = parameter(
        None, "Number of modes to shape for, lowest first", rule=optional(whole_number(0))
    )


class ShapedPD(PDDisturbanceObserver):
    """``pd_dob`` about a shaped slew instead of about the set point.

    The first call, and each after a change of the set point, plans a motion from the attitude q_0 and rate w_0 to the
    set point::

        q_d(t) = q_0 (x) [n theta(t)] (x) [m phi(t)],    w_d = m phi' + C(m phi) n theta'

    where [.] is the quaternion of a rotation vector. phi removes w_0 about its own axis m, from phi' = ``|w_0|`` to
    rest; theta turns from rest to rest about the axis n that leads to the set point from the end of that stop. Both are
    accelerated by at most a share of the acceleration that healthy wheels can give about their axes. The rest is for
    feedback, weak wheels and the gyroscopic torque. Both are convolved with an input shaper for the clamped modes
    (:mod:`~ftac_gym.baselines.components.input_shaping`; Singer and Seering 1990). phi stays small, so that w_d' is
    nearly linear in the shaped accelerations: a hub that follows leaves the modes at rest.

    The torque is that of ``pd_dob`` for the errors with respect to q_d and w_d, with a feed-forward of J times the mean
    w_d' of the coming period. A spacecraft that falls behind because of a fault brakes in time by the profile of
    :class:`~ftac_gym.baselines.controllers.pd.PD`. Far from the plan the controller is ``pd_dob``, without a state that
    could wind up, and the plan ends at the set point.

    Raises
    ------
    ValueError
        If the reference moves, a gain breaks a rule, or a wheel has no torque limit.
    """

    gains = ShapedPDGains()
    rest_only: ClassVar[str] = "the slew is planned to an attitude that stays"

    def _build(self) -> None:
        super()._build()
        self._shaper = shaper_of(self.scenario.spacecraft.appendages, self.gains.order, self.gains.shaped_modes)
        # The PD law follows the plan, which moves.
        self._moving = True
        memory = self.memory
        memory.add("slew_unplanned", (), initial=True)
        memory.add("slew_set_point", (4,))
        memory.add("slew_start", ())
        # Steps of the accelerations of turn and stop at five times: four of the turn, then the end of the stop. The
        # times are stored twice, the second time relative to the end of the period.
        memory.add("slew_weights", (5, 2))
        memory.add("slew_switches", (10,))
        memory.add("slew_first_rate", (1,))
        # Terms of the planned attitude and rate.
        memory.add("slew_attitudes", (4, 4))
        memory.add("slew_axes", (4, 3))

    def act(self, measurement: Measurement) -> FloatArray:
        """Return the wheel torques to command, (N, wheels) [N m]."""
        return super().act(self._planned(measurement))

    def _planned(self, measurement: Measurement) -> Measurement:
        """Return the measurement with the planned motion for its reference."""
        memory = self.memory
        new = (memory["slew_set_point"] != measurement.reference_attitude).any(axis=1) | memory["slew_unplanned"]
        if new.any():
            self._plan(measurement.take(np.flatnonzero(new)), new)
        since = (measurement.time - memory["slew_start"])[:, None] - memory["slew_switches"]
        ramp, parabola = self._shaper.ramp_and_parabola(since)
        # By time, now and one period later, and by motion, turn and stop.
        rates = ramp.reshape(-1, 2, 5) @ memory["slew_weights"]
        angles = parabola.reshape(-1, 2, 5) @ memory["slew_weights"]
        # The stop changes the first rate, which lasts until then; the first switch is at time zero.
        first_rate = memory["slew_first_rate"]
        stop = angles[:, :, 1] + first_rate * since[:, ::5]
        turn_rate = rates[:, :, 0]
        along = np.empty((len(since), 2, 4))
        along[:, :, 0] = rates[:, :, 1] + first_rate
        along[:, :, 1] = turn_rate
        along[:, :, 2] = turn_rate * np.cos(stop)
        along[:, :, 3] = turn_rate * np.sin(stop)
        rate = along @ memory["slew_axes"]
        half_turn, half_stop = 0.5 * angles[:, 0, 0], 0.5 * stop[:, 0]
        cosine, sine = np.cos(half_turn), np.sin(half_turn)
        stopped, stopping = np.cos(half_stop), np.sin(half_stop)
        parts = np.stack((cosine * stopped, sine * stopped, cosine * stopping, sine * stopping), axis=1)
        return replace(
            measurement,
            reference_attitude=np.einsum("ni,nij->nj", parts, memory["slew_attitudes"]),
            reference_rate=rate[:, 0],
            # The mean over the coming period: with it the hub has the planned rate at its end.
            reference_acceleration=(rate[:, 1] - rate[:, 0]) / self._period,
        )

    def _plan(self, measurement: Measurement, new: BoolArray) -> None:
        """Plan the motion of the n spacecraft in the mask (N,) from their measurement."""
        attitude, set_point = measurement.attitude, measurement.reference_attitude
        first_rate, stop_axis = _length_and_direction(measurement.rate)
        stop_acceleration = self._acceleration(stop_axis)
        stop_end = first_rate / stop_acceleration
        stop_angle = first_rate * (self._shaper.mean_delay + 0.5 * stop_end)
        # The turn leads to the set point from the attitude at the end of the stop alone.
        before_stop = quaternion_product(set_point, _rotation(stop_axis, -stop_angle))
        to_turn = rotation_vector_from_quaternion(quaternion_product(quaternion_conjugate(attitude), before_stop))
        angle, axis = _length_and_direction(to_turn)
        turn = rest_to_rest(angle, self._acceleration(axis), self.scheduled.rate_limit)

        switches = np.concatenate((turn.switches, stop_end[:, None]), axis=1)
        weights = np.zeros((len(angle), 5, 2))
        weights[:, :4, 0] = turn.acceleration[:, None] * SIGNS
        weights[:, 0, 1], weights[:, 4, 1] = -stop_acceleration, stop_acceleration
        # [n theta] is cos(theta / 2) + sin(theta / 2) n, so that the planned attitude is a sum of four products.
        turned = quaternion_product(attitude, _pure(axis))
        stopping = _pure(stop_axis)
        products = (attitude, turned, quaternion_product(attitude, stopping), quaternion_product(turned, stopping))
        # C(m phi) n is the part of n along m, and the part across it turned by phi.
        parallel = np.vecdot(stop_axis, axis)[:, None] * stop_axis
        axes = (stop_axis, parallel, axis - parallel, cross(axis, stop_axis))
        planned = {
            "slew_unplanned": np.zeros(len(angle), dtype=np.bool_),
            "slew_set_point": set_point,
            "slew_start": measurement.time,
            "slew_weights": weights,
            "slew_switches": np.concatenate((switches, switches - self._period), axis=1),
            "slew_first_rate": first_rate[:, None],
            "slew_attitudes": np.stack(products, axis=1),
            "slew_axes": np.stack(axes, axis=1),
        }
        for name, rows in planned.items():
            array = self.memory[name].copy()
            array[new] = rows
            self.memory[name] = array

    def _acceleration(self, axis: FloatArray) -> FloatArray:
        """Return the planned acceleration about axes (n, 3): a share of that of healthy wheels, (n,) [rad/s^2]."""
        per_acceleration = np.abs(self._minimax(axis @ self._inertia)) / self._torque_limits
        acceleration: FloatArray = self.gains.acceleration_share / per_acceleration.max(axis=1)
        return acceleration


def _length_and_direction(vectors: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return lengths (n,) and unit vectors (n, 3) of vectors (n, 3); zero points along the first axis."""
    length = np.sqrt(np.vecdot(vectors, vectors))
    some = (length > 0.0)[:, None]
    direction = np.where(some, vectors, _FIRST_AXIS) / np.where(some, length[:, None], 1.0)
    return length, direction


def _rotation(axis: FloatArray, angle: FloatArray) -> FloatArray:
    return quaternion_from_rotation_vector(axis * angle[:, None])


def _pure(vectors: FloatArray) -> FloatArray:
    """Return quaternions (n, 4) without a scalar part."""
    return np.concatenate((np.zeros((len(vectors), 1)), vectors), axis=1)
