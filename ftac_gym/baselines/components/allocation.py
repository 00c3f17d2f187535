"""Allocation of a torque on the body to the wheels, and limits of the wheel torques."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ftac_gym.spacecraft.envelope import envelope_normals
from ftac_gym.spacecraft.wheel_array import WheelArray
from ftac_gym.utils.parameters import FloatArray, non_negative, require, rows


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
    return np.linalg.pinv(axes).astype(np.float64)


class EffectivenessAllocation:
    """Wheel torques that give a torque on the body through wheels of estimated effectiveness.

    u = E^p D' (D E^(p+1) D')^-1 torque, so that D E u = torque: for p = 1 the pseudo-inverse of D E (Eq. (26) of Cao et
    al. 2022), for p = 2 the allocation of Eqs. (36) and (70) of Zhang and Zhou 2019, which spares weak wheels more.

    Parameters
    ----------
    axes
        (3, m) wheel axes.
    power
        p, not negative.
    smallest
        Lower bound of the effectiveness, which keeps the matrix invertible for any number of wheels without torque.

    Raises
    ------
    ValueError
        If the axes do not span space or a value breaks a rule.
    """

    def __init__(self, axes: FloatArray, power: float, smallest: float = 0.05) -> None:
        self._healthy = pseudo_inverse(axes).T
        self._axes = axes
        self._power = non_negative(power, "power")
        require(0.0 < smallest <= 1.0, "smallest", "must lie within (0, 1]", smallest)
        self._smallest = smallest
        self._outer = np.einsum("ij,kj->jik", axes, axes).reshape(axes.shape[1], 9)

    def __call__(self, torque: FloatArray, effectiveness: FloatArray | None) -> FloatArray:
        """Allocate torques (N, 3) [N m] to wheels (N, m) [N m], not limited; None: all wheels are healthy."""
        if effectiveness is None:
            return torque @ self._healthy
        safe = np.maximum(effectiveness, self._smallest)
        weights = safe**self._power
        matrices = ((weights * safe) @ self._outer).reshape(-1, 3, 3)
        solved = np.linalg.solve(matrices, torque[:, :, None])[:, :, 0]
        return weights * (solved @ self._axes)


class MinimaxAllocation:
    """The wheel torques whose largest share of a wheel's limit is the smallest possible.

    The set of torques that wheels with limits r_j can give is a zonotope; a torque leaves it through the facet whose
    normal n maximises ``|n.t|`` / sum_j r_j ``|n.D[:, j]|``. On that facet all wheels outside of its plane are at the
    same share of their limit. The rest of the torque lies in the plane of the facet. The same holds there for its
    edges, and on an edge for its wheels. On the cone over each edge of each facet the solution is linear in the torque.
    It is a table of matrices, chosen by two maxima (Markley et al., NTRS 20110015369, describe the envelope).

    Parameters
    ----------
    wheels
        The wheel array; wheels without a limit have equal weight.

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
        edges: list[list[tuple[FloatArray, FloatArray]]] = []
        for normal in _distinct(envelope_normals(axes)):
            across = normal @ axes
            flat = np.abs(across) < 1e-9 * np.abs(across).max()
            # With n scaled so, n.t is the share at which the facet is reached.
            scaled = normal / np.abs(across).sum()
            shares = np.zeros((wheels.count, 3))
            shares[~flat] = np.sign(across[~flat])[:, None] * scaled
            rest = np.eye(3) - axes @ shares
            normals.append(scaled)
            edges.append([])
            for chooser, part in _in_plane(normal, axes[:, flat]):
                whole = shares.copy()
                whole[flat] = part @ rest
                edges[-1].append((chooser @ rest, scale[:, None] * whole))
        most = max(len(group) for group in edges)
        # Facets with fewer edges than others repeat their first.
        padded = [group + group[:1] * (most - len(group)) for group in edges]
        self._normals = np.array(normals).T
        self._choosers = np.array([[chooser for chooser, _ in group] for group in padded])
        self._matrices = np.array([[matrix for _, matrix in group] for group in padded])
        self._simple = all(np.allclose(matrices, matrices[0], atol=1e-12) for matrices in self._matrices)

    def __call__(self, torque: FloatArray) -> FloatArray:
        """Allocate torques on the body (N, 3) [N m] to wheels, (N, m) [N m], not yet limited."""
        facet = np.abs(torque @ self._normals).argmax(axis=1)
        column = torque[:, :, None]
        if self._simple:
            matrices = self._matrices[facet, 0]
        else:
            edge = np.abs((self._choosers[facet] @ column)[:, :, 0]).argmax(axis=1)
            matrices = self._matrices[facet, edge]
        allocated: FloatArray = (matrices @ column)[:, :, 0]
        return allocated


class UsableAllocation:
    """The allocation with the smallest largest share of a limit, to the wheels that are usable.

    A wheel of reduced effectiveness gets a command that is larger by its inverse. Where the usable wheels do not span
    space, they give the torque with the smallest sum of squared errors.

    Parameters
    ----------
    wheels
        The wheel array.

    Raises
    ------
    ValueError
        If the axes do not span space.
    """

    def __init__(self, wheels: WheelArray) -> None:
        self._wheels, self._nominal = wheels, MinimaxAllocation(wheels)
        self._bits = 1 << np.arange(wheels.count)
        self._whole = int(self._bits.sum())
        self._known: dict[int, MinimaxAllocation | FloatArray] = {}

    def __call__(self, torque: FloatArray, usable: FloatArray | None) -> FloatArray:
        """Allocate torques (N, 3) [N m] to wheels of a usable share (N, m), (N, m) [N m], not yet limited."""
        if usable is None:
            return self._nominal(torque)
        patterns = (usable > 0.0) @ self._bits
        if (patterns == self._whole).all():
            return self._nominal(torque) / usable
        command = np.zeros((len(torque), self._wheels.count))
        for pattern in np.unique(patterns):
            chosen = np.flatnonzero(patterns == pattern)
            left = (self._bits & pattern) > 0
            part = np.ix_(chosen, left)
            command[part] = self._allocated(int(pattern), left, torque[chosen]) / usable[part]
        return command

    def _allocated(self, pattern: int, left: npt.NDArray[np.bool_], torque: FloatArray) -> FloatArray:
        """Return wheel torques (n, k) of the wheels that are left for torques (n, 3)."""
        if pattern == self._whole:
            return self._nominal(torque)
        axes = self._wheels.axis_matrix[:, left]
        if pattern not in self._known:
            spans = int(np.linalg.matrix_rank(axes)) == 3
            part = WheelArray(rows(axes), tuple(self._wheels.torque_limits[left])) if spans else None
            self._known[pattern] = (
                np.linalg.pinv(axes).T.astype(np.float64) if part is None else MinimaxAllocation(part)
            )
        found = self._known[pattern]
        return torque @ found if isinstance(found, np.ndarray) else found(torque)


def _distinct(directions: FloatArray) -> list[FloatArray]:
    """Return the rows (n, 3) that are not parallel to an earlier one."""
    kept: list[FloatArray] = []
    for row in directions:
        length = np.linalg.norm(row)
        if not any(np.linalg.norm(np.cross(row, other)) < 1e-9 * length * np.linalg.norm(other) for other in kept):
            kept.append(row)
    return kept


def _in_plane(normal: FloatArray, axes: FloatArray) -> list[tuple[FloatArray, FloatArray]]:
    """Solve the problem for wheels (3, k) that lie in the plane with a normal.

    Returns one pair for each distinct wheel direction: a row (3,) and a matrix (k, 3). The product of the row and a
    torque in the plane is the share at which that edge is reached; the largest product selects the edge. The matrix
    gives the shares of the wheels on that edge.
    """
    solutions = []
    for direction in _distinct(axes.T):
        unit = direction / np.linalg.norm(direction)
        side = np.cross(normal, unit)
        across = side @ axes
        along = np.abs(across) < 1e-9 * np.linalg.norm(axes, axis=0)
        part = np.zeros((axes.shape[1], 3))
        chooser = side / np.abs(across[~along]).sum()
        part[~along] = np.sign(across[~along])[:, None] * chooser
        lengths = unit @ axes[:, along]
        remainder = unit @ (np.eye(3) - axes @ part)
        part[along] = np.sign(lengths)[:, None] * remainder / np.abs(lengths).sum()
        solutions.append((chooser, part))
    return solutions


def limit_each(command: FloatArray, limits: FloatArray) -> FloatArray:
    """Clip wheel torques (N, m) to their limits (m,), each wheel by itself, as the wheels do."""
    return np.minimum(np.maximum(command, -limits), limits)


def scale_to_limits(command: FloatArray, limits: FloatArray) -> FloatArray:
    """Shrink wheel torques (N, m) that exceed their limits (m,) so that the torque on the body keeps its direction."""
    excess = (np.abs(command) / limits).max(axis=1, keepdims=True)
    scaled: FloatArray = command / np.maximum(excess, 1.0)
    return scaled


def within_limits(command: FloatArray, limits: FloatArray) -> FloatArray:
    """Limit wheel torques (N, m) to limits (m,): three wheels one by one, as in the papers; redundant ones together."""
    return (scale_to_limits if len(limits) > 3 else limit_each)(command, limits)
