"""Flexible appendages: panels and booms as vibration modes that are clamped to the body."""

from dataclasses import dataclass

import numpy as np

from ftac_gym.utils.parameters import FloatArray, Matrix, Vector, each, matrix, non_negative, positive, require, rows
from ftac_gym.utils.serialization import serializable


@serializable
@dataclass(frozen=True)
class FlexibleAppendages:
    """Vibration modes of everything that bends, with the body held still.

    With the modal displacements eta (k) [kg^1/2 m], eta'' + C eta' + K eta = -delta w' for C = diag(2 zeta_i f_i) and
    K = diag(f_i^2); the body feels the momentum delta' eta' in return. Modes are normalised to unit modal mass, so that
    squares of eta' are energies.

    Parameters
    ----------
    frequencies
        Cantilever frequencies f (k) [rad/s]: those with the body held still.
    damping_ratios
        zeta (k) [-], one number for all modes or one each; zero is undamped.
    coupling
        The matrix delta, k x 3 in body axes [kg^1/2 m]: row i is what a turning body does to mode i.

    Raises
    ------
    ValueError
        If there are no modes, a frequency is not positive, a damping ratio is negative, or the coupling is not k x 3.
    """

    frequencies: Vector
    damping_ratios: Vector | float
    coupling: Matrix

    def __post_init__(self) -> None:
        """Check and normalise the fields."""
        values = self.frequencies
        flat = isinstance(values, (tuple, list, np.ndarray)) and all(np.ndim(value) == 0 for value in values)
        require(flat and len(values) >= 1, "frequencies", "must have one number per mode", values)
        count = len(self.frequencies)
        object.__setattr__(self, "frequencies", each(self.frequencies, count, "frequencies", positive))
        object.__setattr__(self, "damping_ratios", each(self.damping_ratios, count, "damping_ratios", non_negative))
        object.__setattr__(self, "coupling", rows(matrix(self.coupling, count, 3, "coupling")))

    @property
    def count(self) -> int:
        """Number of modes k."""
        return len(self.frequencies)

    @property
    def coupling_matrix(self) -> FloatArray:
        """The matrix delta, array (k, 3) [kg^1/2 m]."""
        return np.array(self.coupling)

    @property
    def stiffness(self) -> FloatArray:
        """The diagonal of K, f^2, array (k,) [rad^2/s^2]."""
        return np.array(self.frequencies) ** 2

    @property
    def damping(self) -> FloatArray:
        """The diagonal of C, 2 zeta f, array (k,) [rad/s]."""
        return 2.0 * np.array(self.damping_ratios) * np.array(self.frequencies)

    @property
    def carried_inertia(self) -> FloatArray:
        """The inertia delta' delta (3, 3) [kg m^2] that the modes take along: a quick torque turns J without it."""
        coupling = self.coupling_matrix
        return coupling.T @ coupling

    def free_frequencies(self, inertia: FloatArray) -> FloatArray:
        """Return the frequencies of the undamped modes of a body that is free to turn, (k,) [rad/s], in rising order.

        They are higher than those of the clamped modes: (I - delta J^-1 delta') eta'' + K eta = 0.

        Parameters
        ----------
        inertia
            Total inertia J (3, 3) [kg m^2].

        Raises
        ------
        ValueError
            If J - delta' delta is not positive definite.
        """
        self.check(inertia)
        coupling, root = self.coupling_matrix, np.sqrt(self.stiffness)
        mass = np.eye(self.count) - coupling @ np.linalg.solve(inertia, coupling.T)
        squares = np.linalg.eigvalsh(root[:, None] * np.linalg.inv(mass) * root)
        return np.sqrt(squares)

    def check(self, inertia: FloatArray) -> None:
        """Raise a ValueError unless the modes leave a body of total inertia J (3, 3) something of its own to turn."""
        least = float(np.linalg.eigvalsh(inertia - self.carried_inertia)[0])
        rule = "must leave J - delta' delta positive definite; its smallest eigenvalue [kg m^2]"
        require(least > 0.0, "coupling", rule, least)
