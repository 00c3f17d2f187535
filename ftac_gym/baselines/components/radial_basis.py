"""Gaussian nodes, and a radial basis function network that learns a torque from the body rate."""

from __future__ import annotations

import numpy as np

from ftac_gym.baselines.components.rows import dot
from ftac_gym.baselines.memory import Memory
from ftac_gym.utils.parameters import FloatArray, non_negative, positive


class GaussianNodes:
    """exp(-``|x - c_k|^2`` / width^2) with centres c_k evenly on the diagonal.

    Parameters
    ----------
    count
        Number of nodes.
    reach
        Each coordinate of the last centre, and minus that of the first.
    inputs
        Number of inputs.
    width
        Width of each node.

    Raises
    ------
    ValueError
        If the width is not positive.
    """

    def __init__(self, count: int, reach: float, inputs: int, width: float) -> None:
        self._centres = np.linspace(-reach, reach, count)[:, None] * np.ones(inputs)
        self._squares = (self._centres**2).sum(axis=1)
        self._scale = -1.0 / positive(width, "width") ** 2

    def exponents(self, inputs: FloatArray) -> FloatArray:
        """Return -``|x - c_k|^2`` / width^2 (N, count) for inputs (N, inputs)."""
        squares = dot(inputs, inputs) - 2.0 * (inputs @ self._centres.T) + self._squares
        exponents: FloatArray = self._scale * squares
        return exponents


class RadialBasisNetwork:
    """d^ = W' phi(w) with phi_k = exp(-``|w - c_k|^2`` / width^2), trained by W' = gain phi s' J^-1.

    Eqs. (25)-(28), (42) and (75) of Zhang and Zhou 2019; the known approximation error, which the paper adds to d^, is
    zero. Nodes are not given in the paper: five of them on the diagonal from -1 to 1 rad/s, width 1 rad/s.

    Parameters
    ----------
    memory
        Store of the weights.
    gain
        Learning gain; zero switches the network off.
    inverse_inertia
        J^-1 (3, 3) [1/(kg m^2)].
    period
        Time between two updates [s].
    nodes
        Number of nodes.
    width
        Width of each node [rad/s].
    """

    def __init__(
        self,
        memory: Memory,
        gain: float,
        inverse_inertia: FloatArray,
        period: float,
        nodes: int = 5,
        width: float = 1.0,
    ) -> None:
        self._gain = non_negative(gain, "network_gain") * period
        self._memory = memory
        self._inverse_inertia = inverse_inertia
        self._nodes = GaussianNodes(nodes, 1.0, 3, width)
        memory.add("network_weights", (nodes, 3))

    def torque(self, rate: FloatArray, variable: FloatArray) -> FloatArray:
        """Return d^ (N, 3) [N m] at the rates w (N, 3) [rad/s], then learn from s (N, 3) [rad/s]."""
        if self._gain == 0.0:
            return np.zeros_like(rate)
        basis = np.exp(self._nodes.exponents(rate))
        weights = self._memory["network_weights"]
        torque: FloatArray = np.einsum("nk,nki->ni", basis, weights)
        step = variable @ self._inverse_inertia
        self._memory["network_weights"] = weights + self._gain * basis[:, :, None] * step[:, None, :]
        return torque
