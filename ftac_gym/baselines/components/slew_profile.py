"""The slew profile: the rate and the deceleration that are demanded on the way to the target."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ftac_gym.attitude import cross
from ftac_gym.baselines.components.allocation import MinimaxAllocation
from ftac_gym.baselines.components.rows import length
from ftac_gym.spacecraft.envelope import envelope_normals
from ftac_gym.spacecraft.wheel_array import WheelArray
from ftac_gym.utils.parameters import FloatArray

LEAST = 0.05
"""Lower bound of acceleration and rate limit over their nominal values: a slew always starts."""


@dataclass(frozen=True, eq=False)
class PlantEstimate:
    """Estimates of what differs from the nominal spacecraft; None for what is nominal.

    Attributes
    ----------
    inertia
        (N, 3, 3) inertia in body axes [kg m^2].
    momentum
        (N, 3) angular momentum of body and wheels together, J w + D h, in body axes [N m s].
    missing_torque
        (N, 3) torque on the body that the wheels have to cancel, of either sign, in body axes [N m].
    usable
        (N, m) usable share of each wheel's torque limit: 0 for a wheel without torque.
    residual
        (N, 3) torque on the body of the last control period that neither commands nor estimated faults explain, in body
        axes [N m].
    """

    inertia: FloatArray | None = None
    momentum: FloatArray | None = None
    missing_torque: FloatArray | None = None
    usable: FloatArray | None = None
    residual: FloatArray | None = None

    def torque_of(self, acceleration: FloatArray, nominal_inertia: FloatArray) -> FloatArray:
        """Return the inertia times accelerations (N, 3) [rad/s^2], (N, 3) [N m]."""
        if self.inertia is None:
            return acceleration @ nominal_inertia
        torque: FloatArray = np.einsum("nij,nj->ni", self.inertia, acceleration)
        return torque


@dataclass(frozen=True, eq=False)
class SlewDemand:
    """Demanded motion along the error axis of N spacecraft.

    Attributes
    ----------
    axis
        n (N, 3), body axes: a turn by -angle about it leads to the target.
    angle
        theta (N, 1), the error angle [rad].
    speed
        s (N, 1), the demanded rate of decrease of theta [rad/s]: the demanded rate error is -s n.
    deceleration
        (N, 1) the rate of decrease of s along the profile [rad/s^2]: the demanded acceleration is this along n.
    braking
        a (N, 1), the deceleration of the part with constant braking [rad/s^2].
    """

    axis: FloatArray
    angle: FloatArray
    speed: FloatArray
    deceleration: FloatArray
    braking: FloatArray


class SlewProfile:
    """Demanded rate over error angle: linear near the target, then constant braking, then the rate limit.

    ::

        s = c theta,                            theta <= a / c^2
        s = sqrt(2 a (theta - a / (2 c^2))),    beyond
        s <= rate limit

    so that value and slope are continuous at theta = a / c^2 and the braking never exceeds a. That is a share b of the
    deceleration that the wheels can give about the error axis n. The set of torques that wheels of reach r_j can give
    is the zonotope ``|m.t|`` <= sum_j r_j ``|m.D[:, j]|`` for the normals m of all pairs of wheel axes. With the
    nominal wheels the largest multiple of J n in it is that of the allocation with the smallest largest share.

    Close to the target the return is no faster than a calm speed s_c, so that the rate stays on target: s <= s_c + c
    max(theta - theta_c, 0).

    An estimate of the plant sets a, and lowers the rate limit. Each torque takes a share of the support of the zonotope
    along m, here without sign. That of the missing torque is d_m, that of the gyroscopic torque n x H at 1 rad/s is
    g_m, and that of the torque J n for 1 rad/s^2 is j_m::

        rate limit = min(nominal, momentum share * min_m (1 - d_m) / g_m),
        a = b min_m (1 - d_m - w g_m) / j_m,    w = min(rate limit, sqrt(2 b theta min_m (1 - d_m) / j_m))

    w is the largest rate of a slew that brakes from here. Neither falls below a twentieth of its nominal value.

    Parameters
    ----------
    wheels
        The wheel array, with torque limits.
    inertia
        (3, 3) nominal inertia [kg m^2].
    allocation
        Allocation with the smallest largest share of these wheels.
    """

    def __init__(self, wheels: WheelArray, inertia: FloatArray, allocation: MinimaxAllocation) -> None:
        self._inertia, self._limits, self._minimax = inertia, wheels.torque_limits, allocation
        self._normals = envelope_normals(wheels.axis_matrix).T
        self._across = np.abs(wheels.axis_matrix.T @ self._normals)

    def __call__(
        self,
        error: FloatArray,
        position_gain: float | FloatArray,
        rate_limit: float | FloatArray,
        braking_share: float | FloatArray,
        momentum_share: float | FloatArray = 0.92,
        plant: PlantEstimate | None = None,
        calm_angle: float = 0.0,
        calm_speed: float = 0.0,
        stiffness: float | FloatArray | None = None,
    ) -> SlewDemand:
        """Return the demanded motion for quaternion errors.

        Parameters
        ----------
        error
            (N, 4) q_e, the short way.
        position_gain
            c, the slope near the target [1/s]; this and the next three are numbers or (N, 1).
        rate_limit
            [rad/s].
        braking_share
            b.
        momentum_share
            Share of the torque that the gyroscopic torque of the stored momentum may take.
        plant
            Estimate of the plant; None for the nominal one.
        calm_angle, calm_speed
            Angle [rad] within which s is at most this speed [rad/s]; zero for no such limit.
        stiffness
            k [1/s^2] of a law that lags behind a constant deceleration a by the angle a / k: the demand is that of
            the angle theta + a / k. None for a law with a feed-forward.
        """
        vector = error[:, 1:]
        sine = length(vector)
        angle = 2.0 * np.arctan2(sine, error[:, :1])
        axis = vector / np.maximum(sine, 1e-12)
        # The acceleration that the wheels can give about the axis: inverse of the share of their limits for 1 rad/s^2.
        per_acceleration = np.abs(self._minimax(axis @ self._inertia)) / self._limits
        braking = braking_share / np.maximum(per_acceleration.max(axis=1, keepdims=True), 1e-12)
        if plant is not None:
            braking, rate_limit = self._with(plant, axis, angle, braking, rate_limit, braking_share, momentum_share)
        true_angle, gain = angle, position_gain
        if stiffness is not None:
            angle = angle + braking / stiffness
        linear = braking / (gain * gain)
        far = angle > linear
        speed = np.where(far, np.sqrt(2.0 * braking * np.maximum(angle - 0.5 * linear, 0.0)), gain * angle)
        deceleration = np.where(far, braking, gain * gain * angle)
        slope = np.where(far, braking / np.maximum(speed, 1e-12), gain)
        if calm_angle > 0.0:
            calm = calm_speed + gain * np.maximum(angle - calm_angle, 0.0)
            slow = (speed > calm) & ~far
            speed = np.where(slow, calm, speed)
            slope = np.where(slow & (angle <= calm_angle), 0.0, slope)
            deceleration = np.where(slow, slope * calm, deceleration)
        fast = speed > rate_limit
        speed = np.where(fast, rate_limit, speed)
        deceleration = np.where(fast, 0.0, deceleration)
        return SlewDemand(axis, true_angle, speed, deceleration, braking)

    def _with(
        self,
        plant: PlantEstimate,
        axis: FloatArray,
        angle: FloatArray,
        nominal_braking: FloatArray,
        nominal_limit: float | FloatArray,
        braking_share: float | FloatArray,
        momentum_share: float | FloatArray,
    ) -> tuple[FloatArray, FloatArray]:
        """Return braking and rate limit (N, 1) with an estimate of the plant."""
        reach = self._limits if plant.usable is None else self._limits * plant.usable
        # Wheels that do not span space have no support along some normal.
        support = np.maximum(reach @ self._across, 1e-9 * (self._limits @ self._across))
        free: float | FloatArray = 1.0
        if plant.missing_torque is not None:
            free = np.maximum(1.0 - np.abs(plant.missing_torque @ self._normals) / support, 0.0)
        per_acceleration = np.abs(plant.torque_of(axis, self._inertia) @ self._normals) / support
        per_acceleration = np.maximum(per_acceleration, 1e-12)
        braking = braking_share * (free / per_acceleration).min(axis=1, keepdims=True)
        limit = nominal_limit + np.zeros_like(angle)
        if plant.momentum is not None:
            per_rate = np.abs(cross(axis, plant.momentum) @ self._normals) / support
            most = (free / np.maximum(per_rate, 1e-12)).min(axis=1, keepdims=True)
            limit = np.clip(momentum_share * most, LEAST * limit, limit)
            fastest = np.minimum(limit, np.sqrt(2.0 * braking * angle))
            left = np.maximum(free - fastest * per_rate, 0.0)
            braking = braking_share * (left / per_acceleration).min(axis=1, keepdims=True)
        # On target there is no axis; the nominal braking of 1e12 has no meaning there, but is no obstacle.
        return np.maximum(braking, LEAST * nominal_braking), limit
