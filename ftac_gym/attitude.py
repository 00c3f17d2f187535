"""Quaternion and modified Rodrigues parameter (MRP) algebra on NumPy arrays.

Conventions, used by every function here:

* Quaternions ``q = [q0, q1, q2, q3]`` are scalar first, shape ``(..., 4)``, with the Hamilton product. An attitude
  quaternion has unit norm and gives the body relative to the inertial frame: ``q' = 1/2 q (x) [0, w]`` with ``w`` the
  body rate in body axes [rad/s]. Unit norm is assumed and not checked; see :func:`quaternion_normalize`.
* ``C(q)`` maps reference (inertial) components to body components: ``v_body = C(q) v_inertial``.
* MRPs ``sigma = q_v / (1 + q0)`` have shape ``(..., 3)``. The short branch is ``|sigma| <= 1`` (rotation <= pi).
* Error: ``q_e = conj(q_d) (x) q``, hence ``w_e = w - C(q_e) w_d`` with ``w_d`` in the axes of the reference frame.

All functions are pure, expect float64 arrays, broadcast over leading axes and return float64 with the broadcast shape.
"""

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]

_NEXT = np.array([1, 2, 0])  # cyclic successor of each axis
_IDENTITY = np.eye(3)
_CONJUGATE_SIGNS: FloatArray = np.array([1.0, -1.0, -1.0, -1.0])
_SKEW_INDEX = np.array([[0, 2, 1], [2, 1, 0], [1, 0, 2]])
_SKEW_SIGN = np.array([[0.0, -1.0, 1.0], [1.0, 0.0, -1.0], [-1.0, 1.0, 0.0]])
_SMALL_BATCH = 6000  # elements in both operands of `cross` below which gathering beats component slices
_TINY = float(np.finfo(np.float64).tiny)


def _dot(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the inner product over the last axis, that axis kept with length 1."""
    return np.vecdot(a, b)[..., None]


def _outer(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return ``a b^T``, shape ``(..., 3, 3)``."""
    return a[..., :, None] * b[..., None, :]


def cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the cross product ``a x b`` of vectors ``(..., 3)`` given in the same axes; faster than ``np.cross``."""
    if a.size + b.size < _SMALL_BATCH:  # four gathers and products: least call overhead
        return (a * b.take(_NEXT, -1) - a.take(_NEXT, -1) * b).take(_NEXT, -1)
    a0, a1, a2 = a[..., 0], a[..., 1], a[..., 2]
    b0, b1, b2 = b[..., 0], b[..., 1], b[..., 2]
    return np.stack((a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0), axis=-1)


def skew(v: FloatArray) -> FloatArray:
    """Return the matrix ``[v x]``, shape ``(..., 3, 3)``, with ``[v x] b = v x b``, for ``v`` of shape ``(..., 3)``."""
    return v.take(_SKEW_INDEX, -1) * _SKEW_SIGN


def quaternion_product(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the Hamilton product ``a (x) b`` of quaternions ``(..., 4)`` of any norm."""
    a0, av, b0, bv = a[..., :1], a[..., 1:], b[..., :1], b[..., 1:]
    return np.concatenate((a0 * b0 - _dot(av, bv), a0 * bv + b0 * av + cross(av, bv)), axis=-1)


def quaternion_conjugate(q: FloatArray) -> FloatArray:
    """Return ``[q0, -q_v]``, the inverse rotation, for ``q`` of shape ``(..., 4)``."""
    return q * _CONJUGATE_SIGNS


def quaternion_normalize(q: FloatArray) -> FloatArray:
    """Return ``q / |q|`` for ``q`` of shape ``(..., 4)`` and any non-zero finite magnitude; the sign is kept.

    Raises
    ------
    ValueError
        If any quaternion is zero or has a component that is not finite.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        squared = _dot(q, q)
    if not ((squared > 1e-280) & (squared < 1e280)).all():  # the square may have under- or overflowed: rescale
        largest = np.abs(q).max(axis=-1, keepdims=True)
        if not np.isfinite(largest).all():
            raise ValueError("quaternion_normalize: every quaternion component must be finite")
        if not largest.all():
            raise ValueError("quaternion_normalize: every quaternion must be non-zero")
        q = q / largest
        squared = _dot(q, q)
    return q / np.sqrt(squared)


def canonical(q: FloatArray) -> FloatArray:
    """Return whichever of ``q`` and ``-q``, shape ``(..., 4)``, has ``q0 >= 0`` (``q`` itself if ``q0`` is 0)."""
    return np.where(q[..., :1] < 0.0, -q, q)


def quaternion_error(attitude: FloatArray, reference: FloatArray) -> FloatArray:
    """Return the attitude relative to the reference, ``q_e = conj(q_d) (x) q``, shape ``(..., 4)``, with ``q0 >= 0``.

    ``q`` of the body and ``q_d`` of the reference frame, shape ``(..., 4)``, are relative to the same inertial frame.
    ``C(q_e)`` maps reference-frame components to body components.
    """
    return canonical(quaternion_product(quaternion_conjugate(reference), attitude))


def rotate_to_body(q: FloatArray, v: FloatArray) -> FloatArray:
    """Return ``C(q) v``: inertial components ``v``, shape ``(..., 3)``, in body axes; ``q`` of shape ``(..., 4)``."""
    axis = q[..., 1:]
    first = cross(axis, v)
    return v + 2.0 * (cross(axis, first) - q[..., :1] * first)


def rotate_to_reference(q: FloatArray, v: FloatArray) -> FloatArray:
    """Return ``C(q)^T v``: body components ``v``, shape ``(..., 3)``, in inertial axes; ``q`` of shape ``(..., 4)``."""
    axis = q[..., 1:]
    first = cross(axis, v)
    return v + 2.0 * (cross(axis, first) + q[..., :1] * first)


def rotation_matrix(q: FloatArray) -> FloatArray:
    """Return ``C(q)``, shape ``(..., 3, 3)``, with ``v_body = C(q) v_inertial``, for ``q`` of shape ``(..., 4)``."""
    axis = q[..., 1:]
    diagonal = (1.0 - 2.0 * _dot(axis, axis))[..., None]
    return diagonal * _IDENTITY + 2.0 * (_outer(axis, axis) - skew(q[..., :1] * axis))


def quaternion_from_rotation_matrix(matrix: FloatArray) -> FloatArray:
    """Return the unit quaternion, ``q0 >= 0``, of a rotation matrix; accurate for every angle (Shepperd's method).

    The matrix ``C``, shape ``(..., 3, 3)``, has ``v_body = C v_inertial``. It is assumed to be orthonormal with
    determinant +1, which is not checked. The quaternion has the shape ``(..., 4)``.

    Raises
    ------
    ValueError
        If the matrix has an entry that is not finite.
    """
    if not np.isfinite(matrix).all():
        raise ValueError("quaternion_from_rotation_matrix: every matrix entry must be finite")
    transpose = np.swapaxes(matrix, -1, -2)
    trace = np.trace(matrix, axis1=-2, axis2=-1)[..., None]
    difference = matrix - transpose
    vector = np.stack((difference[..., 1, 2], difference[..., 2, 0], difference[..., 0, 1]), axis=-1)
    outer = np.empty((*matrix.shape[:-2], 4, 4))  # 4 q q^T
    outer[..., 0, 0] = 1.0 + trace[..., 0]
    outer[..., 0, 1:] = outer[..., 1:, 0] = vector
    outer[..., 1:, 1:] = matrix + transpose + (1.0 - trace)[..., None] * _IDENTITY
    largest = np.argmax(np.diagonal(outer, axis1=-2, axis2=-1), axis=-1)[..., None, None]
    return canonical(quaternion_normalize(np.take_along_axis(outer, largest, axis=-2)[..., 0, :]))


def quaternion_derivative(q: FloatArray, w: FloatArray) -> FloatArray:
    """Return ``q' = 1/2 q (x) [0, w]`` [1/s], shape ``(..., 4)``, for ``q`` of shape ``(..., 4)``.

    The angular velocity ``w``, shape ``(..., 3)``, is that of the body relative to the inertial frame, in body axes
    [rad/s].
    """
    axis, half_rate = q[..., 1:], 0.5 * w
    return np.concatenate((-_dot(axis, half_rate), q[..., :1] * half_rate + cross(axis, half_rate)), axis=-1)


def quaternion_from_rotation_vector(phi: FloatArray) -> FloatArray:
    """Return the quaternion ``[cos(|phi|/2), sin(|phi|/2) phi/|phi|]``, shape ``(..., 4)``; exact at and near zero.

    The rotation of the body ``phi``, shape ``(..., 3)``, is axis times angle [rad]. Beyond ``|phi| = pi`` the scalar
    part is negative.
    """
    half_angle = 0.5 * np.sqrt(_dot(phi, phi))
    return np.concatenate((np.cos(half_angle), 0.5 * np.sinc(half_angle / np.pi) * phi), axis=-1)


def rotation_vector_from_quaternion(q: FloatArray) -> FloatArray:
    """Return the short-way rotation vector [rad], shape ``(..., 3)``, ``|phi| <= pi``, of ``q``, shape ``(..., 4)``."""
    q = canonical(q)
    axis = q[..., 1:]
    sine = np.sqrt(_dot(axis, axis))
    ratio = np.divide(np.arctan2(sine, q[..., :1]), sine, out=np.ones_like(sine), where=sine > 0.0)
    return 2.0 * ratio * axis


def angle_between(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the angle [rad] in [0, pi] between attitudes ``(..., 4)``, shape ``(...)``; accurate near 0 and pi."""
    error = quaternion_product(quaternion_conjugate(a), b)
    axis = error[..., 1:]
    return 2.0 * np.arctan2(np.sqrt(np.vecdot(axis, axis)), np.abs(error[..., 0]))


def mrp_from_quaternion(q: FloatArray) -> FloatArray:
    """Return the short-branch MRP ``(..., 3)``, ``|sigma| <= 1``, of ``q``, shape ``(..., 4)``; the same for ``-q``."""
    q = canonical(q)
    return q[..., 1:] / (1.0 + q[..., :1])


def quaternion_from_mrp(sigma: FloatArray) -> FloatArray:
    """Return the quaternion ``(..., 4)`` with ``sigma = q_v / (1 + q0)``; ``q0 < 0`` if and only if ``|sigma| > 1``."""
    squared = _dot(sigma, sigma)
    scale = 1.0 / (1.0 + squared)
    return np.concatenate(((1.0 - squared) * scale, (2.0 * scale) * sigma), axis=-1)


def mrp_shadow(sigma: FloatArray) -> FloatArray:
    """Return the other MRP of the same attitude, ``-sigma / |sigma|^2``, shape ``(..., 3)``.

    Raises
    ------
    ValueError
        If any ``sigma`` is zero (or ``|sigma|^2`` underflows): the shadow of the identity is at infinity.
    """
    squared = _dot(sigma, sigma)
    if (squared < _TINY).any():
        raise ValueError("mrp_shadow: sigma must be non-zero, the shadow of the identity is at infinity")
    return -sigma / squared


def mrp_switch(sigma: FloatArray) -> FloatArray:
    """Return the short-branch MRP, ``|sigma| <= 1``, of the same attitude, shape ``(..., 3)``."""
    squared = _dot(sigma, sigma)
    return np.where(squared > 1.0, -sigma / np.maximum(squared, 1.0), sigma)


def mrp_kinematic_matrix(sigma: FloatArray) -> FloatArray:
    """Return ``G = 1/4 [(1 - |s|^2) I + 2 [s x] + 2 s s^T]``, shape ``(..., 3, 3)``, with ``sigma' = G w``."""
    diagonal = (0.25 - 0.25 * _dot(sigma, sigma))[..., None]
    return diagonal * _IDENTITY + 0.5 * (skew(sigma) + _outer(sigma, sigma))


def mrp_kinematic_matrix_inverse(sigma: FloatArray) -> FloatArray:
    """Return ``G^-1 = 16 / (1 + |s|^2)^2 G^T``, shape ``(..., 3, 3)``, which exists for every finite ``sigma``."""
    root = 4.0 / (1.0 + _dot(sigma, sigma))[..., None]
    return root * root * mrp_kinematic_matrix(-sigma)  # G(-s) = G(s)^T


def mrp_kinematic_matrix_derivative(sigma: FloatArray, sigma_dot: FloatArray) -> FloatArray:
    """Return ``dG/dt`` [1/s], shape ``(..., 3, 3)``, for ``sigma`` and ``sigma_dot`` [1/s] of shape ``(..., 3)``."""
    diagonal = _dot(sigma, sigma_dot)[..., None]
    outer = _outer(sigma, sigma_dot)
    return 0.5 * (skew(sigma_dot) + outer + np.swapaxes(outer, -1, -2) - diagonal * _IDENTITY)


def mrp_derivative(sigma: FloatArray, w: FloatArray) -> FloatArray:
    """Return ``sigma' = G(sigma) w`` [1/s], shape ``(..., 3)``, for the body rate ``w``, body axes [rad/s]."""
    scale = 0.25 - 0.25 * _dot(sigma, sigma)
    return scale * w + 0.5 * (cross(sigma, w) + _dot(sigma, w) * sigma)


def mrp_curvature(sigma: FloatArray, sigma_dot: FloatArray, w: FloatArray) -> FloatArray:
    """Return ``G' w`` [1/s^2], shape ``(..., 3)``, the part of ``sigma'' = G' w + G w'`` at constant rate.

    The arguments, shape ``(..., 3)``, are the MRP of the body, its derivative [1/s], and the body rate, body axes
    [rad/s].
    """
    along = _dot(sigma, w) * sigma_dot + _dot(sigma_dot, w) * sigma - _dot(sigma, sigma_dot) * w
    return 0.5 * (cross(sigma_dot, w) + along)


def angular_velocity_from_mrp(sigma: FloatArray, sigma_dot: FloatArray) -> FloatArray:
    """Return the body rate ``w = G^-1 sigma'``, body axes [rad/s], shape ``(..., 3)``, for ``sigma_dot`` [1/s]."""
    root = 4.0 / (1.0 + _dot(sigma, sigma))
    return root * root * mrp_derivative(-sigma, sigma_dot)


def angular_acceleration_from_mrp(sigma: FloatArray, sigma_dot: FloatArray, sigma_ddot: FloatArray) -> FloatArray:
    """Return ``w' = G^-1 (sigma'' - G' w)``, body axes [rad/s^2], shape ``(..., 3)``; exact.

    The arguments, shape ``(..., 3)``, are the MRP of the body, its first [1/s] and its second [1/s^2] derivative.
    """
    w = angular_velocity_from_mrp(sigma, sigma_dot)
    return angular_velocity_from_mrp(sigma, sigma_ddot - mrp_curvature(sigma, sigma_dot, w))


def mrp_error(attitude_mrp: FloatArray, reference_mrp: FloatArray) -> FloatArray:
    """Return the short-branch MRP of ``q_e = conj(q_d) (x) q``, shape ``(..., 3)``; no singularity on any branch.

    The MRPs of body and reference frame, shape ``(..., 3)``, short or shadow, are relative to the same inertial frame.
    """
    attitude_squared, reference_squared = _dot(attitude_mrp, attitude_mrp), _dot(reference_mrp, reference_mrp)
    a, r = 1.0 - attitude_squared, 1.0 - reference_squared
    vector = r * attitude_mrp - a * reference_mrp + 2.0 * cross(attitude_mrp, reference_mrp)
    scalar = 0.5 * a * r + 2.0 * _dot(attitude_mrp, reference_mrp)
    norm = 0.5 * (1.0 + attitude_squared) * (1.0 + reference_squared)  # |[scalar, vector]|
    return vector / (scalar + np.copysign(norm, scalar))


def random_quaternion_from_uniforms(u: FloatArray) -> FloatArray:
    """Return attitudes ``(..., 4)``, ``q0 >= 0``, uniform over all rotations (Shoemake) from uniforms ``(..., 3)``.

    Raises
    ------
    ValueError
        If any uniform lies outside [0, 1).
    """
    if not ((u >= 0.0) & (u < 1.0)).all():
        raise ValueError("random_quaternion_from_uniforms: every uniform must lie in [0, 1)")
    angle = 2.0 * np.pi * u[..., 1:]
    radius = np.sqrt(np.stack((1.0 - u[..., 0], u[..., 0]), axis=-1))
    return canonical(np.concatenate((radius * np.sin(angle), radius * np.cos(angle)), axis=-1))
