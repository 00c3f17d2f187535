"""Linear-quadratic regulation of the attitude of a rigid body, sampled."""

from __future__ import annotations

import numpy as np
from scipy.linalg import solve_discrete_are

from ftac_gym.utils.parameters import FloatArray


def sampled_body(inertia: FloatArray, period: float) -> tuple[FloatArray, FloatArray]:
    """Return the matrices of x_{k+1} = A x_k + B tau_k for small errors x = (rotation vector, rate error).

    The torque is held for a period, so that A and B are exact: phi' = w, J w' = tau.

    Parameters
    ----------
    inertia
        (3, 3) J [kg m^2].
    period
        [s].

    Returns
    -------
    A (6, 6) and B (6, 3).
    """
    identity, zero, inverse = np.eye(3), np.zeros((3, 3)), np.linalg.inv(inertia)
    transition = np.block([[identity, period * identity], [zero, identity]])
    return transition, np.vstack([0.5 * period**2 * inverse, period * inverse])


def regulator(transition: FloatArray, effect: FloatArray, state: FloatArray, effort: FloatArray) -> FloatArray:
    """Return the gain K (inputs, states) of u = -K x, which minimises the sum of x' Q x + u' R u.

    K = (R + B' P B)^-1 B' P A with the stabilising solution P of the discrete algebraic Riccati equation.

    Parameters
    ----------
    transition, effect
        A and B of x_{k+1} = A x_k + B u_k.
    state, effort
        Q and R.
    """
    solution = solve_discrete_are(transition, effect, state, effort)
    seen = effect.T @ solution
    return np.linalg.solve(effort + seen @ effect, seen @ transition).astype(np.float64)
