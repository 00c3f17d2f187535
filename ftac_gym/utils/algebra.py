"""Compiled algebra of triples and quaternions, scalar first: tuples, which the compiler holds in registers.

The order of the operations is part of the results, and so is the compiler's choice of fused ones.
"""

import math
from typing import Any

from ftac_gym.utils.compiling import inlined


@inlined
def row3(array: Any, row: int) -> Any:
    """Return the first three entries of a row."""
    return array[row, 0], array[row, 1], array[row, 2]


@inlined
def row4(array: Any, row: int) -> Any:
    """Return the first four entries of a row."""
    return array[row, 0], array[row, 1], array[row, 2], array[row, 3]


@inlined
def store3(out: Any, row: int, a: Any) -> None:
    """Write a triple into a row."""
    out[row, 0], out[row, 1], out[row, 2] = a[0], a[1], a[2]


@inlined
def unit(q: Any) -> Any:
    """Return a quaternion, normalised."""
    scale = 1.0 / math.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    return scale * q[0], scale * q[1], scale * q[2], scale * q[3]


@inlined
def store4(out: Any, row: int, a: Any) -> None:
    """Write a quadruple into a row."""
    out[row, 0], out[row, 1], out[row, 2], out[row, 3] = a[0], a[1], a[2], a[3]


@inlined
def store_unit(out: Any, row: int, q: Any) -> None:
    """Write a quaternion, normalised, into a row."""
    scale = 1.0 / math.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    out[row, 0], out[row, 1], out[row, 2], out[row, 3] = scale * q[0], scale * q[1], scale * q[2], scale * q[3]


@inlined
def add3(a: Any, factor: float, b: Any) -> Any:
    """Return a + factor b for triples."""
    return a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]


@inlined
def add4(a: Any, factor: float, b: Any) -> Any:
    """Return a + factor b for quadruples."""
    return a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2], a[3] + factor * b[3]


@inlined
def scale3(factor: float, a: Any) -> Any:
    """Return factor a."""
    return factor * a[0], factor * a[1], factor * a[2]


@inlined
def norm3(a: Any) -> float:
    """Return the magnitude ``|a|``."""
    return math.sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2])


@inlined
def cross3(a: Any, b: Any) -> Any:
    """Return a x b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@inlined
def symmetric_times(matrix: Any, a: Any) -> Any:
    """Return the product of a symmetric matrix (xx, yy, zz, xy, xz, yz) and a triple."""
    return (
        matrix[0] * a[0] + matrix[3] * a[1] + matrix[4] * a[2],
        matrix[3] * a[0] + matrix[1] * a[1] + matrix[5] * a[2],
        matrix[4] * a[0] + matrix[5] * a[1] + matrix[2] * a[2],
    )


@inlined
def quaternion_product(a: Any, b: Any) -> Any:
    """Return the Hamilton product a (x) b."""
    return (
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] + a[2] * b[0] + a[3] * b[1] - a[1] * b[3],
        a[0] * b[3] + a[3] * b[0] + a[1] * b[2] - a[2] * b[1],
    )


@inlined
def relative_quaternion(reference: Any, attitude: Any, row: int) -> Any:
    """Return the attitude in a row relative to the reference: conjugate(reference) (x) attitude, of either sign."""
    inverse = reference[row, 0], -reference[row, 1], -reference[row, 2], -reference[row, 3]
    return quaternion_product(inverse, row4(attitude, row))


@inlined
def rotation_change(scalar: float, e: Any, a: Any) -> Any:
    """Return C(q) a - a = 2 (e x (e x a) - scalar e x a) for the quaternion q = (scalar, e)."""
    c = cross3(e, a)
    d = cross3(e, c)
    return 2.0 * (d[0] - scalar * c[0]), 2.0 * (d[1] - scalar * c[1]), 2.0 * (d[2] - scalar * c[2])


@inlined
def rotation(turn: Any) -> Any:
    """Return the quaternion of a rotation vector [rad]."""
    angle = norm3(turn)
    # sin(angle / 2) / angle, by its series where the quotient would lose digits.
    factor = math.sin(0.5 * angle) / angle if angle > 1e-4 else 0.5 - angle * angle / 48.0
    return math.cos(0.5 * angle), factor * turn[0], factor * turn[1], factor * turn[2]
