"""Takagi-Sugeno fuzzy model of a flexible spacecraft: eight linear models at the corners of a box of rates."""

from __future__ import annotations

from itertools import product
from typing import Protocol

import numpy as np

from ftac_gym.attitude import skew
from ftac_gym.spacecraft.spacecraft import Spacecraft
from ftac_gym.utils.parameters import FloatArray, positive, require

SECTOR = 0.7
"""Largest rate of the model [rad/s], as in section 5 of Li et al. 2023."""


def corners(bound: float = SECTOR) -> FloatArray:
    """Return the rates (8, 3) [rad/s] at which the rules hold: (+, +, +), (+, +, -), ..., (-, -, -)."""
    return np.array(list(product((bound, -bound), repeat=3)))


_SIGNS = corners(1.0)


class Membership(Protocol):
    """Weights of the rules."""

    def __call__(self, rate: FloatArray) -> FloatArray:
        """Return weights (N, 8), not negative and with sum 1, for rates (N, 3) [rad/s]."""


class TriangularSets:
    """h_i = product over the axes of (1 +- w_j / bound) / 2: the blend is exact for functions affine in the rate.

    Rates beyond the bound are replaced by the bound.

    Parameters
    ----------
    bound
        [rad/s].

    Raises
    ------
    ValueError
        If the bound is not positive.
    """

    def __init__(self, bound: float = SECTOR) -> None:
        self._half = 0.5 / positive(bound, "bound")

    def __call__(self, rate: FloatArray) -> FloatArray:
        """Return the weights (N, 8) of rates (N, 3) [rad/s]."""
        high = np.minimum(np.maximum(0.5 + self._half * rate, 0.0), 1.0)
        pairs = np.stack([high, 1.0 - high], axis=2)
        two = pairs[:, 0, :, None] * pairs[:, 1, None, :]
        weights: FloatArray = (two[:, :, :, None] * pairs[:, 2, None, None, :]).reshape(len(rate), 8)
        return weights


class GaussianSets:
    """h_i proportional to exp(-``|w - w_i|^2`` / (2 width^2)): the blend is an approximation.

    Parameters
    ----------
    bound, width
        [rad/s].

    Raises
    ------
    ValueError
        If a value is not positive.
    """

    def __init__(self, bound: float = SECTOR, width: float = SECTOR) -> None:
        self._corners = corners(positive(bound, "bound"))
        self._sharpness = 0.5 / positive(width, "width") ** 2

    def __call__(self, rate: FloatArray) -> FloatArray:
        """Return the weights (N, 8) of rates (N, 3) [rad/s]."""
        distance = ((rate[:, None, :] - self._corners) ** 2).sum(axis=2)
        # Relative to the nearest corner: far outside of the box all eight underflow.
        weights = np.exp(-self._sharpness * (distance - distance.min(axis=1, keepdims=True)))
        normalised: FloatArray = weights / weights.sum(axis=1, keepdims=True)
        return normalised


class NearestRule:
    """The rule of the nearest corner has weight one; at zero rate the corner is the positive one."""

    def __call__(self, rate: FloatArray) -> FloatArray:
        """Return the weights (N, 8) of rates (N, 3) [rad/s]."""
        signs = np.where(rate >= 0.0, 1.0, -1.0)
        weights: FloatArray = (signs[:, None, :] == _SIGNS).all(axis=2).astype(np.float64)
        return weights


class TakagiSugenoModel:
    """Eqs. (8), (9) of Li et al. 2023 for any spacecraft with appendages and torques t on the body.

    ::

        w' = sum h_i {A_i w + B (t + f + d) + D_i (eta, eta')},   (eta, eta') = varpi - (0, delta w)
        varpi' = A_v varpi + B_v w,   varpi = (eta, eta' + delta w)

    with A_i = -B w_i x J, B = (J - delta' delta)^-1 and D_i = B [delta' K, delta' C - w_i x delta'].

    D_i is taken at the corner w_i as well (printed, it has the rate itself). Both are affine in w, and the blend over
    triangular sets is the nonlinear model itself.

    Parameters
    ----------
    spacecraft
        The nominal spacecraft.
    bound
        Largest rate about each axis [rad/s].

    Raises
    ------
    ValueError
        If the spacecraft is rigid or the bound is not positive.

    Attributes
    ----------
    corners
        w_i (8, 3) [rad/s].
    state
        A_i (8, 3, 3) [1/s].
    input
        B (3, 3) [1/(kg m^2)].
    vibration_input
        D_i (8, 3, 2k).
    vibration
        A_v (2k, 2k).
    rate_to_vibration
        B_v (2k, 3).
    """

    def __init__(self, spacecraft: Spacecraft, bound: float = SECTOR) -> None:
        appendages = spacecraft.appendages
        if appendages is None:
            raise ValueError("appendages must be given: the fuzzy model is one of a flexible spacecraft, got None")
        inertia, coupling = spacecraft.inertia_matrix, appendages.coupling_matrix
        stiffness, damping, count = np.diag(appendages.stiffness), np.diag(appendages.damping), appendages.count
        self.modes = count
        self.corners = corners(positive(bound, "bound"))
        self.input: FloatArray = np.linalg.inv(spacecraft.quick_inertia).astype(np.float64)
        turning = skew(self.corners)
        self.state: FloatArray = -self.input @ turning @ inertia
        pull = np.concatenate([coupling.T @ stiffness, coupling.T @ damping], axis=1)
        carried = np.concatenate([np.zeros((8, 3, count)), turning @ coupling.T], axis=2)
        self.vibration_input: FloatArray = self.input @ (pull - carried)
        self.vibration = np.block([[np.zeros((count, count)), np.eye(count)], [-stiffness, -damping]])
        self.rate_to_vibration = np.concatenate([-coupling, damping @ coupling])
        self._coupling = coupling

    def slopes(
        self, weights: FloatArray, rate: FloatArray, torque: FloatArray, vibration: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return w' (N, 3) and varpi' (N, 2k) of the blended model.

        Parameters
        ----------
        weights
            h (N, 8).
        rate, torque
            w [rad/s] and the whole torque on the body [N m], each (N, 3).
        vibration
            varpi (N, 2k).
        """
        count = self.vibration.shape[0] // 2
        require(vibration.shape[1] == 2 * count, "vibration", f"must have {2 * count} columns", vibration.shape)
        motion = vibration.copy()
        motion[:, count:] -= rate @ self._coupling.T
        own = np.einsum("nr,rij,nj->ni", weights, self.state, rate)
        pulled = np.einsum("nr,rij,nj->ni", weights, self.vibration_input, motion)
        slope: FloatArray = own + pulled + torque @ self.input.T
        return slope, vibration @ self.vibration.T + rate @ self.rate_to_vibration.T
