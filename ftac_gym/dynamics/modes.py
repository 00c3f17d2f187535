"""Compiled vibration modes of flexible appendages, coupled with the body.

With eta the modal displacements and psi = eta' + delta w::

    eta' = psi - delta w,    psi' = -(C eta' + K eta),

which needs no acceleration of the body. The body then has the inertia J - delta' delta, carries the momentum
delta' psi and is under the torque delta' (C eta' + K eta).
"""

from typing import Any

from ftac_gym.utils.compiling import inlined

STIFFNESS, DAMPING, COUPLING_X, COUPLING_Y, COUPLING_Z = 0, 1, 2, 3, 4
DISPLACEMENT, MOTION, STAGE_DISPLACEMENT, STAGE_MOTION, SUM_DISPLACEMENT, SUM_MOTION = 5, 6, 7, 8, 9, 10
ROWS = 11
"""Rows of the working array (ROWS, k) of one spacecraft: parameters, eta and psi, their stage values and sums."""


@inlined
def load_modes(work: Any, modes: Any, displacement: Any, rate: Any, w: Any) -> Any:
    """Fill the working array from MODE records (k,) and the state; return delta' delta as (xx, yy, zz, xy, xz, yz)."""
    xx, yy, zz, xy, xz, yz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for mode in range(modes.shape[0]):
        x, y, z = modes[mode].coupling[0], modes[mode].coupling[1], modes[mode].coupling[2]
        xx, yy, zz = xx + x * x, yy + y * y, zz + z * z
        xy, xz, yz = xy + x * y, xz + x * z, yz + y * z
        work[STIFFNESS, mode], work[DAMPING, mode] = modes[mode].stiffness, modes[mode].damping
        work[COUPLING_X, mode], work[COUPLING_Y, mode], work[COUPLING_Z, mode] = x, y, z
        work[DISPLACEMENT, mode] = displacement[mode]
        work[MOTION, mode] = rate[mode] + (x * w[0] + y * w[1] + z * w[2])
    return xx, yy, zz, xy, xz, yz


@inlined
def begin_step(work: Any) -> None:
    """Set the stage values to the state and the sums to zero."""
    for mode in range(work.shape[1]):
        work[STAGE_DISPLACEMENT, mode], work[STAGE_MOTION, mode] = work[DISPLACEMENT, mode], work[MOTION, mode]
        work[SUM_DISPLACEMENT, mode], work[SUM_MOTION, mode] = 0.0, 0.0


@inlined
def modal_stage(work: Any, w: Any, weight: float, ahead: float) -> Any:
    """Take one stage of a Runge-Kutta step: sum the slopes with a weight, and advance by ``ahead`` [s] from the start.

    Returns
    -------
    The momentum delta' psi [N m s] and the torque delta' (C eta' + K eta) [N m] of this stage, body axes.
    """
    momentum_x, momentum_y, momentum_z = 0.0, 0.0, 0.0
    torque_x, torque_y, torque_z = 0.0, 0.0, 0.0
    for mode in range(work.shape[1]):
        x, y, z = work[COUPLING_X, mode], work[COUPLING_Y, mode], work[COUPLING_Z, mode]
        motion = work[STAGE_MOTION, mode]
        rate = motion - (x * w[0] + y * w[1] + z * w[2])
        force = work[DAMPING, mode] * rate + work[STIFFNESS, mode] * work[STAGE_DISPLACEMENT, mode]
        momentum_x, momentum_y, momentum_z = momentum_x + x * motion, momentum_y + y * motion, momentum_z + z * motion
        torque_x, torque_y, torque_z = torque_x + x * force, torque_y + y * force, torque_z + z * force
        work[SUM_DISPLACEMENT, mode] += weight * rate
        work[SUM_MOTION, mode] -= weight * force
        work[STAGE_DISPLACEMENT, mode] = work[DISPLACEMENT, mode] + ahead * rate
        work[STAGE_MOTION, mode] = work[MOTION, mode] - ahead * force
    return (momentum_x, momentum_y, momentum_z), (torque_x, torque_y, torque_z)


@inlined
def end_step(work: Any, share: float) -> None:
    """Add the sums times ``share`` [s] to the state."""
    for mode in range(work.shape[1]):
        work[DISPLACEMENT, mode] += share * work[SUM_DISPLACEMENT, mode]
        work[MOTION, mode] += share * work[SUM_MOTION, mode]


@inlined
def store_modes(work: Any, displacement: Any, rate: Any, w: Any) -> None:
    """Write eta and eta' of the state."""
    for mode in range(work.shape[1]):
        slip = work[COUPLING_X, mode] * w[0] + work[COUPLING_Y, mode] * w[1] + work[COUPLING_Z, mode] * w[2]
        displacement[mode] = work[DISPLACEMENT, mode]
        rate[mode] = work[MOTION, mode] - slip
