"""What the claims of Ma, Wang and Wang 2023 are about: q_e with its sign, w_e, the adaptive gain, largest torques."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ftac_gym import baselines
from ftac_gym.attitude import quaternion_conjugate, quaternion_from_mrp, quaternion_product, rotate_to_body
from ftac_gym.reproduction.flight import Flight
from ftac_gym.reproduction.inverse_dynamics import reference_motion
from ftac_gym.reproduction.variations import UNLIMITED, seconds, with_limit
from ftac_gym.task.initial_state import InitialState
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray

RATE, ACCELERATION = 0.05, 4.71e-3
"""c1 [rad/s] and c2 [rad/s^2] as printed in (44): those of the components; the norms are larger."""


def signed_error(flight: Flight, flipped: bool = False) -> FloatArray:
    """Return q_e (T + 1, N, 4), scalar first, continuous, with the sign that the start has.

    Parameters
    ----------
    flight
        Of a reference that starts at the identity.
    flipped
        Whether the flight's plan was flipped.
    """
    error = quaternion_product(
        quaternion_conjugate(quaternion_from_mrp(flight.reference)), quaternion_from_mrp(flight.attitude)
    )
    apart = np.einsum("tni,tni->tn", error[1:], error[:-1]) < 0.0
    sign = np.cumprod(np.where(apart, -1.0, 1.0), axis=0)
    error[1:] *= sign[..., None]
    start = flight.scenario.initial_state.attitude
    # A random start is drawn with a positive scalar.
    wanted = (-1.0 if flipped else 1.0) * (1.0 if start is None else np.copysign(1.0, start[0]))
    lifted: FloatArray = error * (wanted * np.where(error[:1, :, :1] < 0.0, -1.0, 1.0))
    return lifted


def rate_error(flight: Flight) -> FloatArray:
    """Return w_e (T + 1, N, 3) [rad/s]."""
    turning = reference_motion(flight.scenario.draw(0, 1), flight.time).rate
    error: FloatArray = flight.rate - rotate_to_body(signed_error(flight), turning[:, None, :])
    return error


def went_round(flight: Flight, flipped: bool) -> FloatArray:
    """Return which craft end with the other sign of e_4 than they start with, (N,): those that go the long way."""
    scalar = signed_error(flight, flipped)[..., 0]
    other: FloatArray = scalar[0] * scalar[-1] < 0.0
    return other


def first_torque(flight: Flight) -> FloatArray:
    """Return u1 (T, N, 3) [N m] along a flight of HSFC as printed, by giving the law without u2 what was measured.

    The adaptive gain does not depend on u2.
    """
    craft = flight.error.shape[1]
    built = baselines.make("hsfc", with_limit(flight.scenario, UNLIMITED), craft, smallest_effectiveness=1.0)
    attitude, reference = quaternion_from_mrp(flight.attitude), quaternion_from_mrp(flight.reference)
    motion = reference_motion(flight.scenario.draw(0, 1), flight.time)
    measured = (attitude, flight.rate, reference, motion.rate, motion.acceleration)
    steps = len(flight.command)
    return np.array([built.act(_measurement(*(part[step] for part in measured))) for step in range(steps)])


def _measurement(
    attitude: FloatArray, rate: FloatArray, reference: FloatArray, turning: FloatArray, turning_change: FloatArray
) -> Measurement:
    """Return what N craft with three wheels measure, as far as a law of the paper asks for it."""
    craft = len(attitude)
    return Measurement(
        time=np.zeros(craft),
        attitude=attitude,
        rate=rate,
        wheel_momentum=np.zeros((craft, 3)),
        last_command=np.zeros((craft, 3)),
        star_tracker_valid=np.ones(craft, dtype=np.bool_),
        reference_attitude=reference,
        reference_rate=np.broadcast_to(turning, (craft, 3)),
        reference_acceleration=np.broadcast_to(turning_change, (craft, 3)),
    )


def largest_torque(scenario: Scenario, law: str, gains: Mapping[str, Any], states: int = 20000) -> float:
    """Return the largest component of the torque [N m] at gamma(0) over random attitudes and rates below 1 rad/s."""
    free = with_limit(scenario, UNLIMITED).replace(initial_state=InitialState(max_rate=1.0))
    episodes = free.draw(0, states)
    start = episodes.initial
    built = baselines.make(law, free, states, **gains)
    identity = np.broadcast_to(np.array([1.0, 0.0, 0.0, 0.0]), (states, 4))
    # At time zero w_d = 0 and w_d' is the largest.
    motion = reference_motion(episodes, np.zeros(1))
    torque = built.act(_measurement(start["attitude"], start["rate"], identity, motion.rate[0], motion.acceleration[0]))
    return float(np.abs(torque).max())


def printed_bound(scenario: Scenario, effectiveness: float, gain: float = 5.0) -> float:
    """Return the bound (21) [N m] with the numbers of (44), for g0 and k."""
    largest = float(np.linalg.norm(scenario.spacecraft.inertia_matrix, 2))
    return (gain + largest * (RATE**2 + ACCELERATION)) / effectiveness


def held_to(flight: Flight, first: FloatArray, share: float) -> float:
    """Return the share of time in which (36) holds: w_e'G u2 <= -(1 - g0) |u1| |w_e|.

    Parameters
    ----------
    flight
        A flight of HSFC.
    first
        u1 along it, (T, N, 3) [N m].
    share
        1 - g0.
    """
    first = first[:, 0]
    rate = rate_error(flight)[:-1, 0]
    second = flight.true_effectiveness[:, 0] * (flight.command[:, 0] - first)
    power = np.einsum("ti,ti->t", rate, second)
    asked = -share * np.linalg.norm(first, axis=1) * np.linalg.norm(rate, axis=1)
    return float(np.mean(power <= asked + 1e-9))


def peak(flight: Flight) -> float:
    """Return the largest torque commanded [N m]."""
    return float(np.abs(flight.command).max())


def arrival(flight: Flight, angle: float, window: float = 10.0) -> float:
    """Return when the first craft's error falls below an angle [deg] for good [s].

    Infinity if it is not below throughout the last ``window`` seconds: an error that swings about the angle is below it
    at the end of some flight.
    """
    time = flight.settling(angle)
    return time if time <= flight.time[-1] - window else float("inf")


def arrived(flight: Flight, angle: float, window: float = 10.0) -> str:
    """Say when the first craft's error falls below an angle [deg] for good."""
    return seconds(arrival(flight, angle, window))


def small(angle: float) -> str:
    """Say how large an angle [deg] is, as far as it matters."""
    return f"{angle:.3g} deg" if angle >= 1e-6 else "below 1e-6 deg"
