"""From a torque on the body to torques of the wheels."""

from __future__ import annotations

import numpy as np

from ftac_gym.feasibility import envelope_normals
from ftac_gym.parameters import FloatArray, require
from ftac_gym.spacecraft import WheelArray


def pseudo_inverse(axes: FloatArray) -> FloatArray:
    """Return the matrix (m, 3) that gives the smallest sum of squared wheel torques.

    Parameters
    ----------
    axes
        (3, m) wheel axes.

    Raises
    ------
    ValueError
        If the axes do not span space.
    """
    require(int(np.linalg.matrix_rank(axes)) == 3, "axes", "must span three dimensions", axes.tolist())
    inverse: FloatArray = np.linalg.pinv(axes).astype(np.float64)
    return inverse


class MinimaxAllocation:
    """The wheel torques whose largest share of its wheel's limit is as small as can be.

    The set of torques that wheels with limits r_j can give is a zonotope; a torque leaves it through the facet whose
    normal n maximises |n.t| / sum_j r_j |n.D[:, j]|. On that facet all wheels but those that lie in it are at the same
    share of their limit, so that the solution is linear in the torque on the cone over each facet: one table of
    matrices, chosen by a maximum (Markley et al., NTRS 20110015369, describe the envelope).

    Parameters
    ----------
    wheels
        The wheel array; wheels without a limit count as equals.

    Raises
    ------
    ValueError
        If the axes do not span space.
    """

    def __init__(self, wheels: WheelArray) -> None:
        limits = wheels.torque_limits
        scale = np.where(np.isfinite(limits), limits, 1.0)
        axes = wheels.axis_matrix * scale
        require(int(np.linalg.matrix_rank(axes)) == 3, "axes", "must span three dimensions", wheels.axes)
        normals: list[FloatArray] = []
        matrices: list[FloatArray] = []
        for normal in envelope_normals(axes):
            across = normal @ axes
            in_facet = np.abs(across) < 1e-9 * np.abs(across).max()
            if any(np.allclose(np.abs(normal @ other), np.linalg.norm(other)) for other in normals):
                continue
            # n scaled so that n.t is the share at which the facet is reached.
            scaled = normal / np.abs(across).sum()
            shares = np.zeros((wheels.count, 3))
            shares[~in_facet] = np.sign(across[~in_facet])[:, None] * scaled
            rest = np.eye(3) - axes @ shares
            shares[in_facet] = np.linalg.pinv(axes[:, in_facet]) @ rest
            normals.append(scaled)
            matrices.append(scale[:, None] * shares)
        self._normals = np.array(normals).T
        self._matrices = np.array(matrices)

    def __call__(self, torque: FloatArray) -> FloatArray:
        """Allocate torques on the body (N, 3) [N m] to wheels, (N, m) [N m], not yet limited."""
        facet = np.abs(torque @ self._normals).argmax(axis=1)
        allocated: FloatArray = (self._matrices[facet] @ torque[:, :, None])[:, :, 0]
        return allocated


def scale_to_limits(command: FloatArray, limits: FloatArray) -> FloatArray:
    """Shrink wheel torques (N, m) that exceed their limits (m,) so that the torque on the body keeps its direction."""
    excess = (np.abs(command) / limits).max(axis=1, keepdims=True)
    scaled: FloatArray = command / np.maximum(excess, 1.0)
    return scaled
