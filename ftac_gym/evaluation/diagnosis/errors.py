"""Errors of the estimates of faults, beside those of taking every wheel for healthy."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ftac_gym.evaluation.metrics import Rollout
from ftac_gym.evaluation.truth import command_in_effect, true_effect, uncommanded_torque
from ftac_gym.utils.parameters import FloatArray

ERROR_UNITS = {"effectiveness": "-", "bias": "N m", "torque": "N m"}
"""Unit of each error."""


class SquaredErrors(NamedTuple):
    """Sums of squared errors of N episodes, (N,) each.

    Attributes
    ----------
    estimated
        Of the estimates.
    healthy
        Of taking every wheel for healthy, over the same values.
    number
        Number of values.
    """

    estimated: FloatArray
    healthy: FloatArray
    number: FloatArray


def squared_errors(history: Rollout) -> dict[str, SquaredErrors]:
    """Return the sums of squared errors of the estimates of a rollout, by the parts that the estimator has.

    ``effectiveness``
        Of wheels while they can be identified.
    ``bias``
        Of the uncommanded torque of each wheel, in the part that turns the body: biases that cancel there cannot be
        observed by its motion. Without estimates of the effectiveness, the torque that a weak wheel lacks is a part of
        it.
    ``torque``
        Of the torque of all faults on the body, as all parts together estimate it. The external torque and errors of
        the model are no faults, so that an estimate that contains them is wrong by them.

    Parameters
    ----------
    history
        A rollout with estimates.
    """
    given = history.estimates
    assert given is not None
    axes = history.scenario.spacecraft.wheels.axis_matrix
    uncommanded = uncommanded_torque(history)[:-1]
    found: dict[str, SquaredErrors] = {}
    if given.effectiveness is not None or given.bias is not None:
        effects = [true_effect(history, spacecraft) for spacecraft in range(len(history.episodes))]
    if given.effectiveness is not None:
        truth = np.stack([effect.effectiveness[:-1] for effect in effects], axis=1)
        known = np.ones(truth.shape, dtype=np.bool_) if given.identifiable is None else given.identifiable
        found["effectiveness"] = _sums(given.effectiveness - truth, 1.0 - truth, known)
    if given.bias is not None:
        truth = np.stack([effect.bias[:-1] for effect in effects], axis=1)
        truth = truth if given.effectiveness is not None else uncommanded
        turning = np.linalg.pinv(axes) @ axes
        found["bias"] = _sums((given.bias - truth) @ turning, truth @ turning)
    if not found and given.disturbance is None:
        return found
    command = command_in_effect(history)[:-1]
    wheels = np.zeros_like(command)
    wheels += 0.0 if given.effectiveness is None else (given.effectiveness - 1.0) * command
    wheels += 0.0 if given.bias is None else given.bias
    torque = wheels @ axes.T + (0.0 if given.disturbance is None else given.disturbance)
    caused = uncommanded @ axes.T
    found["torque"] = _sums(_length(torque - caused), _length(caused))
    return found


def _length(vectors: FloatArray) -> FloatArray:
    length: FloatArray = np.linalg.norm(vectors, axis=2, keepdims=True)
    return length


def _sums(estimated: FloatArray, healthy: FloatArray, known: npt.NDArray[np.bool_] | None = None) -> SquaredErrors:
    """Return sums over errors (T, N, k), where they are known."""
    weights = np.ones(estimated.shape) if known is None else np.asarray(known, dtype=np.float64)
    return SquaredErrors(
        (weights * estimated**2).sum(axis=(0, 2)),
        (weights * healthy**2).sum(axis=(0, 2)),
        weights.sum(axis=(0, 2)),
    )
