"""Measures behind the claims of Li, Xu and Chang 2023."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ftac_gym.attitude import quaternion_error, quaternion_from_mrp
from ftac_gym.baselines import synthesis
from ftac_gym.baselines.components.takagi_sugeno import TriangularSets
from ftac_gym.reproduction.recordings import Recording, below_from
from ftac_gym.utils.parameters import FloatArray

CALM = (15.0, 39.5)
"""Window after the observer's transient and before the faults [s]."""

LENGTH = 200.0
"""The example's duration [s]."""

SETTLED = 1e-2
"""Limit of ``|q_ev|`` below which a manoeuvre counts as complete: 1.1 degrees."""

FIRST, SECOND, LATE = (0.0, 40.0), (80.0, LENGTH), (160.0, LENGTH)
"""The manoeuvres of Table 1, and the end [s]."""


def during(recording: Recording, window: tuple[float, float]) -> npt.NDArray[np.bool_]:
    """Return which of the (T + 1) samples lie in a window of the example; a shorter flight scales the window with it.

    Flights that are shorter by plan are not to be measured in windows.
    """
    scale = min(1.0, recording.time[-1] / LENGTH)
    return np.asarray((recording.time >= window[0] * scale) & (recording.time <= window[1] * scale))


def pointing(recording: Recording) -> FloatArray:
    """Return ``|q_ev|`` (T + 1,) of the first spacecraft."""
    return np.asarray(np.sin(0.5 * np.radians(recording.error[:, 0])))


def largest(recording: Recording, window: tuple[float, float]) -> float:
    """Return the largest ``|q_ev|`` in a window."""
    return float(pointing(recording)[during(recording, window)].max())


def final(recording: Recording) -> float:
    """Return the largest ``|q_ev|`` from 160 to 200 s."""
    return largest(recording, LATE)


def settling(recording: Recording, window: tuple[float, float]) -> float:
    """Return the time from the start of a window until ``|q_ev|`` stays below 0.01 in it [s]; infinity if never."""
    inside = during(recording, window)
    when = recording.time[inside]
    return below_from(when - when[0], pointing(recording)[inside], SETTLED)


def rate_error(recording: Recording, window: tuple[float, float]) -> float:
    """Return the largest ``|w - w^|`` in a window [rad/s]."""
    assert recording.rate_mismatch is not None
    size = np.linalg.norm(recording.rate_mismatch[:, 0], axis=1)
    return float(size[during(recording, window)[:-1]].max())


def fault_torque(recording: Recording) -> FloatArray:
    """Return the torque of the faults, (E - I) u + f (T, 3) [N m]: the example's wheels lie along the body axes."""
    torque: FloatArray = (recording.true_effectiveness[:, 0] - 1.0) * recording.command[:, 0] + recording.true_bias[
        :, 0
    ]
    return torque


def fault_error(recording: Recording, window: tuple[float, float]) -> FloatArray:
    """Return the root mean square of f^ - f in a window, (3,) [N m]."""
    assert recording.disturbance is not None
    error = (recording.disturbance[:, 0] - fault_torque(recording))[during(recording, window)[:-1]]
    return np.asarray(np.sqrt((error**2).mean(axis=0)))


def fault_error_norm(recording: Recording, window: tuple[float, float]) -> float:
    """Return the norm of :func:`fault_error` over the channels [N m]."""
    return float(np.linalg.norm(fault_error(recording, window)))


def vibration_error(recording: Recording, window: tuple[float, float]) -> tuple[float, float]:
    """Return the root mean squares of d^ - d and of d in a window [N m]."""
    assert recording.vibration is not None
    inside = during(recording, window)[:-1]
    truth = recording.true_vibration[:-1, 0][inside]
    return _size(recording.vibration[:, 0][inside] - truth), _size(truth)


def shaking(recording: Recording, window: tuple[float, float]) -> float:
    """Return the root mean square of the modes' torque on the body in a window [N m]."""
    return _size(recording.true_vibration[:, 0][during(recording, window)])


def _size(vectors: FloatArray) -> float:
    """Return the root mean square of vectors (T, 3)."""
    return float(np.sqrt((vectors**2).sum(axis=1).mean()))


def energy_at(recording: Recording, moment: float) -> float:
    """Return the energy of the modes at a moment of the example, the mean of 4 s about it [J]."""
    return float(recording.modal_energy[during(recording, (moment - 2.0, moment + 2.0)), 0].mean())


def virtual_control(recording: Recording) -> tuple[float, float]:
    """Return the largest ``|s|`` [rad/s] and ``|sum h_i K_i s|`` [N m] at the manoeuvres' starts; published gains."""
    sets, feedback = TriangularSets(), synthesis.published().controller.feedback
    attitude, reference = (quaternion_from_mrp(part[:, 0]) for part in (recording.attitude, recording.reference))
    variable = recording.rate[:, 0] + 2.0 * quaternion_error(attitude, reference)[:, 1:]
    torque = np.einsum("nr,rij,nj->ni", sets(recording.rate[:, 0]), feedback, variable)
    starts = [int(np.flatnonzero(during(recording, window))[0]) for window in (FIRST, SECOND)]
    largest_variable, largest_control = (np.linalg.norm(part[starts], axis=1).max() for part in (variable, torque))
    return float(largest_variable), float(largest_control)


def any_at_limit(recording: Recording) -> float:
    """Return the share of time in which at least one wheel is commanded its limit."""
    return float(recording.at_limit().any(axis=1).mean())


def lag(recording: Recording) -> float:
    """Return the delay of the first channel of f^ from 110 to 195 s for which it fits f best [s]."""
    assert recording.disturbance is not None
    inside = np.flatnonzero(during(recording, (110.0, 195.0))[:-1])
    estimate, truth = recording.disturbance[inside, 0, 0], fault_torque(recording)[:, 0]
    period = recording.scenario.control_period
    shifts = range(min(inside[0], round(3.0 / period)) + 1)
    misfits = [float(((estimate - truth[inside - shift]) ** 2).sum()) for shift in shifts]
    return int(np.argmin(misfits)) * period


def axis_errors(recording: Recording) -> tuple[float, float]:
    """Return the largest ``|sigma_i - sigma_d,i|`` from 160 to 200 s on the axes of the two faults."""
    late = during(recording, LATE)
    errors = np.abs(recording.attitude[late, 0] - recording.reference[late, 0]).max(axis=0)
    return float(errors[0]), float(errors[1])
