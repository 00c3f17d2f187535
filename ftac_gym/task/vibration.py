"""True vibration modes of a spacecraft, with their energy and their torque on the body."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ftac_gym.attitude import cross
from ftac_gym.spacecraft.appendages import FlexibleAppendages
from ftac_gym.utils.parameters import FloatArray, Interval, bounds, draw, non_negative_interval, normalise, require
from ftac_gym.utils.serialization import serializable

MODE = np.dtype([("stiffness", "f8"), ("damping", "f8"), ("coupling", "f8", (3,))])
"""Per spacecraft and mode: eta'' + damping eta' + stiffness eta = -coupling . w' [rad/s, rad^2/s^2, kg^1/2 m]."""

LARGEST_PHASE = 2.0
"""Limit of the fastest pole of the modes of a free spacecraft, times the physics step; RK4 diverges from 2.7 on."""


@serializable
@dataclass(frozen=True)
class AppendageUncertainty:
    """Difference of the true modes from the nominal ones: each mode of each spacecraft draws its own three factors.

    Parameters
    ----------
    frequency
        Factor on the frequency.
    damping
        Factor on the damping ratio.
    coupling
        Factor on the coupling with the body, the same for the three axes.

    Raises
    ------
    ValueError
        If a frequency factor is not positive, or another is negative.
    """

    frequency: Interval = 1.0
    damping: Interval = 1.0
    coupling: Interval = 1.0

    def __post_init__(self) -> None:
        """Check and normalise the fields."""
        normalise(self, non_negative_interval, "frequency", "damping", "coupling")
        require(bounds(self.frequency)[0] > 0.0, "frequency", "must be positive", self.frequency)

    def uniform_count(self, modes: int) -> int:
        """Return the number of uniform deviates of one episode."""
        return 3 * modes

    def draw(self, nominal: FlexibleAppendages | None, uniform: FloatArray) -> npt.NDArray[np.void]:
        """Draw the modes of N spacecraft from uniform deviates (N, uniform_count): MODE records (N, k)."""
        first, second, third = (uniform[:, part::3] for part in range(3))
        frequency, table = draw(self.frequency, first), exact_modes(nominal, len(uniform))
        table["stiffness"] *= frequency**2
        table["damping"] *= frequency * draw(self.damping, second)
        table["coupling"] *= draw(self.coupling, third)[:, :, None]
        return table

    def extreme(self, nominal: FlexibleAppendages) -> npt.NDArray[np.void]:
        """Return the modes with the largest factors, MODE records (1, k)."""
        return self.draw(nominal, np.ones((1, self.uniform_count(nominal.count))))


def exact_modes(nominal: FlexibleAppendages | None, count: int) -> npt.NDArray[np.void]:
    """Return MODE records (count, k) of spacecraft whose true modes are the nominal ones; k = 0 for rigid bodies."""
    if nominal is None:
        return np.zeros((count, 0), MODE)
    table = np.zeros((count, nominal.count), MODE)
    table["stiffness"], table["damping"] = nominal.stiffness, nominal.damping
    table["coupling"] = nominal.coupling_matrix
    return table


def check_modes(modes: npt.NDArray[np.void], inertia: npt.NDArray[np.void], physics_step: float) -> None:
    """Check that drawn modes and inertias make bodies that the integrator can handle.

    Parameters
    ----------
    modes
        MODE records (N, k).
    inertia
        INERTIA records (N,).
    physics_step
        Step of the plant's integrator [s].

    Raises
    ------
    ValueError
        If the modes carry as much inertia as a body has, or are too fast for the step.
    """
    if modes.shape[1] == 0:
        return
    carried = np.einsum("nki,nkj->nij", modes["coupling"], modes["coupling"])
    least = inertia["constant"] - carried - np.einsum("ni,ij->nij", np.abs(inertia["amplitude"]), np.eye(3))
    smallest = float(np.linalg.eigvalsh(least).min(initial=np.inf))
    rule = "must leave J - delta' delta of every spacecraft positive definite; the smallest eigenvalue drawn [kg m^2]"
    require(smallest > 0.0, "appendage_uncertainty and inertia_uncertainty", rule, smallest)
    fastest = float(fastest_pole(modes, inertia["constant"]).max(initial=0.0))
    rule = f"must be at most {LARGEST_PHASE / fastest:.3g} s: the fastest pole of the modes is {fastest:.4g} 1/s"
    require(fastest * physics_step <= LARGEST_PHASE, "physics_step", rule, physics_step)


def fastest_pole(modes: npt.NDArray[np.void], inertia: FloatArray) -> FloatArray:
    """Return the magnitude of the fastest pole of the modes of spacecraft that are free to turn, (N,) [1/s].

    Without damping it is the highest free frequency.

    Parameters
    ----------
    modes
        (N, k) MODE records, k at least 1.
    inertia
        (N, 3, 3) total inertia [kg m^2].
    """
    count, coupling = modes.shape[1], modes["coupling"]
    # eta'' = -(I - delta J^-1 delta')^-1 (C eta' + K eta).
    held = np.eye(count) - coupling @ np.linalg.solve(inertia, coupling.transpose(0, 2, 1))
    companion = np.zeros((len(modes), 2 * count, 2 * count))
    companion[:, :count, count:] = np.eye(count)
    companion[:, count:, :count] = -np.linalg.solve(held, modes["stiffness"][:, :, None] * np.eye(count))
    companion[:, count:, count:] = -np.linalg.solve(held, modes["damping"][:, :, None] * np.eye(count))
    return np.abs(np.linalg.eigvals(companion)).max(axis=1)


def modal_energy(stiffness: FloatArray, displacement: FloatArray, rate: FloatArray) -> FloatArray:
    """Return the energy of the modes, (eta'.eta' + eta.K eta) / 2, over the last axis [J].

    Parameters
    ----------
    stiffness
        (..., k) f^2 [rad^2/s^2].
    displacement, rate
        (..., k) eta and eta' [kg^1/2 m, kg^1/2 m/s].
    """
    return 0.5 * (rate**2 + stiffness * displacement**2).sum(axis=-1)


def vibration_torque(
    modes: npt.NDArray[np.void], displacement: FloatArray, rate: FloatArray, body_rate: FloatArray
) -> FloatArray:
    """Return the torque delta' (C eta' + K eta) - w x delta' eta' of the modes on a body of inertia J - delta' delta.

    Eq. (6) of Li et al. 2023. It is the whole torque on a body that is held still.

    Parameters
    ----------
    modes
        (N, k) MODE records.
    displacement, rate
        (..., N, k) eta and eta' [kg^1/2 m, kg^1/2 m/s].
    body_rate
        (..., N, 3) w [rad/s].

    Returns
    -------
    Array (..., N, 3) [N m], body axes.
    """
    return hub_torque(modes["stiffness"], modes["damping"], modes["coupling"], displacement, rate, body_rate)


def hub_torque(
    stiffness: FloatArray,
    damping: FloatArray,
    coupling: FloatArray,
    displacement: FloatArray,
    rate: FloatArray,
    body_rate: FloatArray,
) -> FloatArray:
    """Return the same for modes that are given by K and C (..., k) [rad^2/s^2, rad/s] and delta (..., k, 3).

    Parameters that all spacecraft have in common need no axis for them.
    """
    force = damping * rate + stiffness * displacement
    pull, carried = ((part[..., None, :] @ coupling)[..., 0, :] for part in (force, rate))
    return pull - cross(body_rate, carried)
