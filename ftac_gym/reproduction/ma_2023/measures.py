"""Measures behind the claims of Ma, Wang and Wang 2023: q_e with its sign, w_e, adaptive gain, largest torques."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ftac_gym import baselines
from ftac_gym.attitude import quaternion_conjugate, quaternion_from_mrp, quaternion_product, rotate_to_body
from ftac_gym.reproduction.inverse_dynamics import reference_motion
from ftac_gym.reproduction.recordings import Plan, Recording
from ftac_gym.reproduction.variations import UNLIMITED, with_limit
from ftac_gym.reproduction.wording import seconds
from ftac_gym.task.initial_state import InitialState
from ftac_gym.task.measurement import Measurement
from ftac_gym.task.scenario import Scenario
from ftac_gym.utils.parameters import FloatArray
from ftac_gym.utils.randomness import Stream, keys_from_seeds, uniforms

GAIN = 5.0
"""k [N m]."""

LAYER = 0.005
"""Epsilon of (43) [rad/s]."""

RATE, ACCELERATION = 0.05, 4.71e-3
"""c1 [rad/s] and c2 [rad/s^2] as printed in (44): those of the components; the norms are larger."""


def signed_error(recording: Recording) -> FloatArray:
    """Return q_e (T + 1, N, 4), scalar first, continuous, with the sign of the start.

    The reference must start at the identity.
    """
    error = quaternion_product(
        quaternion_conjugate(quaternion_from_mrp(recording.reference)), quaternion_from_mrp(recording.attitude)
    )
    apart = np.einsum("tni,tni->tn", error[1:], error[:-1]) < 0.0
    sign = np.cumprod(np.where(apart, -1.0, 1.0), axis=0)
    error[1:] *= sign[..., None]
    start = recording.scenario.initial_state.attitude
    # A random start is drawn with a positive scalar.
    first = (-1.0 if recording.plan.flipped else 1.0) * (1.0 if start is None else np.copysign(1.0, start[0]))
    return np.asarray(error * (first * np.where(error[:1, :, :1] < 0.0, -1.0, 1.0)))


def rate_error(recording: Recording) -> FloatArray:
    """Return w_e (T + 1, N, 3) [rad/s]."""
    turning = reference_motion(recording.scenario.draw(0, 1), recording.time).rate
    return np.asarray(recording.rate - rotate_to_body(signed_error(recording), turning[:, None, :]))


def went_round(recording: Recording) -> npt.NDArray[np.bool_]:
    """Return the spacecraft whose e_4 ends with the other sign than it starts with, (N,): they turn the long way."""
    scalar = signed_error(recording)[..., 0]
    return np.asarray(scalar[0] * scalar[-1] < 0.0)


def first_torque(recording: Recording) -> FloatArray:
    """Return u1 (T, N, 3) [N m] along a flight of HSFC as printed, from the law without u2 at the same measurements.

    The adaptive gain does not depend on u2.
    """
    count = recording.error.shape[1]
    built = baselines.build("hsfc", with_limit(recording.scenario, UNLIMITED), count, smallest_effectiveness=1.0)
    attitude, reference = quaternion_from_mrp(recording.attitude), quaternion_from_mrp(recording.reference)
    motion = reference_motion(recording.scenario.draw(0, 1), recording.time)
    measured = (attitude, recording.rate, reference, motion.rate, motion.acceleration)
    steps = len(recording.command)
    return np.array([built.act(_measurement(*(part[step] for part in measured))) for step in range(steps)])


def _measurement(
    attitude: FloatArray, rate: FloatArray, reference: FloatArray, turning: FloatArray, turning_change: FloatArray
) -> Measurement:
    """Return the measurement of N spacecraft with three wheels, as far as a baseline of the paper needs it."""
    count = len(attitude)
    return Measurement(
        time=np.zeros(count),
        attitude=attitude,
        rate=rate,
        wheel_momentum=np.zeros((count, 3)),
        last_command=np.zeros((count, 3)),
        star_tracker_valid=np.ones(count, dtype=np.bool_),
        reference_attitude=reference,
        reference_rate=np.broadcast_to(turning, (count, 3)),
        reference_acceleration=np.broadcast_to(turning_change, (count, 3)),
    )


def largest_torque(plan: Plan, states: int = 20000) -> float:
    """Return the largest component of a plan's torque at gamma(0) over random attitudes and rates below 1 rad/s [N m].

    The wheels are unlimited.
    """
    free = with_limit(plan.scenario, UNLIMITED)
    wheels, starts = free.spacecraft.wheels, InitialState(max_rate=1.0)
    # The states alone: whole episodes would be labelled too.
    keys, numbers = np.repeat(keys_from_seeds([0]), states, axis=0), np.arange(states)
    start = starts.draw(
        uniforms(keys, numbers, Stream.INITIAL_STATE, starts.uniform_count(wheels.count)), wheels.momentum_limits
    )
    built = baselines.build(plan.baseline, free, states, **plan.gains)
    identity = np.broadcast_to(np.array([1.0, 0.0, 0.0, 0.0]), (states, 4))
    # At time zero w_d = 0 and w_d' is the largest.
    motion = reference_motion(free.draw(0, 1), np.zeros(1))
    torque = built.act(_measurement(start["attitude"], start["rate"], identity, motion.rate[0], motion.acceleration[0]))
    return float(np.abs(torque).max())


def printed_bound(scenario: Scenario, effectiveness: float) -> float:
    """Return the bound (21) [N m] with the numbers of (44), for g0 and k."""
    largest = float(np.linalg.norm(scenario.spacecraft.inertia_matrix, 2))
    return (GAIN + largest * (RATE**2 + ACCELERATION)) / effectiveness


def compensating(recording: Recording, share: float) -> float:
    """Return the share of time in which (36) holds along a flight of HSFC: w_e'G u2 <= -(1 - g0) ``|u1|`` ``|w_e|``.

    Parameters
    ----------
    recording
        The flight.
    share
        1 - g0.
    """
    first = first_torque(recording)[:, 0]
    rate = rate_error(recording)[:-1, 0]
    second = recording.true_effectiveness[:, 0] * (recording.command[:, 0] - first)
    power = np.einsum("ti,ti->t", rate, second)
    asked = -share * np.linalg.norm(first, axis=1) * np.linalg.norm(rate, axis=1)
    return float(np.mean(power <= asked + 1e-9))


def arrival(recording: Recording, angle: float, window: float = 10.0) -> float:
    """Return the time from which the first spacecraft's error stays below an angle [deg], [s].

    It is infinite if the error is not below throughout the last ``window`` seconds: the end of a flight can cut an
    oscillation about the angle.
    """
    time = recording.settling(angle)
    return time if time <= recording.time[-1] - window else float("inf")


def arrived(recording: Recording, angle: float, window: float = 10.0) -> str:
    """Return :func:`arrival` as text."""
    return seconds(arrival(recording, angle, window))


def small(angle: float) -> str:
    """Return an angle [deg] as text; below 1e-6 deg it is rounding."""
    return f"{angle:.3g} deg" if angle >= 1e-6 else "below 1e-6 deg"


def creeping(recording: Recording) -> tuple[float, float]:
    """Return the largest ``|w_e,i|`` after 10 s [rad/s], and the share of that time with all within the layer."""
    speed = np.abs(rate_error(recording)[recording.time > 10.0, 0]).max(axis=1)
    return float(speed.max()), float(np.mean(speed <= LAYER))


def left_off(recording: Recording) -> npt.NDArray[np.bool_]:
    """Return the spacecraft with an error above 0.1 deg at the end, (N,)."""
    return np.asarray(recording.error[-1] > 0.1)


def resonance(recording: Recording, smoothing: float = 0.05) -> tuple[float, float]:
    """Return the lowest and highest natural frequency sqrt(G k / (2 delta J)) of HSFC near the target [rad/s]."""
    inertia = np.linalg.eigvalsh(recording.scenario.spacecraft.inertia_matrix)
    stiffness = float(recording.true_effectiveness.mean()) * GAIN / (2.0 * smoothing)
    return float(np.sqrt(stiffness / inertia.max())), float(np.sqrt(stiffness / inertia.min()))


def margins(recording: Recording, until: float) -> FloatArray:
    """Return g^2 - 2 alpha k ``|e_v|^2`` / delta where S first comes within the layer, (N,); nan if after a time [s].

    There e_v' = -g^2 e_v / 2 and (g^2)' = -2 alpha k ``|e_v|^2`` g^2 / delta, near the target. The difference is
    constant and equals the final g^2.
    """
    gamma, gains = recording.memory["gamma"][recording.time < until, :, 0], recording.plan.gains
    axis = signed_error(recording)[: len(gamma), :, 1:]
    variable = recording.rate[: len(gamma)] + gamma[..., None] ** 2 * axis
    within = (np.abs(variable) <= gamma[..., None] ** 2 * gains["smoothing"]).all(axis=2)
    first = within.argmax(axis=0), np.arange(gamma.shape[1])
    square = np.einsum("tni,tni->tn", axis, axis)
    left = gamma[first] ** 2 - 2.0 * gains["adaptation"] * GAIN * square[first] / gains["smoothing"]
    return np.asarray(np.where(within.any(axis=0), left, np.nan))
